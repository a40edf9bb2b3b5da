"""What changes over seconds and minutes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array


@final
@dataclass(frozen=True)
class ThermalViscous:
    """Viscous friction falls with temperature: k_d (1 - size tanh((T - middle) / width)), [°C]."""

    middle: float
    width: float

    name: ClassVar[str] = "thermal_viscous"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(np.median(run.temperature)), float(rng.uniform(10.0, 16.0)))

    def largest(self, run: AxisRun) -> float:
        return 0.65

    def torque(self, run: AxisRun, size: float) -> Array:
        return np.asarray(-size * run.drive.k_d * np.tanh((run.temperature - self.middle) / self.width) * run.dq)


@final
@dataclass(frozen=True)
class TorqueOffsetDrift:
    """After it is switched on at a log's beginning, the amplifier's offset moves by size t / (t + settling) [N·m]."""

    settling: float
    sign: float

    name: ClassVar[str] = "torque_offset_drift"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(8.0, 40.0)), float(rng.choice([-1.0, 1.0])))

    def largest(self, run: AxisRun) -> float:
        return 1.2 * run.drive.tau_c

    def torque(self, run: AxisRun, size: float) -> Array:
        drift = self.sign * size * run.time / (run.time + self.settling)
        return np.broadcast_to(drift, run.q.shape).copy()


@final
@dataclass(frozen=True)
class FrictionShift:
    """From log `since` on there is size [N·m] more Coulomb friction (sign 1) or less, and viscous friction with it:
    `viscous` of it at 1 rad/s, by |v|^power."""

    since: int
    sign: float
    viscous: float
    power: float

    name: ClassVar[str] = "friction_shift"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        viscous, power = rng.uniform([0.2, 0.85], [0.6, 1.2])
        return cls(int(rng.integers(2, 4)), float(rng.choice([-1.0, 1.0])), float(viscous), float(power))

    def largest(self, run: AxisRun) -> float:
        return 0.7 * min(run.drive.tau_c, run.drive.k_d / self.viscous)

    def torque(self, run: AxisRun, size: float) -> Array:
        change = self.sign * size * run.direction * (1.0 + self.viscous * np.abs(run.dq) ** self.power)
        change[: self.since] = 0.0
        return np.asarray(change)
