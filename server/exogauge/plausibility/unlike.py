"""Axes that do not bear what is described, and no slip that was tried says why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from typing import final

from exogauge.plausibility.axis_fit import Likelihood
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.pooling import pooled, stands_out, without_the_worst


@final
@dataclass(frozen=True)
class Unlike:
    """An axis that does not bear what is described, whatever is tried. left: share of its effort. logs: in which.

    others: the share that is left in the other logs, where these stand out against them alone; else None.
    """

    axis: int
    left: float
    logs: tuple[str, ...]
    others: float | None = None


def unlike_axes(expected: Sequence[Expected], touched: Set[tuple[int, str]]) -> Iterator[Unlike]:
    """touched: (axis, log) of which a slip is told."""
    for axis in range(len(expected[0].robot.joints) if expected else 0):
        own = [each for each in expected if each.tells(axis) and (axis, each.seen.log) not in touched]
        everywhere = bool(own) and _asks_for_other_bodies(pooled(without_the_worst(own, axis), axis), own)
        found = [each for each in own if everywhere or _is_unlike(each, own, axis)]
        odd = [] if found else [each for each in own if _is_odd(each, own, axis)]
        if logs := found or odd:
            usual = max(each.left(axis)[0] for each in own if each not in odd) if odd else None
            left = max(each.likelihood(axis).misfit for each in logs)
            yield Unlike(axis, left, tuple(each.seen.log for each in logs), usual)


def _is_unlike(each: Expected, own: Sequence[Expected], axis: int) -> bool:
    """Too much is left; or bodies have to be off by far more than stated, which odd friction does not ask for, and not
    in a short or slow log alone, in which as little is left as in others.
    """
    found, others = each.likelihood(axis), [one for one in own if one is not each]
    odd = len(others) < 2 or stands_out(each, others, axis)
    return found.misfit > each.seen.criteria.unlike or (odd and _asks_for_other_bodies(found, own))


def _asks_for_other_bodies(found: Likelihood, own: Sequence[Expected]) -> bool:
    return found.any - found.described > own[0].seen.criteria.decisive


def _is_odd(each: Expected, own: Sequence[Expected], axis: int) -> bool:
    others = [one for one in own if one is not each]
    return each.left(axis)[0] > each.seen.criteria.misfit and stands_out(each, others, axis)
