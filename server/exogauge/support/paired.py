"""The paired estimate: what a run with the device leaves unexplained, less what its partner without it leaves.

    tau_s = r_w - m,    r = Y_j phi - F_j - Z xi,    m = r_wo where both runs move alike

What the model misses in both runs drops out as in approach A; what the runs differ in, the model accounts for as in
approach B. Where they do not move alike the partner's friction is not this run's, so that its rest says nothing of what
the model misses here: m is then the line between the parts that are alike, and at rest this run alone leaves an
interval, as wide as the friction that may hold it. A joint that never moves alike has m = 0: it is B.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.support.at_rest import between_motions, bridged
from exogauge.support.balance import Balance
from exogauge.support.difference import Difference

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Paired:
    """torque: (T, D) [N·m] supporting torque, NaN where the partner has no such moment. middle, half: (T, D) of the
    interval that friction at rest leaves. from_partner: (D,) the partner tells what the model misses."""

    torque: Array
    middle: Array
    half: Array
    from_partner: BoolArray


def paired(this: Balance, other: Balance, apart: Difference, held: Array) -> Paired:
    """held: (D,) [N·m] friction at rest. apart: of the same two runs. (equations.md)"""
    missed = _missed(other, apart, held)
    middle, half = this.torque - missed, this.rest * held
    steady = this.steady & np.isfinite(middle)
    return Paired(bridged(middle, steady, half), middle, half, np.asarray(apart.compared.any(axis=0)))


def _missed(other: Balance, apart: Difference, held: Array) -> Array:
    """(T, D) [N·m] m: the partner's own where both move alike; elsewhere the line between, as far as the partner's
    friction leaves it open; NaN outside of what it holds."""
    open_by = np.where(apart.same, other.rest[apart.nearest] * held, np.inf)
    missed = np.zeros_like(apart.other)
    for joint in range(missed.shape[1]):
        line = between_motions(apart.other[:, joint], apart.compared[:, joint])
        if line is not None:
            own, half = apart.other[:, joint], open_by[:, joint]
            missed[:, joint] = np.where(apart.compared[:, joint], own, np.clip(line, own - half, own + half))
    return np.where(np.isfinite(apart.other), missed, np.nan)
