"""What touches the payload: the wrench that is left when its weight and inertia are taken out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from exogauge.payload.dynamics import regressor_slopes
from exogauge.payload.sensor_motion import SensorMotion

Array = NDArray[np.float64]

FARTHEST_ZERO = np.pi / 3  # beyond, a zero taken before is worse than none: |δm| g 2 sin(θ/2) > |δm| g
ZERO_S = 0.5  # averaged for the secondary zero
BRIDGED_S = 0.05  # between two alarms of one contact


@final
@dataclass(frozen=True)
class Compensation:
    """x: (16,) [m, m c, I, F_0] and its (16, 16) covariance; gravity (3,) [m/s²] in {B}; sign s; std (6,) of wrench.

    Implements [Payload] (1), (4), (44).
    """

    x: Array
    covariance: Array
    gravity: Array
    sign: int
    std: Array

    def external(self, motion: SensorMotion, wrench: Array) -> Array:
        """(T, 6) F_ext = F_raw - F_0 - s A Φ, as the sensor would read it. wrench: (T, 6) as read."""
        left: Array = wrench - self.x[10:] - self.sign * motion.regressor(self.gravity) @ self.x[:10]
        return left

    def spread(self, motion: SensorMotion) -> Array:
        """(T, 6, 6) covariance of `external` without contact: noise of sensor and kinematics, parameters."""
        A = self.sign * motion.regressor(self.gravity)
        full = np.concatenate([A, np.broadcast_to(np.eye(6), (len(A), 6, 6))], axis=2)
        slopes = np.einsum("ktip,p->tik", regressor_slopes(motion.omega), self.x[:10])
        by_motion = slopes @ motion.noise
        own = full @ self.covariance @ np.swapaxes(full, 1, 2)
        out: Array = own + by_motion @ np.swapaxes(by_motion, 1, 2) + np.diag(self.std**2)
        return out

    def force_threshold(self, motion: SensorMotion, false_alarms_per_sample: float) -> tuple[Array, float]:
        """(T,) [N] force that counts as contact in its least certain direction, and the limit of fᵀ C⁻¹ f."""
        limit = float(chi2.isf(false_alarms_per_sample, 3))
        largest = np.linalg.eigvalsh(self.spread(motion)[:, :3, :3])[:, -1]
        return np.sqrt(limit * largest), limit

    def contacts(self, motion: SensorMotion, wrench: Array, false_alarms_per_hour: float) -> list[tuple[float, float]]:
        """Spans (from, to) [s] in which the force is more than noise, so many of them wrong per hour."""
        period = float(np.median(np.diff(motion.time)))
        _, limit = self.force_threshold(motion, false_alarms_per_hour * period / 3600.0)
        f = self.external(motion, wrench)[:, :3]
        C = self.spread(motion)[:, :3, :3]
        alarm = np.einsum("ti,ti->t", f, np.linalg.solve(C, f[:, :, None])[:, :, 0]) > limit
        return spans(motion.time, alarm, BRIDGED_S)


def second_zero(motion: SensorMotion, external: Array, gravity: Array) -> tuple[Array, NDArray[np.bool_]]:
    """(T, 6) F_ext minus its mean over the first half second, and (T,) where that still helps: gravity within 60°.

    Implements [Payload] (44), with an average in place of one sample.
    """
    first = motion.time <= motion.time[0] + ZERO_S
    down = np.einsum("tji,j->ti", motion.rotation, gravity / np.linalg.norm(gravity))
    then = down[first].mean(axis=0)
    helps = down @ (then / np.linalg.norm(then)) >= np.cos(FARTHEST_ZERO)
    return external - external[first].mean(axis=0), helps


def spans(time: Array, flag: NDArray[np.bool_], bridged: float) -> list[tuple[float, float]]:
    """(from, to) of the runs of a flag, those closer than `bridged` [s] as one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flag.astype(np.int8), [0]])))
    out: list[tuple[float, float]] = []
    for a, b in edges.reshape(-1, 2):
        start, end = float(time[a]), float(time[b - 1])
        if out and start - out[-1][1] <= bridged:
            out[-1] = (out[-1][0], end)
        else:
            out.append((start, end))
    return out
