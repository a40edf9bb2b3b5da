"""One cause on every joint is one finding: a delay of the whole drive, not six."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.discrepancy.result import Finding, Place

ALL = "all"
FEWEST = 3  # joints
SHARED = ("torque_delay",)  # effects that the drives have in common: one bus, one filter
MOST = 0.5  # of the joints


def merged(findings: Sequence[Finding], joints: int) -> tuple[Finding, ...]:
    """Findings of a shared effect on at least half of the joints become one, at the place of the first."""
    result: list[Finding] = []
    for name in dict.fromkeys(each.effect for each in findings):
        same = [each for each in findings if each.effect == name]
        if name in SHARED and len(same) >= max(FEWEST, MOST * joints):
            where = ", ".join(each.place.name for each in same)
            sentence = f"All joints alike ({where}): {same[0].sentence}"
            result.append(replace(same[0], place=Place("joint", ALL), sentence=sentence))
        else:
            result += same
    ordered = sorted(result, key=lambda each: each.rank)
    return tuple(replace(each, rank=number) for number, each in enumerate(ordered, 1))
