"""What stands above the noise of the supporting torque, and no further than declared doubts of the wear let it stand.

A via point that is known to 5 mm bends what a band does by some tenths of a newton metre: no law is missing there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.baseline import Ground
from exogauge.findings.result import Excess, WithinDeclared
from exogauge.support.band_inputs import left_by_inputs

Array = NDArray[np.float64]


def within_declared(ground: Ground, e: Array, excesses: Sequence[Excess], prefix: str) -> WithinDeclared:
    """Those channels, `prefix` and the joint, that stand at their floors once the wear sits as suits them best, within
    what is declared. e: (N, D) [N·m] of what was left out of the fit, NaN where it does not count."""
    if not excesses:
        return WithinDeclared()
    judging = ground.model.criteria.judging
    left, done = left_by_inputs(ground.setting, ground.fitted, e, judging.declared_most)
    at_floor = {
        f"{prefix}{name}"
        for name, rmse, floor in zip(ground.joints, left, ground.floor, strict=True)
        if rmse < judging.above * floor
    }
    within = tuple(each for each in excesses if each.channel in at_floor)
    told = [name for name in done if done[name] >= judging.declared_told * sum(done.values()) > 0.0]
    return WithinDeclared(within, tuple(sorted(told, key=lambda name: -done[name])) if within else ())
