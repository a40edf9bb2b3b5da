"""What differs between two documents: names first, then numbers by how far they moved, then sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tests.gate.walk import Leaf, is_sentence, leaves

NOTHING = 1e-12  # in SI units: below it results.json holds rounding errors of zero, and no physical quantity
ABSENT = "absent"


@dataclass(frozen=True)
class Change:
    """by: relative change of a number, infinite where it came, went, or stopped being one; None of names and words."""

    path: str
    before: Leaf
    after: Leaf
    by: float | None = None


@dataclass(frozen=True)
class Difference:
    """names: of what is called, decided, present. numbers: all that moved at all, the farthest first."""

    names: tuple[Change, ...]
    numbers: tuple[Change, ...]
    sentences: tuple[Change, ...]
    compared: int

    def beyond(self, rtol: float) -> tuple[Change, ...]:
        return tuple(change for change in self.numbers if (change.by or 0.0) > rtol)


def difference(before: Any, after: Any) -> Difference:
    a, b = leaves(before), leaves(after)
    names = [*_present_in_one(a, b, gone=True), *_present_in_one(b, a, gone=False)]
    numbers, sentences = [], []
    compared = 0
    for path in (path for path in a if path in b):
        one, other = a[path], b[path]
        if path.endswith("[order]") and sorted(str(one).split(", ")) != sorted(str(other).split(", ")):
            continue  # entries came or went, which their own leaves say
        if _is_number(one) and _is_number(other):
            compared += 1
            by = _moved(one, other, max(_doubt(a, path), _doubt(b, path)))
            if by > 0.0:
                numbers.append(Change(path, one, other, by))
        elif one == other and type(one) is type(other):
            continue
        elif path.endswith("[order]") or not (is_sentence(one) or is_sentence(other)):
            names.insert(0, Change(path, one, other))
        else:
            sentences.append(Change(path, one, other))
    numbers.sort(key=lambda change: -(change.by or 0.0))
    return Difference(tuple(names), tuple(numbers), tuple(sentences), compared)


def _present_in_one(these: Mapping[str, Leaf], those: Mapping[str, Leaf], gone: bool) -> list[Change]:
    """One change for all that is called alike from where both documents part: a finding, a section, a key."""
    known = {above for path in those for above in _above(path)}
    found: dict[str, list[Leaf]] = {}
    for path, leaf in these.items():
        if path not in those:
            first = next((above for above in _above(path) if above not in known), path)
            found.setdefault(first, []).append(leaf)
    held = {path: leaf[0] if len(leaf) == 1 else f"{len(leaf)} entries" for path, leaf in found.items()}
    return [Change(path, *((leaf, ABSENT) if gone else (ABSENT, leaf))) for path, leaf in held.items()]


def _above(path: str) -> list[str]:
    """`a`, `a.b`, `a.b[c d]`, `a.b[c d].e` of the last: names in brackets may hold dots and brackets of their own."""
    found, depth = [], 0
    for k, character in enumerate(path):
        if depth == 0 and character in ".[" and k:
            found.append(path[:k])
        depth += (character == "[") - (character == "]")
    return [*found, path]


def _is_number(leaf: Leaf) -> bool:
    return isinstance(leaf, int | float) and not isinstance(leaf, bool)


def _moved(before: Any, after: Any, doubt: float) -> float:
    """Relative to the larger of both, or to the standard deviation that stands beside them."""
    if math.isnan(before) or math.isnan(after):
        return 0.0 if math.isnan(before) and math.isnan(after) else math.inf
    if before == after:
        return 0.0
    if not (math.isfinite(before) and math.isfinite(after)):
        return math.inf
    scale = max(abs(before), abs(after), doubt)
    return 0.0 if scale < NOTHING else float(abs(after - before) / scale)


def _doubt(document: Mapping[str, Leaf], path: str) -> float:
    """[of the value's unit] An offset of 1e-9 ± 0.1 that becomes 2e-9 did not double."""
    if not path.endswith(".value"):
        return 0.0
    std = document.get(path.removesuffix("value") + "std")
    return float(std) if isinstance(std, float) and math.isfinite(std) else 0.0
