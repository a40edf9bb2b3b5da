"""A flat base (x, y, z, then yaw, roll, pitch) as its IMU feels it, and back: exact slopes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Slopes = tuple[Array, Array, Array]

UP = np.array([0.0, 0.0, 9.81])


@final
@dataclass(frozen=True)
class BaseTurn:
    """T samples. angles, rates, accelerations: (T, 3) of yaw, roll, pitch. rotation: (T, 3, 3) R_world_base.

    E: (T, 3, 3) with ω = E rates in the base's axes. by: (3, T, 3, 3) its slopes by the angles; twice: (3, 3, T, 3, 3).
    """

    rates: Array
    accelerations: Array
    rotation: Array
    E: Array
    by: Array
    twice: Array

    @classmethod
    def of(cls, angles: Array, rates: Array, accelerations: Array) -> BaseTurn:
        T = len(angles)
        sy, sr, sp = np.sin(angles).T
        cy, cr, cp = np.cos(angles).T
        o, i = np.zeros(T), np.ones(T)

        def columns(yaw: tuple[Array, ...], roll: tuple[Array, ...], pitch: tuple[Array, ...]) -> Array:
            return np.stack([np.stack(each, axis=-1) for each in (yaw, roll, pitch)], axis=-1)

        none = (o, o, o)
        E = columns((-sp * cr, sr, cp * cr), (cp, o, sp), (o, i, o))
        by, twice = np.zeros((3, T, 3, 3)), np.zeros((3, 3, T, 3, 3))
        by[1] = columns((sp * sr, cr, -cp * sr), none, none)
        by[2] = columns((-cp * cr, o, -sp * cr), (-sp, o, cp), none)
        twice[1, 1] = columns((sp * cr, -sr, -cp * cr), none, none)
        twice[1, 2] = twice[2, 1] = columns((cp * sr, o, sp * sr), none, none)
        twice[2, 2] = columns((sp * cr, o, -cp * cr), (-cp, o, -sp), none)
        R_z = np.stack([cy, -sy, o, sy, cy, o, o, o, i], axis=-1).reshape(T, 3, 3)
        R_x = np.stack([i, o, o, o, cr, -sr, o, sr, cr], axis=-1).reshape(T, 3, 3)
        R_y = np.stack([cp, o, sp, o, i, o, -sp, o, cp], axis=-1).reshape(T, 3, 3)
        return cls(rates, accelerations, R_z @ R_x @ R_y, E, by, twice)

    def felt(self, linear: Array) -> tuple[Array, Array, Array]:
        """(T, 3) each: proper acceleration, angular velocity and acceleration in the base's axes. linear: (T, 3) of
        x, y, z."""
        E_dot = np.einsum("ktij,tk->tij", self.by, self.rates)
        return (
            _to(self.rotation, linear + UP),
            (self.E @ self.rates[..., None])[..., 0],
            (self.E @ self.accelerations[..., None] + E_dot @ self.rates[..., None])[..., 0],
        )

    def by_turn(self, turned: Array) -> Array:
        """(T, 3) slopes by the angles. turned: (T, 3) by a small turn of the base about its own axes."""
        return _to(self.E, turned)

    def back(self, linear: Array, acc: Array, gyro: Array, gyro_dot: Array) -> Slopes:
        """Slopes (T, 6) by the base's coordinates, rates and accelerations, from those by what it feels (T, 3)."""
        felt = _to(self.rotation, linear + UP)
        by_q, by_v, by_a = (np.zeros((len(linear), 6)) for _ in range(3))
        by_a[:, :3] = (self.rotation @ acc[..., None])[..., 0]
        by_q[:, 3:] = self.by_turn(np.cross(acc, felt))
        by_v[:, 3:] = _to(self.E, gyro)
        by_a[:, 3:] = _to(self.E, gyro_dot)
        E_dot = np.einsum("ktij,tk->tij", self.by, self.rates)
        by_v[:, 3:] += _to(E_dot, gyro_dot) + np.einsum("ktij,tj,ti->tk", self.by, self.rates, gyro_dot)
        by_q[:, 3:] += np.einsum("ktij,tj,ti->tk", self.by, self.rates, gyro)
        by_q[:, 3:] += np.einsum("ktij,tj,ti->tk", self.by, self.accelerations, gyro_dot)
        by_q[:, 3:] += np.einsum("kltij,tl,tj,ti->tk", self.twice, self.rates, self.rates, gyro_dot, optimize=True)
        return by_q, by_v, by_a


def _to(matrix: Array, vector: Array) -> Array:
    """(T, n) matrixᵀ vector."""
    return np.asarray(np.einsum("tij,ti->tj", matrix, vector))
