from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest

from exogauge.blind.generator.arm import ARM
from exogauge.blind.generator.axis_run import AxisRun, axis_runs
from exogauge.blind.generator.excess import Baseline, baselines
from exogauge.blind.generator.maker import built
from exogauge.blind.generator.motion import Motion, excitations
from exogauge.blind.generator.robot_files import robot_urdf
from exogauge.blind.generator.robot_kind import RobotKind
from exogauge.blind.generator.torso import TORSO
from exogauge.blind.generator.true_robot import TrueRobot, draw_robot
from exogauge.synthetic.robot_facts import Joint, Link


@dataclass(frozen=True)
class Bench:
    """A drawn robot that has run two logs; model: the same bodies in pinocchio, on a base that cannot move."""

    links: Sequence[Link]
    robot: TrueRobot
    motion: Motion
    runs: list[AxisRun]
    absorbing: list[Baseline]
    model: pin.Model


def bench(kind: RobotKind) -> Bench:
    links = built(np.random.default_rng(4), kind.links)
    robot = draw_robot(np.random.default_rng(5), links)
    joints = [link.joint for link in links if link.joint is not None]
    motion = excitations(np.random.default_rng(6), joints, 2, 12.0)
    runs = axis_runs(np.random.default_rng(7), robot, motion)
    model = pin.buildModelFromXML(robot_urdf(kind.name, links))
    return Bench(links, robot, motion, runs, baselines(robot.tree, motion, runs), with_bodies(model, robot, joints))


def with_bodies(model: pin.Model, robot: TrueRobot, joints: Sequence[Joint]) -> pin.Model:
    """pinocchio orders joints by name where a link has several: their parameters go by name."""
    for joint, phi in zip(joints, robot.phi, strict=True):
        model.inertias[model.getJointId(joint.name)] = pin.Inertia.FromDynamicParameters(phi)
    return model


@pytest.fixture(scope="session")
def arm6() -> Bench:
    return bench(ARM)


@pytest.fixture(scope="session")
def torso8() -> Bench:
    return bench(TORSO)


@pytest.fixture(scope="session")
def free_torso(torso8: Bench) -> pin.Model:
    """`torso8` in pinocchio on a base that could fly."""
    model = pin.buildModelFromXML(robot_urdf(TORSO.name, torso8.links), pin.JointModelFreeFlyer())
    model.inertias[1] = pin.Inertia.FromDynamicParameters(torso8.robot.base.phi())
    return with_bodies(model, torso8.robot, [link.joint for link in torso8.links if link.joint is not None])
