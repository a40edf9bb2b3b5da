"""The numerics say what they find as data: sentences are made in `studies/words`, and read by nobody but people.

What raises an error says itself what is wrong and what to do; the doctor (`logs`, `plausibility`) and the files of
effects have words of their own, beside a code.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import exogauge

SOURCE = Path(exogauge.__file__).parent
NUMERICS = (
    "estimation", "robots", "devices", "identification", "support", "findings", "search", "detect", "experiment",
)  # fmt: skip
WORDS_OF_A_SENTENCE = 5
ALLOWED = {
    ("robots/consistency.py", "violations"),  # what `PhysicallyImpossible` says
    ("devices/routing.py", "_link_advice"),  # what its `Fault` says
    ("robots/export.py", "_body_elements"),  # a comment in the file that it writes
}
READS = {
    "search", "match", "fullmatch", "findall", "finditer", "split", "sub", "partition", "rpartition", "startswith",
    "endswith", "removeprefix", "removesuffix",
}  # fmt: skip
SENTENCES = re.compile(r"message|sentence|warning|phrase|reason|detail\b|advice")
NOT_OURS = {
    "api/guard.py", "api/idempotency.py",  # messages of the web server
    "studies/device_pages/change_text.py", "studies/intake/yaml_file.py",  # pydantic's: its first words are cut off
}  # fmt: skip
PAGE_READS = re.compile(
    r"(?:message|sentence|warning|phrase|reason)\w*\)?\.(?:match|split|replace|startsWith|includes|search)\("
    r"|\.(?:exec|test)\([^)]*(?:message|sentence|warning|phrase|reason|detail)\b"
)
OF_ANYBODY = ("PageError.tsx", "ProblemBox.tsx", "Findings.tsx")  # a browser's words; a capital and a full stop


def text_of(node: ast.AST) -> str:
    """What a string or an f-string says, its values left out."""
    if isinstance(node, ast.JoinedStr):
        return " ".join(str(each.value) for each in node.values if isinstance(each, ast.Constant))
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def is_sentence(text: str) -> bool:
    return sum(word.strip("(),.:;?!").isalpha() for word in text.split()) >= WORDS_OF_A_SENTENCE


def may_speak(node: ast.AST) -> bool:
    """It raises, or makes the fault that is raised."""
    for each in ast.walk(node):
        if isinstance(each, ast.Raise):
            return True
        if isinstance(each, ast.Call) and isinstance(each.func, ast.Name) and "fault" in each.func.id.lower():
            return True
    return False


def sentences(tree: ast.Module) -> Iterator[tuple[str, int, str]]:
    """(function, line, text) of every sentence of a module that is no documentation and no part of an error."""
    for node in tree.body:
        for part in node.body if isinstance(node, ast.ClassDef) else [node]:
            if may_speak(part):
                continue
            skipped = {id(each.value) for each in ast.walk(part) if isinstance(each, ast.Expr)}
            skipped |= {id(own) for each in ast.walk(part) if isinstance(each, ast.JoinedStr) for own in each.values}
            for each in ast.walk(part):
                if id(each) not in skipped and is_sentence(text_of(each)):
                    yield getattr(part, "name", ""), getattr(each, "lineno", 0), text_of(each)


def reads_a_sentence(node: ast.AST) -> bool:
    """`re.search(…, message)`, `sentence.partition(…)`: a call that takes one of our own sentences apart."""
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in READS):
        return False
    of = [node.func.value, *node.args]
    return any(SENTENCES.search(ast.unparse(each)) for each in of if not isinstance(each, ast.Constant))


@pytest.mark.parametrize("package", NUMERICS)
def test_the_numerics_make_no_sentences(package: str) -> None:
    found = []
    for path in sorted((SOURCE / package).rglob("*.py")):
        name = str(path.relative_to(SOURCE))
        for function, line, text in sentences(ast.parse(path.read_text(encoding="utf-8"))):
            if (name, function) not in ALLOWED:
                found.append(f"{name}:{line} {text}")
    assert not found, "a Remark or a Caveat, and its words in studies/words: " + "; ".join(found)


def test_an_effect_speaks_in_its_words_alone() -> None:
    """`words`, `sentence`, `needs` and the words of its numbers stand in its class; what it computes says nothing."""
    found = []
    for path in sorted((SOURCE / "effects").glob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found += [(path.name, function) for function, _, _ in sentences(tree) if function]
    assert found == [("order.py", "since_log"), ("order.py", "one_log")]  # each makes a shape, with its words


def test_the_rule_sees_a_warning_and_lets_an_error_speak() -> None:
    documented = '"""Says that it is not much of one, and of what."""'
    warns = f"def f(n):\n    {documented}\n    return [f'Of {{n}} joints there is little to fit.']"
    raises = "def f(n):\n    raise ValueError(f'Of {n} joints there is little to fit.')"
    assert [line for _, line, _ in sentences(ast.parse(warns))] == [3]
    assert not list(sentences(ast.parse(raises)))


@pytest.mark.slow
def test_nothing_reads_our_own_sentences() -> None:
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        name = str(path.relative_to(SOURCE))
        text = path.read_text(encoding="utf-8")
        if name in NOT_OURS or not SENTENCES.search(text):
            continue
        tree = ast.parse(text)
        found += [f"{name}: {ast.unparse(each)}" for each in ast.walk(tree) if reads_a_sentence(each)]
    assert not found, "give it as data beside the sentence: " + "; ".join(found)


def test_the_page_reads_no_sentence_of_the_server() -> None:
    page = SOURCE.parents[1] / "web" / "src"
    if not page.is_dir():
        pytest.skip("the page's source is not here")
    found = []
    for path in sorted([*page.rglob("*.ts"), *page.rglob("*.tsx")]):
        lines = path.read_text(encoding="utf-8").splitlines() if path.name not in OF_ANYBODY else []
        found += [f"{path.name}: {line.strip()}" for line in lines if PAGE_READS.search(line)]
    assert not found
    assert PAGE_READS.search("/unexpected error/.test(detail)")
    assert PAGE_READS.search('message.startsWith("writing")')
