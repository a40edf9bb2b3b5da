"""Two runs of one motion subtracted, sample by sample at the same posture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.support.balance import Balance
from exogauge.support.same_motion import Match

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Difference:
    """This run minus the other at the same posture; NaN where the other has none, and where one is left out.

    torque: (T, D) [N·m] of what the model leaves unexplained; other: (T, D) what the other run leaves unexplained.
    compared: (T, D) both move steadily with the same friction. same: (T, D) the friction is the same, steady or not.
    rest: (T, D) sum of both runs' shares at rest. nearest: (T,) sample of the other run.
    """

    torque: Array
    other: Array
    compared: BoolArray
    same: BoolArray
    rest: Array
    nearest: NDArray[np.intp]


def difference(this: Balance, other: Balance, found: Match) -> Difference:
    """Approach A in full: both runs' unexplained torque, subtracted after alignment.

    Implements [Evaluator] (3). Differs from print: with the difference of the contact forces and of Y_j φ, so that
    the feet may be loaded differently and the motions need not be equal to the last digit (equations.md).
    """
    since = this.time - this.time[0] + found.lag_s
    clock = other.time - other.time[0]
    covered = np.zeros(len(since), dtype=np.bool_)
    covered[found.first : found.last] = True
    covered &= ~this.left_out
    at = np.clip(since, 0.0, clock[-1])
    nearest = np.clip(np.round(np.interp(at, clock, np.arange(len(clock)))).astype(np.intp), 0, len(clock) - 1)
    covered &= ~other.left_out[nearest]
    theirs = np.where(
        covered[:, None], np.asarray(scipy.interpolate.make_interp_spline(clock, other.torque, k=3)(at)), np.nan
    )
    alike = this.sign == other.sign[nearest]
    same = np.stack([np.all(alike[:, axes], axis=1) for axes in this.acts], axis=1)
    return Difference(
        torque=this.torque - theirs,
        other=theirs,
        compared=covered[:, None] & this.steady & other.steady[nearest] & same,
        same=same,
        rest=this.rest + other.rest[nearest],
        nearest=nearest,
    )
