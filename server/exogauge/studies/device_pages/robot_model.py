"""A robot as plain values that a page can show and draw: joints, links, where everything is, sensors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio as pin

from exogauge.devices.posture import Posture
from exogauge.robots.description import Joint, Robot
from exogauge.robots.tree import RigidTree
from exogauge.studies.device_pages.device_picture import bones
from exogauge.studies.device_pages.link_table import base_link
from exogauge.studies.intake.contract import RobotFile


def robot_model(robot: Robot, file: RobotFile) -> dict[str, Any]:
    """Places are seen from the base link with all joints at zero: at [m], turn: its 3 × 3 rotation row by row.

    None: not known, or without a limit. bones: pairs of places, a stick figure.
    """
    tree = robot.tree
    posture = Posture(tree)
    return {
        "base_link": base_link(tree),
        "joints": [_joint(each, k, tree) for k, each in enumerate(robot.joints)],
        "links": [_link(name, tree, posture) for name in tree.frames],
        "bones": [[_plain(start), _plain(end)] for start, end in bones(tree, posture)],
        "transmission": None if file.transmission is None else file.transmission.model_dump(mode="json"),
        "imu": _imu(robot, file),
        "sensors": [each.model_dump(mode="json") for each in file.ft_sensors],
        "locked": list(tree.locked),
        "noise": dict(robot.noise),
        "inertial_std": {name or "default": std for name, std in robot.inertial_std.items()},
    }


def _joint(joint: Joint, k: int, tree: RigidTree) -> dict[str, Any]:
    """lower, upper [rad or m], velocity, effort: the URDF's limits; prior, prior_std: as written, joint-side SI."""
    body = int(np.flatnonzero(tree.dof == k)[0])
    return {
        "name": joint.name,
        "kind": "prismatic" if joint.name in tree.sliding else "revolute",
        "moves": tree.bodies[body],
        "actuation": joint.actuation,
        "gear_ratio": joint.gear_ratio,
        "prior": dict(joint.prior),
        "prior_std": dict(joint.prior_std),
        "lower": _finite(tree.lower[k]),
        "upper": _finite(tree.upper[k]),
        "velocity": _finite(tree.velocity_limit[k]),
        "effort": _finite(tree.effort_limit[k]),
    }


def _link(name: str, tree: RigidTree, posture: Posture) -> dict[str, Any]:
    """body: the link that carries it where a fixed joint does, else its own name.

    mass_kg, centre [m, in its own frame]: the maker's, of the whole body, at the link that names it.
    """
    body, _ = tree.frames[name]
    found: dict[str, Any] = {"name": name, "body": tree.bodies[body] if body >= 0 else base_link(tree)}
    found |= {"joint": None, "mass_kg": None, "centre": None} | _pose(posture.pose(name))
    if body >= 0 and name == tree.bodies[body]:
        mass = float(tree.phi[body, 0])
        found["mass_kg"] = mass
        found["centre"] = _plain(tree.phi[body, 1:4] / mass) if mass > 0.0 else None
        found["joint"] = tree.joints[tree.dof[body]] if tree.dof[body] >= 0 else None
    return found


def _imu(robot: Robot, file: RobotFile) -> dict[str, Any] | None:
    """Its pose in the base link; None where it has no use."""
    if robot.T_base_imu is None or file.imu is None:
        return None
    return {"on": file.imu.frame or file.imu.parent, **_pose(robot.T_base_imu)}


def _pose(pose: pin.SE3) -> dict[str, Any]:
    return {"at": _plain(pose.translation), "turn": _plain(np.asarray(pose.rotation).ravel())}


def _plain(values: Any) -> list[float]:
    return [float(value) for value in np.round(values, 6) + 0.0]


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
