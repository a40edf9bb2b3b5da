"""A motor that turns with two joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.hidden.effect import Array, Change, Where
from exogauge.blind.generator.scene import Scene

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
