"""The arm of the sample generator, as the code that identifies sees it: MuJoCo on one side, pinocchio on the other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from exogauge.payload.dynamics import Rows, dynamic_rows
from exogauge.payload.holds import find_holds
from exogauge.payload.sensor_motion import SensorMotion, from_joints, rotations
from exogauge.payload.smoothing import Kind
from exogauge.payload.statics import Holds, StaticSolution, static_stage
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree
from exogauge.synthetic import payload as generator
from exogauge.synthetic.random_streams import stream

Array = NDArray[np.float64]

GRAVITY = np.array([0.0, 0.0, -generator.GRAVITY])
STD = np.array([generator.FORCE_NOISE] * 3 + [generator.MOMENT_NOISE] * 3)


@cache
def arm() -> RigidTree:
    return load_tree(generator.arm_urdf().encode(), joints=list(generator.JOINTS), base_link="base", floating=False)


@dataclass(frozen=True)
class Case:
    """One seed: the truth, angles and wrenches of postures and excitation as logged."""

    body: generator.Body
    phi: Array
    postures: tuple[Array, Array]
    excitation: tuple[Array, Array]
    exact: tuple[Array, Array, Array]

    @property
    def truth(self) -> Array:
        """(16,)"""
        return np.concatenate([self.phi, self.body.zero])

    def holds(self) -> Holds:
        angles, wrench = self.postures
        time = np.arange(len(angles)) / generator.RATE_HZ
        spans = find_holds(time, angles, generator.ENCODER_NOISE)
        inside = [(time >= a) & (time <= b) for a, b in spans]
        means = np.array([angles[k].mean(axis=0) for k in inside])
        count = min(int(k.sum()) for k in inside)
        return Holds(
            rotations(arm(), "ft", means),
            np.array([wrench[k].mean(axis=0) for k in inside]),
            STD / np.sqrt(count),
            2e-5,
        )

    @cached_property
    def static(self) -> StaticSolution:
        return static_stage(self.holds(), GRAVITY, -1)

    def motion(self, density: float | None = None, kind: Kind = "smoother") -> SensorMotion:
        angles = self.excitation[0]
        time = np.arange(len(angles)) / generator.RATE_HZ
        return from_joints(arm(), "ft", time, angles, generator.ENCODER_NOISE, GRAVITY, density=density, kind=kind)

    def rows(self, gravity: Array, density: float | None = None, kind: Kind = "smoother") -> Rows:
        motion = self.motion(density, kind)
        inner = slice(motion.edge, len(motion.time) - motion.edge)
        return dynamic_rows(motion.rows(inner), self.excitation[1][inner], gravity, -1, STD)


@cache
def case(seed: int) -> Case:
    """The paper's numbers: 21 postures of 1 s, 10 s of excitation at 250 Hz."""
    body = generator.draw_body(stream(seed, "payload"))
    still, moved = (
        generator.postures_motion(stream(seed, "postures")),
        generator.wrist_motion(stream(seed, "excitation")),
    )
    logged = [
        generator.measured(q, generator.simulate(body, q, dq, ddq), stream(seed, name))
        for name, (q, dq, ddq) in (("still", still), ("moved", moved))
    ]
    return Case(body, parameters(body), logged[0], logged[1], moved)


def parameters(body: generator.Body) -> Array:
    """(10,) of the truth, about the sensor's origin, in the order of `RigidTree.phi`."""
    i = body.about_sensor
    inertia = [i[0, 0], i[0, 1], i[1, 1], i[0, 2], i[1, 2], i[2, 2]]
    return np.concatenate([[body.mass], body.mass * body.centre, inertia])
