"""One axis in several logs: what a description lacks it lacks in all of them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np

from exogauge.plausibility.axis_fit import GAINS, Likelihood
from exogauge.plausibility.expectation import Expected


def pooled(expected: Sequence[Expected], axis: int, sign: float = 1.0, *, near: bool = False) -> Likelihood:
    """Of one axis over all logs in which it moves, with one factor for all. sign: of the effort. near: to one."""
    telling = [one.likelihood(axis, sign, near=near) for one in expected if one.tells(axis)]
    return together(telling, expected[0].seen.criteria.as_good_as)


def without_the_worst(expected: Sequence[Expected], axis: int) -> list[Expected]:
    """Those in which it moves. What one of three logs or more asks for alone is not wrong in all of them."""
    own = [each for each in expected if each.tells(axis)]
    if len(own) < 3:
        return own
    worst = max(own, key=lambda each: each.likelihood(axis).any - each.likelihood(axis).described)
    return [each for each in own if each is not worst]


def stands_out(one: Expected, others: Sequence[Expected], axis: int) -> bool:
    """Whether far more of its effort is left in this log than in any other, by share and by size: a slow motion is
    left with a larger share, a large one with more. Of three logs or more: of two nobody knows which.
    """
    own = [each for each in others if each.tells(axis)]
    if len(own) < 2 or not one.tells(axis):
        return False
    most = np.max([each.left(axis) for each in own], axis=0)
    return bool(np.all(np.array(one.left(axis)) > one.seen.criteria.others * most))


def together(each: Sequence[Likelihood], as_good_as: float) -> Likelihood:
    """One factor for all logs. What a description lacks it lacks in every log: ten of them count as `as_good_as`."""
    logs = reduce(np.add, (one.logs for one in each), np.zeros(len(GAINS)))
    share = min(1.0, as_good_as / max(1, len(each)))
    return Likelihood(share * logs, max((one.misfit for one in each), default=0.0))
