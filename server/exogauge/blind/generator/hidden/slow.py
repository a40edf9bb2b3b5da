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
