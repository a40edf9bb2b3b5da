"""Numbers that decide: each with a reason and a source that exists, each in use, and few others beside them."""

import ast
import re
from dataclasses import fields, replace
from pathlib import Path

import pytest
from tests.criteria.tables import DOCUMENT, with_tables

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.criterion import listed

ROOT = Path(__file__).parents[2]
HOUSE = ROOT / "server" / "exogauge"
NUMERICS = (
    "logs", "estimation", "robots", "effects", "devices", "identification", "support", "payload", "detect", "search",
    "findings", "experiment", "plausibility",
)  # fmt: skip
MOST_NUMBERS = 120  # at module level in the numerics; it may only fall


def numbers_at_module_level():
    """`path: NAME` of every name that a module of the numerics binds to numbers."""
    return [
        f"{file.relative_to(HOUSE)}: {name}"
        for package in NUMERICS
        for file in sorted((HOUSE / package).rglob("*.py"))
        for statement in ast.parse(file.read_text(encoding="utf-8")).body
        for name in bound_to_numbers(statement)
    ]


def bound_to_numbers(statement):
    if isinstance(statement, ast.Assign):
        target = statement.targets[0]
    elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
        target = statement.target
    else:
        return []
    if not is_number(statement.value):
        return []
    return [ast.unparse(each) for each in (target.elts if isinstance(target, ast.Tuple) else [target])]


def is_number(node):
    match node:
        case ast.Constant(value=value):
            return isinstance(value, int | float) and not isinstance(value, bool)
        case ast.UnaryOp(operand=operand):
            return is_number(operand)
        case ast.BinOp(left=left, right=right):
            return is_number(left) and is_number(right)
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            return bool(elements) and all(is_number(each) for each in elements)
    return False


def test_numbers_at_module_level_become_fewer():
    found = numbers_at_module_level()
    assert len(found) <= MOST_NUMBERS, found


@pytest.mark.parametrize(("text", "count"), [
    ("A = 1.0", 1), ("A, B = 2, -3e4", 2), ("A: int = 1 << 20", 1), ("A = (1, 2.0)", 1), ("A = 'x'", 0),
    ("A = f(1)", 0), ("A = True", 0), ("A: int", 0), ("A = ()", 0),
])  # fmt: skip
def test_what_counts_as_a_number(text, count):
    (statement,) = ast.parse(text).body
    assert len(bound_to_numbers(statement)) == count


def test_every_criterion_says_why_and_whence():
    for each in listed(Criteria()):
        assert len(each.why.split()) >= 4, each.name
        assert each.unit, each.name
        assert each.source.where, each.name
        for document in re.findall(r"[\w/.-]+\.md", each.source.where):
            assert (ROOT / document).exists(), each.name


def test_every_criterion_is_asked_by_some_rule():
    asking = [file for file in HOUSE.rglob("*.py") if HOUSE / "criteria" not in file.parents or "judging" in file.name]
    asked = {name for file in asking for name in re.findall(r"\.(\w+)", file.read_text(encoding="utf-8"))}
    assert not [each.name for each in listed(Criteria()) if each.name.rpartition(".")[2] not in asked]


def test_no_two_criteria_share_a_name():
    names = [each.name for each in listed(Criteria())]
    assert len(set(names)) == len(names)


def test_a_run_may_have_other_numbers():
    usual = Criteria()
    stricter = replace(usual, judging=replace(usual.judging, sure=4.0))
    differ = {one.name for one, other in zip(listed(usual), listed(stricter), strict=True) if one.value != other.value}
    assert differ == {"judging.sure"}


def test_what_is_needed_of_steady_motion_is_as_many_blocks_as_are_judged():
    judging = replace(Criteria().judging, block_s=2.0, fewest_blocks=7)
    assert judging.needed_s == 14.0


def test_the_tables_of_the_document_are_those_of_the_criteria():
    written = DOCUMENT.read_text(encoding="utf-8")
    assert written == with_tables(written), "make tables"


def test_every_part_is_frozen():
    for each in fields(Criteria):
        with pytest.raises(AttributeError):
            setattr(Criteria(), each.name, None)
