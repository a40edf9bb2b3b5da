"""The drawn robot stands and moves as the kinematics say."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from exogauge.devices.posture import Posture
from exogauge.robots.description import Robot
from exogauge.scene.poses import planted, quaternions, upright
from exogauge.scene.robot_view import draw_robot
from exogauge.scene.stage import Stage

ATOL = 1e-4  # [m, 1] sixteen bits of a float


def positions(frames: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(-1.0, 1.0, (frames, 4))


def node_pose(scene: Any, node: str, frame: int) -> pin.SE3:
    """T_world_node by walking down the tree of nodes as a viewer does."""
    pose, name = pin.SE3.Identity(), ""
    for part in node.strip("/").split("/"):
        name += f"/{part}"
        turn, place = (scene.track(kind, name) for kind in ("turn", "place"))
        w, x, y, z = turn[min(frame, len(turn) - 1)].astype(float)
        R = Rotation.from_quat([x, y, z, w]).as_matrix()
        pose = pose * pin.SE3(R, place[min(frame, len(place) - 1)].astype(float))
    return pose


@pytest.mark.parametrize(("base_link", "floating"), [("chest", True), ("pelvis", True), ("pelvis", False)])
def test_every_body_is_where_forward_kinematics_put_it(
    make_robot: Callable[..., Robot], urdf: bytes, unpack: Any, base_link: str, floating: bool
) -> None:
    robot, q = make_robot(base_link, floating), positions(6)
    base = np.column_stack([q[:, :3], Rotation.from_rotvec(q[:, :3]).as_quat()]) if floating else None
    stage = Stage.empty()
    view = draw_robot(stage, robot, urdf, lambda name: None, q, base, None)
    scene = unpack(stage.packed({}))
    for frame in range(len(q)):
        posture = Posture(robot.tree, q[frame])
        T = pin.SE3(Rotation.from_rotvec(q[frame, :3]).as_matrix(), q[frame, :3]) if floating else pin.SE3.Identity()
        for body, link in enumerate(robot.tree.bodies):
            shown, expected = node_pose(scene, view.nodes[body], frame), T * posture.pose(link)
            np.testing.assert_allclose(shown.homogeneous, expected.homogeneous, atol=ATOL)


def test_without_a_base_pose_the_feet_stand_on_the_floor_and_the_accelerometer_says_what_is_up(
    make_robot: Callable[..., Robot], urdf: bytes
) -> None:
    robot, q = make_robot(), positions(5)
    up = Rotation.from_euler("xyz", q[:, :3] * 0.4).as_matrix()[:, 2]
    view = draw_robot(Stage.empty(), robot, urdf, lambda name: None, q, None, up)
    body, T = robot.tree.frames["foot"]
    assert view.known == "tilt"
    np.testing.assert_allclose(view.world(body, np.asarray(T.translation)), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.einsum("fij,fj->fi", view.R, up), np.tile([0.0, 0.0, 1.0], (5, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(view.R), 1.0)


def test_of_two_feet_the_lower_one_stands() -> None:
    feet = np.array([[[0.0, 0.1, -1.0]], [[0.0, -0.1, -0.8]]])
    R = upright(np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(feet[:, 0] @ R[0].T + planted(R, feet)[0], [[0, 0.1, 0], [0, -0.1, 0.2]], atol=1e-12)


def test_quaternions_begin_with_the_scalar() -> None:
    half_turn = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    np.testing.assert_allclose(quaternions(half_turn), [0.5**0.5, 0.0, 0.0, 0.5**0.5])
