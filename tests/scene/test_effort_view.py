"""Torques, forces and doubtful joints: where they are drawn, and how large."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exogauge.robots.description import Robot
from exogauge.scene.effort_view import WIDEST, draw_forces, draw_torques, mark_joints
from exogauge.scene.robot_view import RobotView, draw_robot
from exogauge.scene.stage import Stage
from exogauge.scene.take import marked_joints

Q = np.zeros((3, 4))


@pytest.fixture
def staged(make_robot: Callable[..., Robot], urdf: bytes) -> tuple[Stage, RobotView, Robot]:
    stage, robot = Stage.empty(), make_robot("pelvis", False)
    return stage, draw_robot(stage, robot, urdf, lambda name: None, Q, None, None), robot


def test_an_arc_is_as_long_as_the_torque_and_turns_its_way(staged: tuple[Stage, RobotView, Robot], unpack: Any) -> None:
    stage, view, robot = staged
    torque = {"waist": np.array([0.0, 10.0, -20.0]), "hip": np.array([0.01, 0.0, 0.0])}
    assert draw_torques(stage, view, robot.tree, torque) == 20.0
    (name,) = stage.layers["torques"]  # the hip's would be all arrow head
    scene = unpack(stage.packed({}))
    np.testing.assert_allclose(scene.track("arc", name)[:, 0], [0.0, WIDEST / 2, -WIDEST], rtol=1e-4)
    w, x, y, z = scene.message("SetOrientationMessage", name)["wxyz"]
    body = robot.tree.bodies.index("chest")
    axis = np.asarray(robot.tree.T_before[body].rotation) @ robot.tree.axis[body]
    np.testing.assert_allclose(Rotation.from_quat([x, y, z, w]).apply([0.0, 0.0, 1.0]), axis, atol=1e-6)


def test_a_slider_has_no_arc(staged: tuple[Stage, RobotView, Robot]) -> None:
    stage, view, robot = staged
    draw_torques(stage, view, robot.tree, {"shin": np.array([0.0, 10.0, -20.0])})
    assert stage.layers["torques"] == []


def test_a_force_arrow_grows_with_the_force(staged: tuple[Stage, RobotView, Robot], unpack: Any) -> None:
    stage, view, robot = staged
    force = np.array([[0.0, 0.0, 100.0], [0.0, 0.0, 50.0], [30.0, 40.0, 0.0]])
    assert draw_forces(stage, view, robot, {"sole": force}) == 100.0
    (name,) = stage.layers["forces"]
    arrows = unpack(stage.packed({})).track("points", name).reshape(3, 2, 3)
    assert (arrows[:, 0] == 0.0).all()
    longest = arrows[0, 1, 2]
    np.testing.assert_allclose(arrows[:, 1], force * longest / 100.0, rtol=1e-4)


def test_the_joint_that_the_model_does_not_explain_is_marked_by_name(
    staged: tuple[Stage, RobotView, Robot], unpack: Any
) -> None:
    stage, view, robot = staged
    findings = [{"effect": "stribeck", "where": {"joint": "hip"}}, {"effect": "load", "where": {"link": "foot"}}]
    marked = marked_joints({"discrepancy": {"findings": findings}}, robot.tree.joints)
    assert marked == {"hip": "Stribeck friction"}
    assert marked_joints({"discrepancy": None}, robot.tree.joints) == {}
    mark_joints(stage, view, robot.tree, marked)
    (name,) = stage.layers["marks"]
    assert (
        unpack(stage.packed({})).message("LabelMessage", f"{name}/label")["props"]["text"] == "hip: Stribeck friction"
    )
