"""What a robot is asked of a person, and what of a robot file cannot be planned for."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml
from scipy.spatial.transform import Rotation
from tests.motion.plans import SOON, at

from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadRobot
from exogauge.motion.person import Person
from exogauge.motion.plan.retarget import ask
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.synthetic.urdf import robot_urdf


def test_the_trunk_is_asked_as_the_person_turns_it(robot: MotionRobot) -> None:
    """Yaw and pitch come back to what made them; the roll that the robot has no joint for is told."""
    T = 50
    still = np.tile(np.eye(3), (T, 1, 1))
    yaw, pitch = 0.3 * np.sin(np.linspace(0, 3, T)), 0.5 * np.sin(np.linspace(0, 6, T)) ** 2
    turned = np.stack([pin.rpy.rotate("z", a) @ pin.rpy.rotate("y", b) for a, b in zip(yaw, pitch, strict=True)])
    person = Person("turn", np.arange(T) / USUAL.nodes_per_s, np.zeros((T, 3)), still, turned, {}, 0.8)
    asked, missed = ask(robot, person)
    lead = round(USUAL.approach_s * USUAL.nodes_per_s)
    assert asked.q[lead : lead + T, at(robot, "torso_yaw")] == pytest.approx(yaw, abs=1e-6)
    assert asked.q[lead : lead + T, at(robot, "torso_pitch")] == pytest.approx(pitch, abs=1e-6)
    assert missed.max() < 1e-6
    leans = replace(person, trunk=np.tile(pin.rpy.rotate("x", 0.2), (T, 1, 1)))
    assert ask(robot, leans)[1].max() == pytest.approx(0.2, abs=1e-3)


def test_who_sits_or_crouches_at_first_rises_to_where_the_robot_stands(robot: MotionRobot) -> None:
    """Where he began was taken for standing: the robot was asked to rise by as much beyond its straight legs."""
    still = np.tile(np.eye(3), (31, 1, 1))
    rises = np.linspace(0.0, 1.0, 31)[:, None] * [0.0, 0.0, 0.3]
    person = Person("rises", np.arange(31) / 30.0, rises, still, still, {}, 0.8)
    asked, _ = ask(robot, person, SOON)
    assert asked.q[:, 2].max() == pytest.approx(robot.home[2], abs=1e-9)
    other, _ = ask(robot, replace(person, pelvis=rises[::-1]), SOON)
    assert np.sort(other.q[:, 2]) == pytest.approx(np.sort(asked.q[:, 2]), abs=1e-9)
    a_little, _ = ask(robot, replace(person, pelvis=0.05 * rises), SOON)
    assert a_little.q[:, 2].max() > robot.home[2] + 0.005  # home's knees are bent: there is room


def test_a_robot_that_faces_elsewhere_is_asked_the_same(robot: MotionRobot, folder: Path, tmp_path: Path) -> None:
    """A root link that looks to the right, or back as iCub's: the base was asked to turn round on feet that stay."""
    whole = yaml.safe_load((folder / "robot.yaml").read_text())
    fixed = '<link name="stand"/><joint name="on" type="fixed"><parent link="stand"/><child link="BODY"/>'
    fixed += f'<origin rpy="0 0 {-np.pi / 2}"/></joint></robot>'
    (tmp_path / "robot.urdf").write_text(robot_urdf().replace("</robot>", fixed))
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(whole | {"base_link": "stand"}))
    other = load_motion_robot(tmp_path / "robot.yaml")
    s = np.sin(np.linspace(0.0, np.pi, 31))[:, None] ** 2
    turn, trunk = (Rotation.from_euler("ZXY", s * angles).as_matrix() for angles in ([0.3, 0.1, 0.2], [0.2, 0.0, 0.5]))
    person = Person("p", np.arange(31) / 30.0, s * [0.1, 0.05, -0.02], turn, trunk, {}, 0.8)
    (here, _), (there, _) = ask(robot, person, SOON), ask(other, person, SOON)
    for one, two in zip(here.q, there.q, strict=True):
        seen = []
        for each, q in ((robot, one), (other, two)):
            pin.forwardKinematics(each.model, each.data, q)
            chest, body = (pin.updateFramePlacement(each.model, each.data, each.frame(n)) for n in ("chest", "BODY"))
            pin.forwardKinematics(each.model, each.data, each.home)
            begin = pin.updateFramePlacement(each.model, each.data, each.frame("BODY"))
            seen.append(np.stack([(begin.inverse() * pose).homogeneous for pose in (chest, body)]))
        assert seen[0] == pytest.approx(seen[1], abs=1e-9)


def test_a_robot_that_cannot_be_planned_for_is_told_why(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "robot.urdf", tmp_path)
    whole = yaml.safe_load((folder / "robot.yaml").read_text())
    for change, column in (
        ({"human_map": {"pelvis": "BODY", "thorax": "nothing"}}, "human_map"),
        ({"human_map": {"tail": "BODY"}}, "human_map.tail"),
        ({"home": {"l_knee_pitch": -1.0}}, "home.l_knee_pitch"),
        ({"limits": {"acceleration": {"no_joint": 3.0}}}, "limits.acceleration.no_joint"),
        ({"limits": {"jerk": {"no_joint": 3.0}}}, "limits.jerk.no_joint"),
    ):
        (tmp_path / "robot.yaml").write_text(yaml.safe_dump({**whole, **change}))
        with pytest.raises(BadRobot) as told:
            load_motion_robot(tmp_path / "robot.yaml")
        assert told.value.faults[0].column == column
