"""Axes that do not bear what is described, and no slip that was tried says why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from typing import final

from exogauge.criteria.examining import Comparing
from exogauge.plausibility.axis_fit import Likelihood
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.pooling import pooled


@final
@dataclass(frozen=True)
class Unlike:
    """An axis that does not bear what is described, whatever is tried. left: share of its effort. logs: in which."""

    axis: int
    left: float
    logs: tuple[str, ...]


def unlike_axes(expected: Sequence[Expected], touched: Set[tuple[int, str]]) -> Iterator[Unlike]:
    """touched: (axis, log) of which a slip is told."""
    for axis in range(len(expected[0].robot.joints) if expected else 0):
        own = [each for each in expected if each.tells(axis) and (axis, each.seen.log) not in touched]
        everywhere = bool(own) and _is_unlike(pooled(own, axis), own[0].seen.criteria)
        found = {each.seen.log: each.likelihood(axis) for each in own}
        logs = [log for log, each in found.items() if everywhere or _is_unlike(each, own[0].seen.criteria)]
        if logs:
            yield Unlike(axis, max(found[log].misfit for log in logs), tuple(logs))


def _is_unlike(found: Likelihood, criteria: Comparing) -> bool:
    """Too much is left, or bodies have to be off by far more than stated, which odd friction does not ask for."""
    return found.misfit > criteria.unlike or found.any - found.described > criteria.decisive
