"""How late a wrench is against its pose by the clocks, where that is more than any filter does."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.payload.sensor_motion import SensorMotion

Array = NDArray[np.float64]


def clock_offset(
    motion: SensorMotion, wrench: Array, gravity: Array, std: Array, criteria: Moving = USUAL
) -> tuple[float, float] | None:
    """Seconds by which the wrench (T, 6) is late, as the best rigid body says, and the mean square that is left there,
    in units of std (6,) [N, N·m]. None where the log is too short to tell. motion: T samples; gravity: (3,) in {B}."""
    every, time = 4, motion.time  # samples: enough for a body
    period = float(np.median(np.diff(time)))
    most = round(min(criteria.farthest_clock_s, (time[-1] - time[0]) / 4.0) / period)
    at = np.arange(most, len(time) - most, every)
    if most < 1 or 6 * len(at) < 20 * 16:
        return None
    part = motion.rows(np.isin(np.arange(len(time)), at))
    A = np.concatenate([part.regressor(gravity), np.broadcast_to(np.eye(6), (len(at), 6, 6))], axis=2) / std[:, None]
    root = np.linalg.qr(A.reshape(-1, 16))[0]
    lags = np.arange(-most, most + 1)
    left = np.empty(len(lags))
    for k, lag in enumerate(lags):
        b = (wrench[at + lag] / std).ravel()
        left[k] = (b @ b - np.sum((root.T @ b) ** 2)) / len(b)
    best = int(np.argmin(left))
    return float(lags[best]) * period, float(left[best])
