"""Play between motor and link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array
from exogauge.blind.generator.motion import RATE_HZ

SUBSTEPS = 5  # of one sample


@final
@dataclass(frozen=True)
class Backlash:
    """The encoder sits at the motor; the link is half of size [rad] away, on the side to which its load pushes.

    While the load changes its sign the link flies through the gap and lands on a stiff tooth (frequency [Hz] of the
    link on it, damping ratio): two masses, simulated with implicit steps. Gravity's slope acts on the shifted link.
    """

    frequency: float
    damping: float

    name: ClassVar[str] = "backlash"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(25.0, 45.0)), float(rng.uniform(0.15, 0.4)))

    def largest(self, run: AxisRun) -> float:
        return 0.02

    def torque(self, run: AxisRun, size: float) -> Array:
        """What the link's own movement r beyond the motor asks: I r_ddot + K r, from I r_ddot = tooth - load - K r.

        A mean over each sample's time, as a current controller shows it: landings are shorter than a sample.
        """
        step, logs, samples = 1.0 / (RATE_HZ * SUBSTEPS), *run.q.shape
        inertia = run.inertia
        k = (2 * np.pi * self.frequency) ** 2 * float(inertia.mean())
        c = 2.0 * self.damping * np.sqrt(k * float(inertia.mean()))
        half, friction = 0.5 * size, 0.02 * c
        r = -np.sign(run.load[:, 0]) * half - run.load[:, 0] / k
        v = np.zeros(logs)
        rise = np.diff(run.load, axis=1, append=run.load[:, -1:]) / SUBSTEPS
        out = np.zeros((logs, samples))
        for n in range(samples):
            I, K, load = inertia[:, n], run.stiffness[:, n], run.load[:, n]  # noqa: E741
            resting = I + step * friction + step**2 * K
            for _ in range(SUBSTEPS):
                over = r - np.minimum(np.maximum(r, -half), half)
                touching = over != 0.0
                damping = c * touching + friction
                pull = k * (over + step * v * touching) + damping * v + load + K * (r + step * v)
                acc = -pull / (resting + (step * c + step**2 * k) * touching)
                out[:, n] += (I * acc + K * r) / SUBSTEPS
                v = v + step * acc
                r = r + step * v
                load = load + rise[:, n]
        return out
