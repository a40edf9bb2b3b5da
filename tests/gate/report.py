"""What moved between two trees, as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tests.gate.difference import Change, Difference
from tests.gate.walk import Leaf

SHOWN = 25  # lines of each sort; the rest is counted
WIDEST = 60  # characters of a value


def report(found: Mapping[str, Difference], rtol: float) -> str:
    """found: case -> difference. Names, the farthest moves, changed sentences, one line per case, a sum."""
    names = [(case, change) for case, each in found.items() for change in each.names]
    moves = [(case, change) for case, each in found.items() for change in each.numbers]
    words = [(case, change) for case, each in found.items() for change in each.sentences]
    moves.sort(key=lambda each: -(each[1].by or 0.0))
    lines = [
        *_listed("names and verdicts that changed", names),
        *_listed("numbers that moved, the farthest first", moves),
        *_listed("sentences that changed (not counted as a difference)", words),
        "",
        *(_case_line(case, each, rtol) for case, each in found.items()),
        "",
        f"{len(found)} cases, {sum(each.compared for each in found.values())} numbers: {len(names)} names changed, "
        f"{len(moves)} numbers moved, {sum(len(each.beyond(rtol)) for each in found.values())} of them by more than "
        f"{rtol:g}; {len(words)} sentences changed",
    ]
    return "\n".join(lines)


def is_same(found: Mapping[str, Difference], rtol: float) -> bool:
    return not any(each.names or each.beyond(rtol) for each in found.values())


def _listed(title: str, changes: Sequence[tuple[str, Change]]) -> list[str]:
    if not changes:
        return []
    lines = ["", f"{title}:"]
    for case, change in changes[:SHOWN]:
        by = "" if change.by is None else f"   {change.by:.1e}"
        lines.append(f"  {case}  {change.path}: {_value(change.before)} -> {_value(change.after)}{by}")
    if len(changes) > SHOWN:
        lines.append(f"  … and {len(changes) - SHOWN} more")
    return lines


def _value(leaf: Leaf) -> str:
    text = repr(leaf)
    return text if len(text) <= WIDEST else f"{text[:WIDEST]}…"


def _case_line(case: str, each: Difference, rtol: float) -> str:
    farthest = each.numbers[0].by if each.numbers else 0.0
    return (
        f"{case:24s} {each.compared:6d} numbers, {len(each.names)} names changed, {len(each.numbers)} moved, "
        f"{len(each.beyond(rtol))} beyond, farthest {farthest:.1e}"
    )
