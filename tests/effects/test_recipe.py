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
ALSO = (  # what else looks at every effect
    "tests/studies/discrepancy/test_sentences.py",
    "tests/studies/discrepancy/test_words.py",
    f"{WHICH}::test_the_docs_say_of_every_effect_what_a_motion_shows",
)


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


@pytest.mark.slow
def test_one_file_and_the_tables_are_all_that_its_contract_asks_for(copy: Path, recipe: str) -> None:
    """Steps 2 and 3: before the tables are made anew the one test that asks for them fails, and no other."""
    (command,) = re.findall(r"^3\. `pytest ([^`]+)`", recipe, re.MULTILINE)
    contract = (*command.split(), *ALSO)
    code, said = tried(copy, *contract)
    assert code == 1
    assert "1 failed" in said, said
    (failed,) = re.findall(r"^FAILED (\S+)", said, re.MULTILINE)
    assert failed.endswith("test_the_tables_of_the_documents_are_those_of_the_catalogue[effects.md]")
    done = run(copy, "-m", "tests.effects.tables")
    assert done.returncode == 0, done.stderr
    assert "`cogging_sin_1` part with the sin of harmonic 1" in (copy / "docs/effects.md").read_text(encoding="utf-8")
    code, said = tried(copy, failed)
    assert code == 0, said


def test_every_file_that_the_document_names_is_there() -> None:
    text = (ROOT / "docs/effects.md").read_text(encoding="utf-8")
    named = re.findall(r"`?((?:tests|server|effects|detect|devices)/[\w/]+(?:\.py|/))", text)
    assert len(named) > 20
    for path in named:
        inside = ROOT / path if path.startswith(("tests", "server")) else ROOT / "server/exogauge" / path
        assert inside.exists() or path == "server/exogauge/effects/cogging.py", path


def run(copy: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(copy / "server"), str(copy)])
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=copy, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True,
    )  # fmt: skip


def tried(copy: Path, *which: str) -> tuple[int, str]:
    done = run(copy, "-m", "pytest", "-q", "-p", "no:cacheprovider", *which)
    return done.returncode, done.stdout
