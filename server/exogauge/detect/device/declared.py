"""What stands above the noise of the supporting torque, and no further than declared doubts of the wear let it stand.

A via point that is known to 5 mm bends what a band does by some tenths of a newton metre: no law is missing there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from exogauge.detect.device.baseline import Ground
from exogauge.findings.result import Excess, WithinDeclared
from exogauge.support.band_inputs import BandInputs
from exogauge.support.band_model import Fitted, Setting

Array = NDArray[np.float64]


def within_declared(ground: Ground, e: Array, excesses: Sequence[Excess], prefix: str) -> WithinDeclared:
    """Those channels, `prefix` and the joint, that stand at their floors once the wear sits as suits them best, within
    what is declared. e: (N, D) [N·m] of what was left out of the fit, NaN where it does not count."""
    if not excesses:
        return WithinDeclared()
    judging = ground.model.criteria.judging
    left, done = _left_by_inputs(ground.setting, ground.fitted, e, judging.declared_most)
    at_floor = {
        f"{prefix}{name}"
        for name, rmse, floor in zip(ground.joints, left, ground.floor, strict=True)
        if rmse < judging.above * floor
    }
    within = tuple(each for each in excesses if each.channel in at_floor)
    told = [name for name in done if done[name] >= judging.declared_told * sum(done.values()) > 0.0]
    return WithinDeclared(within, tuple(sorted(told, key=lambda name: -done[name])) if within else ())


def _left_by_inputs(setting: Setting, fitted: Fitted, e: Array, most: float) -> tuple[Array, dict[str, float]]:
    """(D,) [N·m] RMS of e: (N, D), NaN where it does not count, with those inputs and springs that suit it best, each
    input as likely as it is declared and no further than so many standard deviations; and what each kind of them does
    to it, weighed."""
    few = BandInputs(setting, fitted)
    moves = list(few.torques())
    own = few.residual(e)
    used = np.isfinite(own) & (few.weight > 0.0)
    if not moves or not used.any():
        return _rms(own), {}
    columns, springs = np.stack([torque for _, torque in moves], axis=2), few.columns.shape[2]
    rows = np.concatenate([few.columns, columns], axis=2)
    root = np.sqrt(few.weight[used])
    prior = np.eye(rows.shape[2])[springs:]
    size = np.maximum(np.sqrt(np.sum((rows[used] * root[:, None]) ** 2, axis=0)), 1e-300)
    size[springs:] = 1.0
    A = np.concatenate([rows[used] * root[:, None] / size, prior])
    y = np.concatenate([own[used] * root, np.zeros(len(prior))])
    bound = np.where(np.arange(rows.shape[2]) < springs, np.inf, most)
    x = lsq_linear(A, y, (-bound, bound)).x / size
    done = dict.fromkeys((name for name, _ in moves), 0.0)
    for (name, torque), u in zip(moves, x[springs:], strict=True):
        done[name] += float(np.sum(few.weight[used] * (u * torque[used]) ** 2))
    return _rms(np.where(used, own - rows @ x, np.nan)), done


def _rms(e: Array) -> Array:
    """(D,) of what is not NaN; 0 where all is."""
    return np.asarray(np.sqrt(np.nansum(e**2, axis=0) / np.maximum(np.isfinite(e).sum(axis=0), 1)))
