"""What docs/effects.md says of an effect of one's own, done to the letter on a copy of the sources."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COPIED = ("server", "tests", "docs")
WHICH = "tests/effects/test_which_effect.py"


@pytest.fixture
def recipe(docs_section) -> str:
    return "\n".join(docs_section("An effect of your own, in one file"))


@pytest.fixture
def copy(tmp_path, recipe) -> Path:
    """The sources after step 1: one file more."""
    unwanted = shutil.ignore_patterns("__pycache__", "static", "node_modules")
    for folder in COPIED:
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=unwanted)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    place = re.search(r"1\. Write `([\w/.]+)`", recipe)
    assert place is not None
    example = recipe.split("```python\n", 1)[1].split("```", 1)[0]
    (tmp_path / place[1]).write_text(example, encoding="utf-8")
    return tmp_path


def tried(copy: Path, *which: str) -> tuple[int, str]:
    path = os.pathsep.join([str(copy / "server"), str(copy)])
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *which],
        cwd=copy, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True,
    )  # fmt: skip
    return done.returncode, done.stdout


@pytest.mark.slow
def test_one_file_keeps_the_contract(copy: Path) -> None:
    """Step 2."""
    code, said = tried(copy, "tests/effects/test_every_shaped_effect.py", "-k", "cogging or affordable or bear")
    assert code == 0, said


def test_every_file_that_the_recipe_names_is_there(recipe: str) -> None:
    named = re.findall(r"`((?:tests|server|effects|studies)/[\w/]+\.py)", recipe)
    assert len(named) > 3
    for path in named:
        inside = ROOT / path if path.startswith(("tests", "server")) else ROOT / "server/exogauge" / path
        assert inside.is_file() or path == "server/exogauge/effects/cogging.py", path


@pytest.mark.slow
def test_what_is_missing_to_publish_it_is_named_and_is_all_that_is_missing(copy: Path, recipe: str) -> None:
    """Step 4: what fails before its lines are written passes after them."""
    named = (
        "tests/effects/test_effects_docs.py::test_every_effect_is_in_the_docs_with_its_own_words",
        "tests/studies/discrepancy/test_sentences.py::test_every_effect_that_can_be_found_missing_has_words",
        f"{WHICH}::test_it_ranks_first_on_a_motion_that_shows_it[cogging]",
        f"{WHICH}::test_the_docs_say_of_every_effect_what_a_motion_shows",
        f"{WHICH}::test_what_looks_alike_is_in_the_docs_and_nothing_else_does[rich]",
    )
    code, said = tried(copy, *named)
    assert code == 1
    assert f"{len(named)} failed" in said, said
    publish(copy, recipe)
    code, said = tried(copy, *named)
    assert code == 0, said


def publish(copy: Path, recipe: str) -> None:
    words = {"sentence": r'sentence = "(.+)"', "needs": r'needs = "(.+)"', "confounds": r"confounds = \((.+)\)"}
    own = {name: re.search(pattern, recipe)[1] for name, pattern in words.items()}  # type: ignore[index]
    confounds = ", ".join(f"`{each}`" for each in re.findall(r'"(\w+)"', own["confounds"]))
    formula = re.search(r'`("cogging": lambda j: .+,)`', recipe)
    shown = re.search(r"\(for this one: ([\w, ]+)\)", recipe)
    leaves = re.search(r"leaves of it\s+(\d+ %), (\d+ %), (\d+ %) and (\d+ %)", recipe)
    assert formula
    assert shown
    assert leaves
    after(copy / "server/exogauge/effects/words.py", "EFFECTS = {\n", '    "cogging": "cogging of the motor",\n')
    after(copy / "tests/studies/discrepancy/test_sentences.py", 'CONTRACT = """\n', "cogging ")
    after(copy / WHICH, "FRICTION = {\n", f"    {formula[1]}\n")
    docs = copy / "docs/effects.md"
    row(docs, "What a model may miss", f"| `cogging` | {own['sentence']} | {own['needs']} | {confounds} |")
    row(docs, "What a motion shows", f"| `cogging` | {' | '.join(shown[1].split(', '))} |")
    row(docs, "What looks alike", f"| `cogging` | `torque_ripple` | {' | '.join(leaves.groups())} |")


def after(path: Path, mark: str, text: str) -> None:
    before = path.read_text(encoding="utf-8")
    assert before.count(mark) == 1, path
    path.write_text(before.replace(mark, mark + text), encoding="utf-8")


def row(docs: Path, heading: str, line: str) -> None:
    """A row more in the table below a heading."""
    text = docs.read_text(encoding="utf-8")
    start = text.index("|---", text.index(f"## {heading}\n"))
    end = text.index("\n", start) + 1
    docs.write_text(text[:end] + line + "\n" + text[end:], encoding="utf-8")
