"""Between the motor's torque and the current that the log reports.

Torque that depends on where the joint is. A motor that turns with two joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from scipy.signal import lfilter

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array, Change, Where
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.scene import Scene


@final
@dataclass(frozen=True)
class KtSaturation:
    """At `full` [N·m], the most this motor gave, it took the share `size` more current; below, by |T/full|^power."""

    full: float
    power: float

    name: ClassVar[str] = "kt_saturation"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = True

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(np.quantile(np.abs(run.motor), 0.999)), float(rng.choice([1.4, 2.6, 3.2])))

    def largest(self, run: AxisRun) -> float:
        return 0.3

    def torque(self, run: AxisRun, size: float) -> Array:
        return np.asarray(size * run.motor * np.abs(run.motor / self.full) ** self.power)


@final
@dataclass(frozen=True)
class TorqueDelay:
    """The current is logged size [s] late; or, with lag, through a first-order filter of that time constant."""

    lag: bool

    name: ClassVar[str] = "torque_delay"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = True

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(bool(rng.uniform() < 0.4))

    def largest(self, run: AxisRun) -> float:
        return 0.04

    def torque(self, run: AxisRun, size: float) -> Array:
        return late(run.motor, size, self.lag) - run.motor


def late(values: Array, delay: float, lag: bool) -> Array:
    """(L, T) delayed; before the log began nothing had changed."""
    if lag:
        keep = float(np.exp(-1.0 / (RATE_HZ * delay)))
        filtered, _ = lfilter([1.0 - keep], [1.0, -keep], values, axis=1, zi=keep * values[:, :1])
        return np.asarray(filtered)
    time = np.arange(values.shape[1]) / RATE_HZ
    return np.array([np.interp(time - delay, time, row) for row in values])


@final
@dataclass(frozen=True)
class KtGain:
    """The log says the share size too much of the torque (sign 1), or too little: another k_T than is stated."""

    sign: float

    name: ClassVar[str] = "kt_gain"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = True

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.choice([-1.0, 1.0])))

    def largest(self, run: AxisRun) -> float:
        return 0.2

    def torque(self, run: AxisRun, size: float) -> Array:
        return np.asarray(self.sign * size * run.motor)


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


_USUAL_RATIO = 0.6  # share of motors that turn as far with the other joint as with their own


@final
@dataclass(frozen=True)
class Coupling:
    """Friction of size [N·m] on a motor that turns with joint `own`, and `ratio` times as far with the one it hangs on.

    tanh(w/creep) of it, w the motor's speed, comes of dry friction; `viscous` and `inertial` times as much is in
    proportion to w and to its rate, each over its own root mean square.
    """

    own: int
    other: int
    ratio: float
    creep: float
    viscous: float
    inertial: float

    name: ClassVar[str] = "coupling"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [
            {"joint": name} for name, parent in zip(scene.joints, scene.robot.tree.parent, strict=True) if parent >= 0
        ]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        own = scene.joints.index(str(where["joint"]))
        far = 1.0 if rng.uniform() < _USUAL_RATIO else float(rng.uniform(0.4, 1.6))
        ratio = far * float(rng.choice([-1.0, 1.0]))
        creep, viscous = (float(each) for each in rng.uniform([0.02, 0.3], [0.1, 1.0]))
        inertial = float(rng.uniform(0.1, 0.4)) if rng.uniform() < 0.5 else 0.0
        return cls(own, scene.robot.tree.parent[own], ratio, creep, viscous, inertial)

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 0.6 * min(scene.runs[joint].drive.tau_c for joint in (self.own, self.other))

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        w, rate = (x[:, :, self.own] + self.ratio * x[:, :, self.other] for x in (scene.motion.dq, scene.motion.ddq))
        needed = size * (np.tanh(w / self.creep) + self.viscous * w / _rms(w) + self.inertial * rate / _rms(rate))
        torque = np.zeros(scene.motion.q.shape)
        torque[:, :, self.own], torque[:, :, self.other] = needed, self.ratio * needed
        return Change(torque, None)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
