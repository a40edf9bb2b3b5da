"""An accelerometer on the sensor: its axes, gains and bias, found by the postures."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_static import USUAL, Standing

Array = NDArray[np.float64]


@final
class Open:
    """Where they stand in what is left open of an IMU: [lag, place, matrix row by row, bias]."""

    LAG, PLACE, AXES, BIAS = 0, slice(1, 4), slice(4, 13), slice(13, 16)
    SIZE = 16


@final
@dataclass(frozen=True)
class ImuFrame:
    """rotation: (3, 3) R_sensor_imu, nearest to matrix: (3, 3) that takes what is read to {S}. bias: (3,) [m/s²] in
    {S}. gain: (3,) scale of the axes, 1 where right. rms: [m/s²] left in the postures. lag_s: how late its stamps are.
    place: (3,) [m] in {S}. covariance: (16, 16) of [lag, place, matrix, bias]."""

    rotation: Array
    bias: Array
    gain: Array
    rms: float
    matrix: Array
    lag_s: float = 0.0
    place: Array = field(default_factory=lambda: np.zeros(3))
    covariance: Array = field(default_factory=lambda: np.zeros((Open.SIZE, Open.SIZE)))

    @property
    def angle(self) -> float:
        """[rad] between its axes and the sensor's."""
        return float(np.arccos(np.clip((np.trace(self.rotation) - 1.0) / 2.0, -1.0, 1.0)))

    @property
    def lag_std_s(self) -> float:
        return float(np.sqrt(self.covariance[Open.LAG, Open.LAG]))

    @property
    def place_std(self) -> Array:
        """(3,) [m]"""
        return np.sqrt(np.diag(self.covariance)[Open.PLACE])

    @property
    def root(self) -> Array:
        """(16, 16) of its covariance."""
        scale = np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))
        value, vectors = np.linalg.eigh(self.covariance / np.outer(scale, scale))
        return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(value, 0.0)))

    def acceleration(self, read: Array, rate: Array, about: Array) -> tuple[Array, Array]:
        """a - g (T, 3) of the sensor's origin in {S}, and its slopes (T, 3, 16) by what its covariance is of. read,
        rate: (T, 3) in the IMU's axes and its derivative, `lag_s` taken off; about: (T, 3, 3) [α]× + [ω]×²."""
        proper = read @ self.matrix.T + self.bias - about @ self.place
        slopes = np.zeros((len(read), 3, Open.SIZE))
        slopes[:, :, Open.LAG], slopes[:, :, Open.PLACE] = rate @ self.matrix.T, -about
        slopes[:, :, Open.BIAS] = np.eye(3)
        for i in range(3):
            slopes[:, i, 4 + 3 * i : 7 + 3 * i] = read
        return np.asarray(proper), slopes

    def moved(self, by: Array, covariance: Array) -> ImuFrame:
        """by: (16,) that is added."""
        return replace(
            self, lag_s=self.lag_s + float(by[Open.LAG]), place=self.place + by[Open.PLACE],
            matrix=self.matrix + by[Open.AXES].reshape(3, 3), bias=self.bias + by[Open.BIAS], covariance=covariance,
        )  # fmt: skip


def find_axes(acceleration: Array, rotation: Array, gravity: Array, criteria: Standing = USUAL) -> ImuFrame:
    """acceleration: (K, 3) [m/s²] means in postures R_BS (K, 3, 3); gravity: (3,) [m/s²] in {B}.

    The matrix is that of the nearest rotation, as far as gains and skewness are known before, and what postures say.
    """
    up = -np.einsum("kji,j->ki", rotation, gravity)
    columns = np.column_stack([acceleration, np.ones(len(acceleration))])
    X = np.linalg.lstsq(columns, up)[0]
    U, gain, Vt = np.linalg.svd(X[:3].T)
    turn = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    bias = (up - acceleration @ turn.T).mean(axis=0)
    left = up - acceleration @ turn.T - bias
    noise = float(np.sqrt(np.mean(left**2)))
    known = np.diag([criteria.imu_gain**-2.0] * 3 + [0.0])
    for _ in range(2):  # what is left is gains at first
        inverse = np.linalg.inv(columns.T @ columns / noise**2 + known) if noise > 0.0 else np.zeros((4, 4))
        Y = inverse @ columns.T @ left / noise**2 if noise > 0.0 else np.zeros((4, 3))
        free = 1.0 - float(np.trace(inverse @ columns.T @ columns)) / noise**2 / len(up) if noise > 0.0 else 1.0
        rest = left - columns @ Y
        noise = float(np.sqrt(np.mean(rest**2) / max(free, 1.0 / len(up))))
    covariance = np.zeros((Open.SIZE, Open.SIZE))
    for i in range(3):
        at = [4 + 3 * i, 5 + 3 * i, 6 + 3 * i, 13 + i]
        covariance[np.ix_(at, at)] = inverse
    rms = float(np.sqrt(np.mean(left**2)))
    return ImuFrame(turn, bias + Y[3], gain, rms, turn + Y[:3].T, covariance=covariance)
