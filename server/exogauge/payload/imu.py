"""An accelerometer on the sensor: how its axes lie, and how late its stamps are, both found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.payload_static import USUAL, Standing

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class ImuFrame:
    """rotation: (3, 3) R_sensor_imu. bias: (3,) [m/s²] in {S}. gain: (3,) scale of the axes, 1 where right. rms: [m/s²]
    left in the postures. lag_s: how late its stamps are, and lag_std_s."""

    rotation: Array
    bias: Array
    gain: Array
    rms: float
    lag_s: float = 0.0
    lag_std_s: float = 0.0

    def in_sensor(self, acceleration: Array) -> Array:
        """(T, 3) proper acceleration in {S}, from the IMU's own axes."""
        return np.asarray(acceleration @ self.rotation.T + self.bias)

    @property
    def angle(self) -> float:
        """[rad] between its axes and the sensor's."""
        return float(np.arccos(np.clip((np.trace(self.rotation) - 1.0) / 2.0, -1.0, 1.0)))


def find_axes(acceleration: Array, rotation: Array, gravity: Array) -> ImuFrame:
    """acceleration: (K, 3) [m/s²] means in postures R_BS (K, 3, 3); gravity: (3,) [m/s²] in {B}."""
    up = -np.einsum("kji,j->ki", rotation, gravity)
    columns = np.column_stack([acceleration, np.ones(len(acceleration))])
    X = np.linalg.lstsq(columns, up)[0]
    U, gain, Vt = np.linalg.svd(X[:3].T)
    turn = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    bias = (up - acceleration @ turn.T).mean(axis=0)
    rms = float(np.sqrt(np.mean((acceleration @ turn.T + bias - up) ** 2)))
    return ImuFrame(turn, bias, gain, rms)


def find_lag(frame: ImuFrame, rows: Callable[[float], list[Array]], criteria: Standing = USUAL) -> ImuFrame:
    """The lag at which wrenches are explained best. rows: [A b] (T, 6, n+1) of each log, for the lag [s] taken off."""

    def left(lag: float) -> tuple[float, int]:
        return _left(rows(lag))

    latest, beside = criteria.latest_imu_s, criteria.beside_imu_s
    best = scipy.optimize.minimize_scalar(lambda lag: np.divide(*left(lag)), bounds=(-latest, latest), method="bounded",
                           options={"xatol": 1e-4})  # fmt: skip
    lag = float(best.x)
    around = np.array([lag - beside, lag, lag + beside])
    square, count = np.array([left(each) for each in around]).T
    curve = np.polyfit(around - lag, square, 2)[0]
    spread = float(np.sqrt(square[1] / (count[1] / criteria.repeated) / curve)) if curve > 0 else latest
    return replace(frame, lag_s=lag, lag_std_s=spread)


def farther_lag(found: ImuFrame, rows: Callable[[float], list[Array]], criteria: Standing = USUAL) -> float | None:
    """[s] a lag beyond those that `find_lag` looks at, by tens of milliseconds, that explains wrenches clearly better
    than the one it found at its end; None where it found one inside, or none is better."""
    latest, step, most = criteria.latest_imu_s, 0.02, 0.5
    if abs(found.lag_s) < 0.95 * latest:
        return None
    lags = np.sign(found.lag_s) * np.arange(latest + step, most, step)
    each = [float(np.divide(*_left(rows(float(lag))))) for lag in lags]
    best = int(np.argmin(each))
    better = each[best] * criteria.clearly < float(np.divide(*_left(rows(found.lag_s))))
    return float(lags[best]) if better else None


def _left(parts: list[Array]) -> tuple[float, int]:
    """Square of what rows [A b] of each log leave of b, and how many they are."""
    square, count = 0.0, 0
    for z in parts:
        A, b = z.reshape(-1, z.shape[2])[:, :-1], z[:, :, -1].ravel()
        scale = np.maximum(np.linalg.norm(A, axis=0), 1e-12)
        x = np.linalg.lstsq(A / scale, b, rcond=1e-6)[0]
        square, count = square + float(np.sum((A / scale @ x - b) ** 2)), count + len(b)
    return square, count
