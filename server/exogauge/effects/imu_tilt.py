"""The IMU of a floating base is mounted at another angle than stated; told as `base_tilt`, as of a base that leans."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.base_tilt import MOST, left_jacobian
from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, BaseChange, BaseSignals
from exogauge.effects.shaped import Shape


@final
class ImuTilt:
    """All that the IMU reads is turned by δ: f_true = exp(δ) f = f + V (δ × f), likewise ω and its rate. V as
    `BaseTilt` has it, at the turn that was found so far.

    The base's origin is r = -r_imu away from it, so a = f - ω̇ × r_imu - ω × (ω × r_imu) changes with all three.
    Feet that measure forces along all axes show it: m a = ΣF, and what stands still has ΣF = m g up, whatever the mass
    and its centre are, so m g δ of force across is nobody else's. δ_z shows only while the base leans or is pushed.
    """

    name = "base_tilt"
    words = "a tilted base"
    place = "base"
    sentence = "The base's IMU stands at an angle that nobody stated, or all that measures the feet's forces does."
    coefficients = (
        Quantity("about_x", "rad", -MOST, MOST, words="turn about the base's x axis"),
        Quantity("about_y", "rad", -MOST, MOST, words="turn about the base's y axis"),
        Quantity("about_z", "rad", -MOST, MOST, words="turn about the base's z axis"),
    )
    shapes: tuple[Shape, ...] = ()
    confounds = ("zero", "leg encoders")
    needs = "Lean and turn the base over its feet both ways, and load one foot after the other."
    coordinate = "time"

    def changes(self, signals: BaseSignals, shape: tuple[float, ...]) -> list[BaseChange]:
        still = signals.acc, signals.gyro, signals.gyro_dot
        if not self.applies(signals):
            return [_nothing(signals.acc)] * 3
        V = left_jacobian(signals.turn)
        return [turned(axis, *still, signals.imu_at, V) for axis in np.eye(3)]

    def applies(self, signals: BaseSignals) -> bool:
        return signals.floating and signals.feet_feel and len(signals.time) > 0


def turned(delta: Array, acc: Array, gyro: Array, gyro_dot: Array, imu_at: Array, V: Array | None = None) -> BaseChange:
    """By how much the base moves otherwise than an IMU says that is turned by delta: (3,) [rad], first order in it.

    acc, gyro, gyro_dot: (T, 3) of the base, as computed from it; imu_at: (3,) [m]. V: (3, 3) what is left of the turn
    is small beside; none: the whole turn is.
    """
    r, w = imu_at, gyro
    f = acc + np.cross(gyro_dot, r) + np.cross(w, np.cross(w, r))
    onto = np.eye(3) if V is None else V.T
    df, dw, dw_dot = (np.cross(delta, each) @ onto for each in (f, w, gyro_dot))
    at_origin = df - np.cross(dw_dot, r) - np.cross(dw, np.cross(w, r)) - np.cross(w, np.cross(dw, r))
    return BaseChange(at_origin, dw, dw_dot)


def _nothing(like: Array) -> BaseChange:
    still = np.zeros_like(like)
    return BaseChange(still, still, still)


EFFECT = ImuTilt()
