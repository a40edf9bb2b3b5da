"""What acts, on a stage: torques as arrows bent round the joints' axes, contact forces as arrows, doubtful joints."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.scene.colours import FORCE, MARK, SUPPORT, TORQUE, Rgb, round_up
from exogauge.scene.poses import quaternions
from exogauge.scene.robot_view import RobotView
from exogauge.scene.stage import Stage

Array = NDArray[np.float64]

WIDEST = 1.5 * math.pi  # [rad] of an arc at the scale's end
ARC_SEGMENTS = 20  # as many as the player makes
LONGEST = 0.35  # of the robot's size, of an arrow at the scale's end
THICKNESS = 4.0  # [px]
SEEN = 0.15  # [rad] a joint whose arc never gets longer gets none: it would be all arrow head
ARC, SUPPORT_ARC, BALL = 0.06, 0.085, 0.04  # of the robot's size


def draw_torques(
    stage: Stage, view: RobotView, tree: RigidTree, torque: Mapping[str, Array], layer: str = "torques"
) -> float:
    """Arcs of joint torques; returns the torque [N·m] of three quarters of a turn. layer: torques or support."""
    colour, share = (SUPPORT, SUPPORT_ARC) if layer == "support" else (TORQUE, ARC)
    most = round_up(max((float(np.abs(values).max(initial=0.0)) for values in torque.values()), default=0.0))
    names = []
    for body, dof in enumerate(tree.dof):
        if dof < 0 or tree.prismatic[body] or tree.joints[dof] not in torque:
            continue
        name = f"{_carrier(view, tree, body)}/{layer}_{body}"
        angle = np.clip(torque[tree.joints[dof]] / most, -1.0, 1.0) * WIDEST
        if np.abs(angle).max(initial=0.0) < SEEN:
            continue
        _add_arc(stage, name, tree, body, colour)
        stage.move("arc", name, angle[:, None].astype(np.float32), radius=share * view.size)
        names.append(name)
    stage.layers[layer] = names
    return most


def draw_forces(stage: Stage, view: RobotView, robot: Robot, force: Mapping[str, Array]) -> float:
    """Arrows from the contact sensors; returns the force [N] of the longest arrow."""
    most = round_up(max((float(np.linalg.norm(f, axis=1).max(initial=0.0)) for f in force.values()), default=0.0))
    names = []
    for sensor in robot.sensors:
        if sensor.name not in force or sensor.frame not in robot.tree.frames:
            continue
        body, T = robot.tree.frames[sensor.frame]
        name = f"{view.nodes[body]}/force_{sensor.name.replace('/', '_')}"
        ends = force[sensor.name] * (LONGEST * view.size / most)
        points = np.stack([np.zeros_like(ends), ends], axis=1)
        thick = 0.008 * view.size
        stage.scene.add_arrows(
            name,
            points[:1],
            FORCE,
            shaft_radius=thick,
            head_radius=2.2 * thick,
            head_length=5.0 * thick,
            position=tuple(np.asarray(T.translation)),
            wxyz=tuple(quaternions(np.asarray(T.rotation))),
        )
        stage.move("points", name, points.astype(np.float32))
        names.append(name)
    stage.layers["forces"] = names
    return most


def mark_joints(stage: Stage, view: RobotView, tree: RigidTree, marked: Mapping[str, str]) -> None:
    """A glow round each joint that the model does not explain, and its name."""
    names = []
    for body, dof in enumerate(tree.dof):
        if dof < 0 or tree.joints[dof] not in marked:
            continue
        joint = tree.joints[dof]
        name = f"{_carrier(view, tree, body)}/mark_{body}"
        place = tuple(np.asarray(tree.T_before[body].translation))
        stage.scene.add_icosphere(name, BALL * view.size, color=MARK, opacity=0.35, position=place, cast_shadow=False)
        stage.scene.add_label(f"{name}/label", f"{joint}: {marked[joint]}", font_screen_scale=0.9, anchor="bottom-left")
        names.append(name)
    stage.layers["marks"] = names


def _carrier(view: RobotView, tree: RigidTree, body: int) -> str:
    return view.nodes[int(tree.parent[body])]


def _add_arc(stage: Stage, name: str, tree: RigidTree, body: int, colour: Rgb) -> None:
    """A node whose z axis is the joint's, seen from the body that carries the joint."""
    T = tree.T_before[body]
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), tree.axis[body]).matrix()
    stage.scene.add_line_segments(
        name,
        np.zeros((ARC_SEGMENTS, 2, 3)),
        colour,
        thickness=THICKNESS,
        thickness_units="screen",
        position=tuple(np.asarray(T.translation)),
        wxyz=tuple(quaternions(np.asarray(T.rotation) @ turn)),
    )
