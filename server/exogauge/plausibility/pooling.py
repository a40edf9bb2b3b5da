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


def together(each: Sequence[Likelihood], as_good_as: float) -> Likelihood:
    """One factor for all logs. What a description lacks it lacks in every log: ten of them count as `as_good_as`."""
    logs = reduce(np.add, (one.logs for one in each), np.zeros(len(GAINS)))
    share = min(1.0, as_good_as / max(1, len(each)))
    return Likelihood(share * logs, max((one.misfit for one in each), default=0.0))
