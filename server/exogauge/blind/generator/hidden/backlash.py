"""Play, or a spring, between motor and link."""

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
    link on it, damping ratio), which pulls by `harder` more where it gives way as far as under the usual landing
    (`Harder`): two masses, simulated with implicit steps. Gravity's slope acts on the shifted link.
    """

    frequency: float
    damping: float
    harder: float
    bend: float

    name: ClassVar[str] = "backlash"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        frequency, damping, harder = (float(x) for x in rng.uniform([25.0, 0.15, 0.1], [45.0, 0.4, 0.5]))
        return cls(frequency, damping, harder, float(rng.uniform(0.5, 1.5)))

    def largest(self, run: AxisRun) -> float:
        return 0.02

    def torque(self, run: AxisRun, size: float) -> Array:
        omega, inertia = 2 * np.pi * self.frequency, float(run.inertia.mean())
        usual = float(np.sqrt(np.mean(run.load**2)))
        give = np.sqrt(2.0 * usual * size / inertia) / omega  # with the speed that the usual load gives it in the gap
        return two_masses(run, omega**2 * inertia, self.damping, 0.5 * size, Harder(self.harder, give, self.bend))


@final
@dataclass(frozen=True)
class Elasticity:
    """The encoder sits at the motor; a spring to the link gives way by size [s²] times what the load is over the link's
    mean inertia, so that the link swings at 1 / (2 pi sqrt(size)). At the largest load it pulls by `harder` more
    (`Harder`).
    """

    damping: float
    harder: float
    bend: float

    name: ClassVar[str] = "elasticity"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(0.1, 0.3)), float(rng.uniform(0.1, 0.4)), float(rng.uniform(0.5, 1.5)))

    def largest(self, run: AxisRun) -> float:
        return (2 * np.pi * 5.0) ** -2

    def torque(self, run: AxisRun, size: float) -> Array:
        k = float(run.inertia.mean()) / size
        give = float(np.abs(run.load).max()) / k
        return two_masses(run, k, self.damping, 0.0, Harder(self.harder, give, self.bend))


@final
@dataclass(frozen=True)
class Harder:
    """A spring that pulls by `share` more at `give` [rad] than if it were straight; that grows as e^(bend · way)."""

    share: float
    give: float
    bend: float

    def factor(self, over: Array) -> Array:
        """What it pulls over what it would."""
        return np.asarray(1.0 + self.share * np.expm1(self.bend * np.abs(over) / self.give) / np.expm1(self.bend))


def two_masses(run: AxisRun, k: float, damping: float, half: float, harder: Harder) -> Array:
    """(L, T) [N·m] that the link's own movement r beyond the motor asks: I r_ddot + K r, from
    I r_ddot = tooth - load - K r.

    k: [N·m/rad] of the tooth or spring; half: [rad] of the gap.
    A mean over each sample's time, as a current controller shows it: landings are shorter than a sample.
    """
    step, logs, samples = 1.0 / (RATE_HZ * SUBSTEPS), *run.q.shape
    inertia = run.inertia
    c = 2.0 * damping * np.sqrt(k * float(inertia.mean()))
    friction = 0.02 * c
    r = -np.sign(run.load[:, 0]) * half - run.load[:, 0] / k
    v = np.zeros(logs)
    rise = np.diff(run.load, axis=1, append=run.load[:, -1:]) / SUBSTEPS
    out = np.zeros((logs, samples))
    for n in range(samples):
        I, K, load = inertia[:, n], run.stiffness[:, n], run.load[:, n]  # noqa: E741
        for _ in range(SUBSTEPS):
            over = r - np.minimum(np.maximum(r, -half), half)
            touching = over != 0.0
            now = k * harder.factor(over)
            damped = c * touching + friction
            pull = now * (over + step * v * touching) + damped * v + load + K * (r + step * v)
            acc = -pull / (I + step * friction + step**2 * K + (step * c + step**2 * now) * touching)
            out[:, n] += (I * acc + K * r) / SUBSTEPS
            v = v + step * acc
            r = r + step * v
            load = load + rise[:, n]
    return out
