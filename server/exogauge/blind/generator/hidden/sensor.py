"""What a force/torque sensor says, and does not feel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.hidden.effect import Array, Change, Where
from exogauge.blind.generator.scene import Scene

ALL = "all"


def _axes(scene: Scene) -> list[Where]:
    return [{"sensor": scene.kind.sensor.name, "axis": axis} for axis in AXES]


def _alone(scene: Scene, axis: int, values: Array) -> Change:
    wrench = np.zeros((*scene.shape, 6))
    wrench[:, :, axis] = values
    return Change(None, wrench)


@final
@dataclass(frozen=True)
class FtGain:
    """One axis says size too much (sign 1) or too little, a little more so at large values: f (1 + curve |f| / rms)."""

    axis: int
    sign: float
    curve: float

    name: ClassVar[str] = "ft_gain"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = True

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return _axes(scene)

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(AXES.index(str(where["axis"])), float(rng.choice([-1.0, 1.0])), float(rng.uniform(0.0, 0.15)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.03, 0.15

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        return _alone(scene, self.axis, self.sign * size * _curved(scene.wrench[:, :, self.axis], self.curve))


@final
@dataclass(frozen=True)
class FtCrosstalk:
    """The share size of axis `source` shows on `axis`, forces among forces, moments among moments; curve as in gain."""

    axis: int
    source: int
    sign: float
    curve: float

    name: ClassVar[str] = "ft_crosstalk"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = True

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return _axes(scene)

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        axis = AXES.index(str(where["axis"]))
        source = 3 * (axis // 3) + (axis + int(rng.integers(1, 3))) % 3
        return cls(axis, source, float(rng.choice([-1.0, 1.0])), float(rng.uniform(0.0, 0.15)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.03, 0.10

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        return _alone(scene, self.axis, self.sign * size * _curved(scene.wrench[:, :, self.source], self.curve))


@final
@dataclass(frozen=True)
class FtDrift:
    """The zero of one axis, or of each, moves by size noises in a log.

    soon: share of it that goes with the time constant `settling` [s], the rest goes evenly. signs: (6,) per axis, 0
    where it stays. log: index, None where it happens in every log.
    """

    signs: tuple[float, ...]
    log: int | None
    soon: float
    settling: float

    name: ClassVar[str] = "ft_drift"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = True

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        whole: Where = {"sensor": scene.kind.sensor.name, "axis": ALL}
        return [*_axes(scene), whole, whole]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        signs = rng.choice([-1.0, 1.0], 6)
        if where["axis"] != ALL:
            signs[[axis != where["axis"] for axis in AXES]] = 0.0
        log = int(rng.choice(scene.plain)) if rng.uniform() < 0.5 else None
        return cls(tuple(signs.tolist()), log, float(rng.uniform(0.4, 0.8)), float(rng.uniform(3.0, 12.0)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 1.0, 80.0

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        time = scene.motion.time
        path = self.soon * (1.0 - np.exp(-time / self.settling)) + (1.0 - self.soon) * time / time[-1]
        drift = size * path[:, None] * scene.cut_baseline.std * np.array(self.signs)
        wrench, on = np.zeros((*scene.shape, 6)), np.zeros(scene.shape, bool)
        logs = slice(None) if self.log is None else slice(self.log, self.log + 1)
        wrench[logs], on[logs] = drift, True
        return Change(None, wrench, on)


def _curved(values: Array, curve: float) -> Array:
    return np.asarray(values * (1.0 + curve * np.abs(values) / np.sqrt(np.mean(values**2))))
