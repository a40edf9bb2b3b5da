from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin
import pytest

from exogauge.blind.generator.case import undisturbed
from exogauge.blind.generator.plan import CasePlan
from exogauge.blind.generator.robot_files import built, robot_urdf
from exogauge.blind.generator.robot_kind import ARM, TORSO, RobotKind
from exogauge.blind.generator.scene import Scene
from exogauge.blind.generator.true_robot import TrueRobot
from exogauge.synthetic.random_streams import stream
from exogauge.synthetic.robot_facts import Joint

SEED = 4


def plan(kind: RobotKind, *kinds: str, ratio: float = 2.0) -> CasePlan:
    return CasePlan(1, kinds, (ratio,) * len(kinds), False, "current", True, "calibrated", kind)


def ran(kind: RobotKind) -> Scene:
    """A drawn robot that has run all its logs, with nothing hidden."""
    return undisturbed(plan(kind), built(stream(SEED, "maker 1"), kind), SEED)


def joints(scene: Scene) -> list[Joint]:
    return [link.joint for link in scene.links if link.joint is not None]


def with_bodies(model: pin.Model, robot: TrueRobot, joints: Sequence[Joint]) -> pin.Model:
    """pinocchio orders joints by name where a link has several: their parameters go by name."""
    for joint, phi in zip(joints, robot.phi, strict=True):
        model.inertias[model.getJointId(joint.name)] = pin.Inertia.FromDynamicParameters(phi)
    return model


def in_pinocchio(scene: Scene) -> pin.Model:
    """The same bodies on a base that cannot move."""
    model = pin.buildModelFromXML(robot_urdf(scene.kind.name, scene.links))
    return with_bodies(model, scene.robot, joints(scene))


@pytest.fixture(scope="session")
def arm6() -> Scene:
    return ran(ARM)


@pytest.fixture(scope="session")
def torso8() -> Scene:
    return ran(TORSO)


@pytest.fixture(scope="session")
def arm_model(arm6: Scene) -> pin.Model:
    return in_pinocchio(arm6)


@pytest.fixture(scope="session")
def torso_model(torso8: Scene) -> pin.Model:
    return in_pinocchio(torso8)
