"""Torque that depends on where the joint is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array


@final
@dataclass(frozen=True)
class JointSpring:
    """A harness: a little stiff everywhere (share), tighter and tighter beyond `taut`; size [N·m] at the range's end.

    side: towards which end it tightens; half: [rad] of the range, about middle.
    """

    middle: float
    half: float
    taut: float
    share: float
    side: float

    name: ClassVar[str] = "joint_spring"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        low, high = float(run.q.min()), float(run.q.max())
        taut, share = float(rng.uniform(-0.4, 0.3)), float(rng.uniform(0.2, 0.4))
        return cls(0.5 * (low + high), 0.5 * (high - low), taut, share, float(rng.choice([-1.0, 1.0])))

    def largest(self, run: AxisRun) -> float:
        return 1.5 * run.drive.tau_c

    def torque(self, run: AxisRun, size: float) -> Array:
        x = self.side * (run.q - self.middle) / self.half
        beyond = np.maximum(x - self.taut, 0.0) / (1.0 - self.taut)
        return np.asarray(size * self.side * (self.share * x + (1.0 - self.share) * beyond**1.6))


@final
@dataclass(frozen=True)
class TorqueRipple:
    """size [N·m] once per motor turn, with a second harmonic, growing with the motor's torque by `by_load`."""

    shift: float
    second: float
    second_shift: float
    by_load: float

    name: ClassVar[str] = "torque_ripple"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        shift, second_shift = rng.uniform(0.0, 2 * np.pi, 2)
        return cls(float(shift), float(rng.uniform(0.15, 0.35)), float(second_shift), float(rng.choice([0.0, 0.25])))

    def largest(self, run: AxisRun) -> float:
        return 0.6 * run.drive.tau_c

    def torque(self, run: AxisRun, size: float) -> Array:
        turn = run.drive.gear * run.q
        wave = np.sin(turn + self.shift) + self.second * np.sin(2.0 * turn + self.second_shift)
        relative = np.abs(run.motor) / np.sqrt(np.mean(run.motor**2))
        return np.asarray(size * wave * (1.0 + self.by_load * (relative - 1.0)))
