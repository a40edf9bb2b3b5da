"""A package says in its docstring what stands in it: a list that leaves nothing out and names nothing that is gone."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import exogauge

SOURCE = Path(exogauge.__file__).parent
LISTS = re.compile(r"^- .*$", re.MULTILINE)


def listed(package: Path) -> set[str]:
    """Names in the lines of its list."""
    told = ast.get_docstring(ast.parse((package / "__init__.py").read_text(encoding="utf-8"))) or ""
    return {name for line in LISTS.findall(told) for name in re.findall(r"`([a-z_0-9]+)`", line)}


WITH_A_LIST = sorted(each.parent for each in SOURCE.rglob("__init__.py") if listed(each.parent))


@pytest.mark.parametrize("package", WITH_A_LIST, ids=lambda each: str(each.relative_to(SOURCE)))
def test_a_list_of_contents_is_true(package: Path) -> None:
    files = {each.stem for each in package.glob("*.py")} - {"__init__"}
    folders = {each.parent.name for each in package.glob("*/__init__.py")}
    assert listed(package) == files | folders
