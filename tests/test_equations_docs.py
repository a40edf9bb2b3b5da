"""docs/equations.md: every test that it names exists, and those of our code run it."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PRINTED = "tests/identification/test_printed_equations.py"  # of the last column, which runs no code of ours
NUMERICS = ("logs", "estimation", "robots", "effects", "identification", "devices", "support", "payload", "discrepancy")
RECORDS = ("logs.model", "robots.description", "devices.device", "identification.settings")  # hold, compute nothing

Cited = tuple[str, str]
"""File, name of the test."""


def cells_of(line: str) -> list[str]:
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def cited(cell: str, file: str) -> list[Cited]:
    """Tests in a cell; one without a file is in the file of the one before."""
    found = []
    for named in re.findall(r"`((?:tests/[\w/.]+\.py(?:: )?)?(?:test_\w+)?)`", cell):
        path, _, test = named.rpartition(": ")
        file = path or (file if test.startswith("test_") else test)
        if test.startswith("test_"):
            found.append((file, test))
        elif named.endswith(".py"):
            found.append((named, ""))
    return found


def citations() -> tuple[list[Cited], list[Cited], list[str]]:
    """Tests of our code, tests of the print, and rows of equations without a test of our code."""
    ours: list[Cited] = []
    printed: list[Cited] = []
    lacking: list[str] = []
    default = ""
    text = (ROOT / "docs/equations.md").read_text(encoding="utf-8")
    for line in text.splitlines():
        if not line.startswith("|"):
            ours += cited(line, default) if "`tests/" in line and ": test_" in line else []
            continue
        row = cells_of(line)
        in_header = re.search(r"tests?, in `(tests/[\w/.]+)`", line)
        if in_header:
            default = in_header[1]
        elif row[0].startswith("[Evaluator]"):
            of_ours = cited(row[3], "")
            ours, printed = ours + of_ours, printed + cited(row[4], PRINTED)
            lacking += [] if of_ours else [row[0]]
        else:
            ours += cited(row[-1], default)
    return ours, printed, lacking


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def names_in(node: ast.AST) -> set[str]:
    used = {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}
    arguments = {each.arg for each in ast.walk(node) if isinstance(each, ast.arg)}
    return used | arguments


@cache
def known_in(path: Path) -> tuple[dict[str, ast.AST], dict[str, str]]:
    """What a file defines by name, and what it imports: name -> module."""
    defined: dict[str, ast.AST] = {}
    imported: dict[str, str] = {}
    for node in tree(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            defined[node.name] = node
            for decorator in node.decorator_list:  # @pytest.fixture(name="…")
                for keyword in getattr(decorator, "keywords", []):
                    if keyword.arg == "name" and isinstance(keyword.value, ast.Constant):
                        defined[str(keyword.value.value)] = node
        elif isinstance(node, ast.Assign):
            defined |= {target.id: node for target in node.targets if isinstance(target, ast.Name)}
        elif isinstance(node, ast.ImportFrom) and node.module:
            imported |= {alias.asname or alias.name: node.module for alias in node.names}
        elif isinstance(node, ast.Import):
            imported |= {alias.asname or alias.name: alias.name for alias in node.names}
    return defined, imported


def runs_our_code(path: Path, name: str, seen: frozenset[Cited] = frozenset()) -> bool:
    """Whether a function of a test file, or a fixture or helper that it asks for, uses a name of the numerics."""
    if (str(path), name) in seen:
        return False
    seen |= {(str(path), name)}
    defined, imported = known_in(path)
    if name in imported:
        module = imported[name]
        if module.startswith("exogauge."):
            inside = module.removeprefix("exogauge.")
            return inside.split(".")[0] in NUMERICS and inside not in RECORDS
        helper = ROOT / (module.replace(".", "/") + ".py")
        return module.startswith("tests.") and helper.is_file() and runs_our_code(helper, name, seen)
    if name in defined:
        return any(runs_our_code(path, each, seen) for each in names_in(defined[name]) - {name})
    above = path.parent.parent if path.name == "conftest.py" else path.parent
    fixture = above / "conftest.py"
    return above.is_relative_to(ROOT / "tests") and fixture.is_file() and runs_our_code(fixture, name, seen)


def test_every_equation_has_a_test_of_our_code() -> None:
    ours, printed, lacking = citations()
    assert len(ours) > 60
    assert len(printed) > 20
    assert not lacking


@pytest.mark.parametrize("column", [0, 1])
def test_every_test_that_is_named_exists(column: int) -> None:
    for file, name in citations()[column]:
        assert (ROOT / file).is_file(), file
        assert not name or name in known_in(ROOT / file)[0], f"{file}: {name}"


def test_every_test_of_our_code_runs_it() -> None:
    without = [(file, name) for file, name in citations()[0] if name and not runs_our_code(ROOT / file, name)]
    assert not without


def test_what_is_known_without_our_code_uses_none_of_it() -> None:
    assert not [name for file, name in citations()[1] if runs_our_code(ROOT / file, name)]
