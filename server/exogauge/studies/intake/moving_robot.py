"""robot.yaml and its URDF become what motions are planned for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.errors import BadRobot, Fault
from exogauge.robots.description import Robot
from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.moving.robot import MotionRobot, Sole, flat_model
from exogauge.robots.moving.segments import Segment
from exogauge.studies.intake.contract import RobotFile
from exogauge.studies.intake.mesh_files import mesh_opener
from exogauge.studies.intake.shape_files import shapes_of

Array = NDArray[np.float64]


def moving_robot(robot: Robot, entry: RobotFile, urdf: bytes, path: Path) -> MotionRobot:
    """entry: as `path`, robot.yaml, has it; meshes are looked for below its folder. Raises BadRobot, with the key that
    is at fault."""
    names, tree = [joint.name for joint in entry.joints], robot.tree
    model = flat_model(urdf.decode(), names, robot.floating)
    base = 6 if robot.floating else 0
    joints = tuple(list(model.names)[1 + base :])
    order = [tree.joints.index(name) for name in joints]
    links = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
    parts = set(get_args(Segment))

    def fault(detail: str, rule: str, advice: str, column: str, value: str) -> BadRobot:
        return BadRobot(Fault(detail, rule, advice, path.name, None, column, value))

    if model.nq != model.nv:
        turning = next(name for name, joint in zip(model.names, model.joints, strict=True) if joint.nq != joint.nv)
        raise fault("a joint without ends has no coordinate of its own", "continuous_joint",
                    "Give it limits: type revolute in the URDF", "urdf", turning)  # fmt: skip
    ignored = tuple(entry.collision.left_out)
    for key, named in (
        ("soles", [sole.link for sole in entry.soles]), ("human_map", list(entry.human_map.values())),
        ("collision.shapes", list(entry.collision.shapes)),
        ("collision.left_out", [link for pair in ignored for link in pair]),
    ):  # fmt: skip
        for link in named:
            if link not in links:
                raise fault("the URDF has no such link", "unknown_link", "Name one of its links", key, link)
    for part in entry.human_map:
        if part not in parts:
            raise fault("no such part of the body", "unknown_segment", f"One of {', '.join(sorted(parts))}",
                        f"human_map.{part}", part)  # fmt: skip
    stated = {f"limits.{key}": value for key, value in entry.limits}
    for key, value in {"home": entry.home, **stated}.items():
        for name in value if isinstance(value, dict) else ():
            if name not in joints:
                raise fault(
                    "the robot has no such joint", "unknown_joint", "Name one of `joints`", f"{key}.{name}", name
                )

    def of_joints(key: str, none: float) -> Array:
        value = stated[f"limits.{key}"]
        return np.array([value.get(name, none) if isinstance(value, dict) else value for name in joints])

    limits = JointLimits(
        tree.lower[order], tree.upper[order], tree.velocity_limit[order], of_joints("acceleration", np.inf),
        tree.effort_limit[order] * of_joints("torque_share", 1.0), of_joints("jerk", np.inf),
    )  # fmt: skip
    posture = np.array([entry.home.get(name, 0.0) for name in joints])
    for name, value, low, high in zip(joints, posture, limits.lower, limits.upper, strict=True):
        if not low <= value <= high:
            raise fault(f"home lies outside [{low:g}, {high:g}]", "home_outside", "Give a posture within the limits",
                        f"home.{name}", f"{value:g}")  # fmt: skip
    soles = tuple(Sole(sole.link, np.array(sole.outline)) for sole in entry.soles)
    segments: dict[Segment, str] = dict(entry.human_map)  # type: ignore[assignment]
    shapes, shapeless = shapes_of(urdf, entry.collision.shapes, mesh_opener(path.parent))
    made = MotionRobot(
        robot.name, model, joints, robot.floating, limits, soles, segments, None, shapes, ignored, shapeless
    )
    home = np.concatenate([np.zeros(base), posture])
    if not soles or not robot.floating:
        return replace(made, home=home)
    pin.forwardKinematics(model, made.data, home)
    at = [pin.updateFramePlacement(model, made.data, made.frame(sole.link)).copy() for sole in soles]
    corners = [sole.outline @ pose.rotation.T + pose.translation for sole, pose in zip(soles, at, strict=True)]
    home[2] = -min(each[:, 2].min() for each in corners)
    soles = tuple(
        sole if pose.rotation[2] @ sole.axes[:, 2] > 0.0 else Sole(sole.link, sole.outline[::-1].copy())
        for sole, pose in zip(soles, at, strict=True)
    )
    return replace(made, soles=soles, home=home)
