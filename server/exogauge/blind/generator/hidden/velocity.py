"""Friction that depends on the velocity, but not in proportion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array


@final
@dataclass(frozen=True)
class Stribeck:
    """size [N·m] more friction at creeping speed, gone a few v_s [rad/s] later.

    power: of the exponential, neither 1 nor 2; or, with tail, of 1 / (1 + |v/v_s|^power), which fades more slowly.
    """

    v_s: float
    power: float
    tail: bool

    name: ClassVar[str] = "stribeck"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        tail = bool(rng.uniform() < 0.4)
        power = rng.uniform(1.8, 2.6) if tail else rng.choice([rng.uniform(0.7, 0.9), rng.uniform(1.3, 1.7)])
        return cls(float(rng.uniform(0.04, 0.14)), float(power), tail)

    def largest(self, run: AxisRun) -> float:
        return 1.2 * run.drive.tau_c

    def torque(self, run: AxisRun, size: float) -> Array:
        x = np.abs(run.dq / self.v_s) ** self.power
        return np.asarray(size * (1.0 / (1.0 + x) if self.tail else np.exp(-x)) * run.direction)


@final
@dataclass(frozen=True)
class AsymViscous:
    """size [N·m·s/rad] more viscous friction forwards and as much less backwards, at 1 rad/s; power close to 1."""

    power: float
    sign: float

    name: ClassVar[str] = "asym_viscous"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(0.8, 1.25)), float(rng.choice([-1.0, 1.0])))

    def largest(self, run: AxisRun) -> float:
        return 0.7 * run.drive.k_d

    def torque(self, run: AxisRun, size: float) -> Array:
        return np.asarray(self.sign * size * np.abs(run.dq) ** self.power)


@final
@dataclass(frozen=True)
class NonlinearViscous:
    """size [N·m] of friction: atan(|v|/v_n), levelling off; or progressive, (|v|/v_n)^power with power above 2."""

    v_n: float
    power: float  # 0: levelling off

    name: ClassVar[str] = "nonlinear_viscous"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        if rng.uniform() < 0.6:
            return cls(float(rng.uniform(0.25, 0.6)), 0.0)
        return cls(1.0, float(rng.uniform(2.2, 2.8)))

    def largest(self, run: AxisRun) -> float:
        return max(run.drive.tau_c, run.drive.k_d)

    def torque(self, run: AxisRun, size: float) -> Array:
        x = np.abs(run.dq) / self.v_n
        return np.asarray(size * (x**self.power if self.power else np.arctan(x)) * run.direction)
