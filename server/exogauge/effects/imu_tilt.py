"""The IMU of a floating base is mounted at another angle than stated; told as `base_tilt`, as of a base that leans."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.base import Array, BaseChange, BaseSignals
from exogauge.effects.base_tilt import MOST
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape


@final
class ImuTilt:
    """All that the IMU reads is turned by a small rotation δ, first order: f_true = f + δ × f, likewise ω and its rate.

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
        r, w, w_dot = signals.imu_at, signals.gyro, signals.gyro_dot
        f = signals.acc + np.cross(w_dot, r) + np.cross(w, np.cross(w, r))
        return [self._turned(axis, f, w, w_dot, r) if self.applies(signals) else _nothing(f) for axis in np.eye(3)]

    def applies(self, signals: BaseSignals) -> bool:
        return signals.floating and signals.feet_feel and len(signals.time) > 0

    def _turned(self, delta: Array, f: Array, w: Array, w_dot: Array, r: Array) -> BaseChange:
        df, dw, dw_dot = (np.cross(delta, each) for each in (f, w, w_dot))
        acc = df - np.cross(dw_dot, r) - np.cross(dw, np.cross(w, r)) - np.cross(w, np.cross(dw, r))
        return BaseChange(acc, dw, dw_dot)


def _nothing(like: Array) -> BaseChange:
    still = np.zeros_like(like)
    return BaseChange(still, still, still)


EFFECT = ImuTilt()
