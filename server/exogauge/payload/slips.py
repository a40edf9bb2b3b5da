"""Units that were stated wrong, and a wrench that is late, as motion tells them.

Forces and moments both hold m c, and must agree on it. By the clocks a wrench may be later than any filter makes it.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.judging import CARRYING as USUAL
from exogauge.criteria.judging import Carrying
from exogauge.criteria.payload_dynamic import USUAL as MOVING
from exogauge.criteria.payload_dynamic import Moving
from exogauge.logs.units import UNITS, units_of
from exogauge.payload.dynamics import Rows
from exogauge.payload.sensor_motion import SensorMotion

Array = NDArray[np.float64]

FORCE, MOMENT = [0, 1, 2, 3, 10, 11, 12], [1, 2, 3, *range(4, 10), 13, 14, 15]  # of x: what either part holds


def moments_over_forces(rows: Rows, criteria: Carrying = USUAL) -> tuple[float, float] | None:
    """How many times m c is larger by the moments than by the forces, and its std; None where motion does not tell."""
    force, moment = _part(rows.z[:, :3], FORCE), _part(rows.z[:, 3:], MOMENT)
    if force is None or moment is None:
        return None
    (f, C_f), (m, C_m) = ((x[first : first + 3], C[first : first + 3, first : first + 3]) for (x, C), first in
                          ((force, 1), (moment, 0)))  # fmt: skip
    size = float(np.linalg.norm(f))
    along = f / size
    ratio = float(f @ m) / size**2
    std = float(np.sqrt(along @ (C_m + ratio**2 * C_f) @ along)) / size
    return (ratio, std) if std < criteria.ratio_known * max(abs(ratio), 1.0) else None


def by_own_noise(rows: Rows, step: Array, criteria: Carrying = USUAL) -> Rows:
    """The same, divided by the noise that each channel shows from sample to sample: what is stated holds for the stated
    unit. Third differences: motion hardly reaches them, nor does rounding to steps (6,) [N, N·m] that lasts."""
    b = rows.z[:, :, -1]
    shown = np.diff(b, 3, axis=0).std(axis=0) / np.sqrt(20.0)
    shown = np.maximum(shown, np.maximum(criteria.least_noise, step / np.sqrt(12.0) / rows.std))
    return replace(rows, z=rows.z / shown[:, None], std=rows.std * shown)


def _part(z: Array, columns: list[int]) -> tuple[Array, Array] | None:
    """Least squares of some rows for some of x, and its covariance; None where they do not decide it."""
    A, b = z[:, :, columns].reshape(-1, len(columns)), z[:, :, -1].ravel()
    scale = np.linalg.norm(A, axis=0)
    if not scale.all() or np.linalg.cond(A / scale) > 1e6:
        return None
    x = np.linalg.lstsq(A / scale, b)[0]
    spread = max(float(np.mean((b - A / scale @ x) ** 2)), 1.0)
    covariance = spread * np.linalg.inv(A.T @ A)
    return np.asarray(x / scale), np.asarray(covariance)


def explained(rows: Rows, ratio: float, misfit: float, above: float) -> bool:
    """Whether moments that are so many times too large leave clearly less than they do as they are, `above` times, and
    what noise leaves, or far less: a cable makes forces and moments disagree too, and no unit mends that. misfit: mean
    square that counts as far."""

    def left(moments: float) -> float:
        A = (rows.z[:, :, :-1] * np.repeat([1.0, moments], 3)[:, None]).reshape(-1, rows.size)
        b = rows.z[:, :, -1].ravel()
        root = np.linalg.qr(A / np.maximum(np.linalg.norm(A, axis=0), 1e-12))[0]
        return float(np.mean((b - root @ (root.T @ b)) ** 2))

    divided, stated = left(ratio), left(1.0)
    return above * divided < stated and (divided < misfit or divided * misfit < stated)


def units_for(ratio: float, std: float, force_unit: str, moment_unit: str) -> str:
    """What to say in place of the stated units, where one other unit explains the ratio. std: of the ratio."""
    found = []
    for key, stated, dimension in (("moment", moment_unit, "torque"), ("force", force_unit, "force")):
        for other, (known, turned) in product(units_of((dimension,)), ((stated, key == "moment"),)):
            share = UNITS[other].factor / UNITS[known].factor if known in UNITS else np.nan
            implied = 1.0 / share if turned else share
            if abs(ratio / implied - 1.0) < max(3.0 * std / abs(ratio), 0.02) and abs(implied - 1.0) > 0.02:
                found.append(f"`sensor.{key}_unit: {other}`")
    return " or ".join(found)


def clock_offset(
    motion: SensorMotion, wrench: Array, gravity: Array, std: Array, criteria: Moving = MOVING
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
