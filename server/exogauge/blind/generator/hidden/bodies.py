"""Bodies that are not what they are said to be, or are pushed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.cut import Cut, cut_wrench, links_beyond
from exogauge.blind.generator.dynamics import UP, carrier, inverse_dynamics
from exogauge.blind.generator.hidden.effect import Array, Change, Where
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.places import poses
from exogauge.blind.generator.scene import Scene, all_samples
from exogauge.blind.generator.true_robot import INERTIAL_STD
from exogauge.synthetic.inertia import Mass

_ROUND = 0.04  # radius of gyration of a payload [m]


@final
@dataclass(frozen=True)
class Payload:
    """size [kg] at `place` [m] in the hand's frame; from log `since` on: 0, in all of them.

    A hand that never was without it shows it only by what the maker states of its mass; there the hand itself is as
    heavy as that.
    """

    hand: str
    place: tuple[float, float, float]
    since: int

    name: ClassVar[str] = "payload"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [{"link": hand} for hand in scene.kind.hands]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        x, y, z = (float(each) for each in rng.uniform([-0.05, -0.05, -0.08], [0.05, 0.05, 0.08]))
        since = int(rng.integers(2, 4)) if rng.uniform() < 0.5 else 0
        return cls(str(where["link"]), (x, y, z), since)

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.05, 2.5

    def believed(self, scene: Scene) -> float | None:
        if self.since:
            return None
        return INERTIAL_STD * self._stated(scene)

    def change(self, scene: Scene, size: float) -> Change:
        on, offset = carrier(scene.links, self.hand)
        body = scene.robot.tree.names.index(on)
        load = Mass(size, offset + self.place, _ROUND**2 / 3.0 * np.eye(3)).phi()
        if not self.since:
            hand = scene.robot.masses[self.hand]
            load = load + replace(hand.moved(offset), mass=self._stated(scene) - hand.mass).phi()
        cut = scene.robot.cut
        carried = body == cut.body and self.hand in links_beyond(scene.links, scene.kind.sensor.frame)
        change = _heavier(scene, body, load, carried or body in cut.bodies)
        return _since(change, self.since)

    def _stated(self, scene: Scene) -> float:
        return next(link.mass for link in scene.links if link.name == self.hand)


@final
@dataclass(frozen=True)
class LinkMass:
    """A moving link is heavier (sign 1) or lighter (-1) than stated by size [kg], everywhere alike: not by chance."""

    body: int
    sign: float

    name: ClassVar[str] = "link_mass"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        """Not where a payload would be, nor what the sensor divides."""
        hands = {carrier(scene.links, hand)[0] for hand in scene.kind.hands}
        return [{"link": name} for name in scene.robot.tree.names if name not in hands]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(scene.robot.tree.names.index(str(where["link"])), float(rng.choice([-1.0, 1.0])))

    def limits(self, scene: Scene) -> tuple[float, float]:
        mass = self._stated(scene)
        return 0.1 * mass, (1.0 if self.sign > 0 else 0.6) * mass

    def believed(self, scene: Scene) -> float | None:
        return INERTIAL_STD * self._stated(scene)

    def change(self, scene: Scene, size: float) -> Change:
        own = scene.robot.phi[self.body]
        more = (self._stated(scene) + self.sign * size) / own[0] - 1.0
        return _heavier(scene, self.body, more * own, self.body in scene.robot.cut.bodies)

    def _stated(self, scene: Scene) -> float:
        name = scene.robot.tree.names[self.body]
        return sum(link.mass for link in scene.links if link.mass > 0.0 and carrier(scene.links, link.name)[0] == name)


@final
@dataclass(frozen=True)
class Contact:
    """A push of size [N] at `place` [m] of a link's frame, along `direction` of the base, in one or two logs.

    push: its size, which does not depend on how well it shows. windows: log, begin and length [s]; it rises and falls
    as a squared sine to the power `power`.
    """

    link: str
    place: tuple[float, float, float]
    direction: tuple[float, float, float]
    windows: tuple[tuple[int, float, float], ...]
    power: float
    push: float

    name: ClassVar[str] = "contact"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [{"link": name} for name in scene.robot.tree.names]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        body = scene.robot.tree.names.index(str(where["link"]))
        middle = scene.robot.phi[body, 1:4] / scene.robot.phi[body, 0]
        x, y, z = (float(each) for each in middle + rng.uniform(-0.04, 0.04, 3))
        way = rng.standard_normal(3)
        u, v, w = (float(each) for each in way / np.linalg.norm(way))
        logs = rng.choice(scene.plain, int(rng.integers(1, 3)), replace=False)
        last = float(scene.motion.time[-1]) - 2.0
        windows = tuple((int(log), float(rng.uniform(2.0, last)), float(rng.uniform(0.2, 1.0))) for log in logs)
        push = float(np.exp(rng.uniform(np.log(5.0), np.log(40.0))))
        return cls(str(where["link"]), (x, y, z), (u, v, w), windows, float(rng.choice([0.5, 1.0])), push)

    def limits(self, scene: Scene) -> tuple[float, float]:
        return self.push, self.push

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        tree, cut = scene.robot.tree, scene.robot.cut
        body = tree.names.index(self.link)
        torque, wrench = np.zeros(scene.motion.q.shape), np.zeros((*scene.shape, 6))
        on = np.zeros(scene.shape, bool)
        for log, begin, length in self.windows:
            first, count = round(begin * RATE_HZ), round(length * RATE_HZ)
            now = slice(first, first + count)
            force = np.outer(size * np.sin(np.pi * np.arange(count) / count) ** (2.0 * self.power), self.direction)
            at = poses(tree, scene.motion.q[log, now])
            point = (body, np.array(self.place))
            for joint, way in at.moves(point).items():
                torque[log, now, joint] = -np.sum(way * force, axis=1)
            if body in cut.bodies:
                wrench[log, now, :3] = force
                wrench[log, now, 3:] = np.cross(at.at(point) - cut.place, force)
            on[log, now] = True
        return Change(torque, wrench, on)


@final
@dataclass(frozen=True)
class BaseTilt:
    """The base leans by size [rad] about a level axis at `heading` [rad] from its x axis, in all logs."""

    heading: float

    name: ClassVar[str] = "base_tilt"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [{"base": True}]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(float(rng.uniform(0.0, 2 * np.pi)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return float(np.radians(0.3)), float(np.radians(3.0))

    def believed(self, scene: Scene) -> float | None:
        return None

    def up(self, size: float) -> Array:
        """(3,) minus gravity, seen from the leaning base."""
        lean = np.array([-np.sin(self.heading), np.cos(self.heading), 0.0])
        return np.asarray(UP * np.cos(size) + UP[2] * np.sin(size) * lean)

    def change(self, scene: Scene, size: float) -> Change:
        robot = scene.robot
        leaning = all_samples(robot, scene.motion, self.up(size))
        torque = (
            inverse_dynamics(robot.tree, robot.phi, leaning)[0]
            - inverse_dynamics(robot.tree, robot.phi, scene.moving)[0]
        )
        wrench = cut_wrench(robot.tree, robot.phi, robot.cut, leaning).reshape(scene.wrench.shape) - scene.wrench
        return Change(torque.reshape(scene.motion.q.shape), wrench)


def _heavier(scene: Scene, body: int, phi: Array, carried: bool) -> Change:
    """phi: (10,) on top of what is there, in the body's frame."""
    robot = scene.robot
    alone = np.zeros_like(robot.phi)
    alone[body] = phi
    torque = inverse_dynamics(robot.tree, alone, scene.moving)[0].reshape(scene.motion.q.shape)
    if not carried:
        return Change(torque, None)
    cut = robot.cut
    seen = Cut(cut.body, cut.place, cut.bodies, phi if body == cut.body else np.zeros(10))
    return Change(torque, cut_wrench(robot.tree, alone, seen, scene.moving).reshape(scene.wrench.shape))


def _since(change: Change, log: int) -> Change:
    for values in (change.torque, change.wrench):
        if values is not None:
            values[:log] = 0.0
    return change
