"""Friction that depends on the load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array


@final
@dataclass(frozen=True)
class LoadCoulomb:
    """size: friction per load |l|, plus curve · l² / scale; scale [N·m] is the load's own root mean square."""

    curve: float
    scale: float

    name: ClassVar[str] = "load_coulomb"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(0.1, 0.4)), float(np.sqrt(np.mean(run.load**2))))

    def largest(self, run: AxisRun) -> float:
        return 0.25

    def torque(self, run: AxisRun, size: float) -> Array:
        l = np.abs(run.load)  # noqa: E741
        return np.asarray(size * (l + self.curve * l**2 / self.scale) * run.direction)
