"""What no catalogue has a name for: a joint that is read wrongly, a cable that winds up, friction that wanders, a strap
that slides and returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from scipy.interpolate import PchipInterpolator

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.dynamics import joint_torques
from exogauge.blind.generator.hidden.band import more, named, wear_of
from exogauge.blind.generator.hidden.effect import Array, Change, Where
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.scene import Scene


@final
@dataclass(frozen=True)
class EncoderEccentricity:
    """The disc sits beside the axis: size [rad] too much is read, by sin(q + phase), `second` of it twice per turn."""

    phase: float
    second: float

    name: ClassVar[str] = "encoder_eccentricity"

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Self:
        return cls(float(rng.uniform(0.0, 2.0 * np.pi)), float(rng.uniform(-0.3, 0.3)))

    def limits(self) -> tuple[float, float]:
        return 0.002, 0.04

    def read(self, q: Array, size: float) -> Array:
        """[rad] what the log says of an angle."""
        return np.asarray(q + size * self._waves(q)[0])

    def excess(self, scene: Scene, joint: int, size: float) -> tuple[Array, Array]:
        """(J,) [N·m] of what baselines leave that believe the angle, and that over each joint's noise."""
        motion, shape = scene.motion, scene.motion.q.shape
        wave, slope, bend = (size * each for each in self._waves(motion.q[:, :, joint]))
        q, dq, ddq = (values.copy() for values in (motion.q, motion.dq, motion.ddq))
        q[:, :, joint] += wave
        dq[:, :, joint] *= 1.0 + slope
        ddq[:, :, joint] = (1.0 + slope) * motion.ddq[:, :, joint] + bend * motion.dq[:, :, joint] ** 2
        believed, true = (
            joint_torques(scene.robot.tree, scene.robot.phi, *(x.reshape(-1, shape[2]) for x in moved)).reshape(shape)
            for moved in ((q, dq, ddq), (motion.q, motion.dq, motion.ddq))
        )
        excess = [each.excess(true[:, :, j] - believed[:, :, j]) for j, each in enumerate(scene.baselines)]
        return np.array(excess), np.array(excess) / np.array(scene.floors)

    def _waves(self, q: Array) -> tuple[Array, Array, Array]:
        """Per unit of size, and its first and second derivative."""
        a, b, c = q + self.phase, 2.0 * q + self.phase, self.second
        return np.sin(a) + c * np.sin(b), np.cos(a) + 2.0 * c * np.cos(b), -np.sin(a) - 4.0 * c * np.sin(b)


@final
@dataclass(frozen=True)
class CableWrap:
    """A cable winds about the joint from the angle `from_angle` [rad] on, towards `side`: slack before. It pulls back
    with size [N·m] per radian that is wound, by e^(rub · radians) more while it winds on and less while it runs off,
    as a rope on a bollard; over `soft` [rad/s] the one becomes the other."""

    from_angle: float
    side: float
    rub: float
    soft: float

    name: ClassVar[str] = "cable_wrap"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        side = float(rng.choice([-1.0, 1.0]))
        start = float(np.quantile(side * run.q, rng.uniform(0.4, 0.6)))
        return cls(start, side, float(rng.uniform(0.5, 1.2)), float(rng.uniform(0.02, 0.05)))

    def largest(self, run: AxisRun) -> float:
        return 0.4 * float(np.sqrt(np.mean(run.motor**2)))

    def torque(self, run: AxisRun, size: float) -> Array:
        wound = np.maximum(self.side * run.q - self.from_angle, 0.0)
        winding = np.tanh(self.side * run.dq / self.soft)
        return np.asarray(self.side * size * wound * np.exp(self.rub * winding * wound))


@final
@dataclass(frozen=True)
class FrictionWanders:
    """Coulomb friction is size · course [N·m] more, and viscous friction with it, `viscous` of it at 1 rad/s. The
    course goes on from log to log, through one of `stages` where one ends and the next begins: a seal that runs in,
    grease that spreads. Each step is one of chance, of either sign."""

    stages: tuple[float, ...]
    viscous: float

    name: ClassVar[str] = "friction_wanders"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        walk = np.cumsum(rng.choice([-1.0, 1.0], len(run.q) + 1) * rng.uniform(0.3, 1.0, len(run.q) + 1))
        walk -= walk.mean()
        return cls(tuple((walk / np.abs(walk).max()).tolist()), float(rng.uniform(0.2, 0.6)))

    def largest(self, run: AxisRun) -> float:
        return 0.7 * min(run.drive.tau_c, run.drive.k_d / self.viscous)

    def torque(self, run: AxisRun, size: float) -> Array:
        since = np.arange(len(run.q))[:, None] + run.time / (run.time[-1] + run.time[1])
        course = PchipInterpolator(np.arange(len(self.stages)), self.stages)(since)
        return np.asarray(size * course * (run.direction + self.viscous * run.dq))


@final
@dataclass(frozen=True)
class StrapSlides:
    """The strap that holds the band gives way above a tension, `share` of its largest, by no more than size [m], and
    creeps back within `back` [s] whenever the band pulls less than half of that."""

    band: str
    share: float
    back: float

    name: ClassVar[str] = "strap_slides"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [{"band": band.wire.name} for band in wear_of(scene).bands]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(str(where["band"]), float(rng.uniform(0.45, 0.7)), float(rng.uniform(0.2, 0.6)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.005, 0.03

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        stretch = band.stretch
        holds = self.share * float(stretch.max())
        keep = float(np.exp(-1.0 / (RATE_HZ * self.back)))
        slid = np.zeros_like(stretch)
        for log in range(len(stretch)):
            out = 0.0
            for k, taut in enumerate(stretch[log]):
                if taut - out > holds:
                    out = min(taut - holds, size)
                elif taut - out < 0.5 * holds:
                    out *= keep
                slid[log, k] = out
        return more(scene, band, -np.asarray(band.stiffness * np.minimum(slid, stretch)))
