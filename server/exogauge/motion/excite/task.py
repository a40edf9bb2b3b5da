"""A robot as it is identified and as it moves becomes what is planned for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.effects.catalogue import choose
from exogauge.errors import BadRobot, Fault
from exogauge.experiment.information import Information
from exogauge.identification.equations import Equations
from exogauge.identification.prior import Scales, joint_prior, per_parameter
from exogauge.identification.settings import Settings
from exogauge.motion.excite.search import Task
from exogauge.robots.description import Robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.stance import Fixed, Standing
from exogauge.robots.moving.strain import Bounds
from exogauge.robots.moving.touching import Pairs
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.series import Series

Array = NDArray[np.float64]


def task_of(
    robot: Robot, moving: MotionRobot, seconds: float, criteria: MotionExcite = USUAL, known: Array | None = None
) -> Task:
    """known: (P, P) information before, where there is more than the maker's. Raises BadRobot."""
    order = np.array([moving.joints.index(joint.name) for joint in robot.joints], dtype=np.intp)
    stance = Standing(moving, criteria) if robot.floating else Fixed(moving)
    if (
        robot.floating
        and robot.tree.bodies[0] != moving.model.frames[moving.model.getBodyId(robot.tree.bodies[0])].name
    ):
        raise BadRobot(Fault("the base link is not the URDF's root", "base_not_root", "Name the root", moving.name))
    limits = moving.limits
    for name, fast in zip(moving.joints, limits.velocity, strict=True):
        if not np.isfinite(fast):
            raise BadRobot(Fault("the URDF does not limit the joint's velocity", "no_velocity",
                                 "Add <limit velocity> to the URDF", moving.name, None, "joints", name))  # fmt: skip
    base = find_base_parameters(robot.tree)
    blocks = RowBlocks(robot.tree, base, robot.axes_from_joints)
    equations = Equations(robot, blocks, base, choose(Settings().effects))
    mixing = np.abs(robot.axes_from_joints)
    velocity = mixing @ limits.velocity[order]
    heavy = np.where(np.isfinite(limits.torque[order]), limits.torque[order], 100.0)
    fast = np.where(np.isfinite(limits.acceleration[order]), limits.acceleration[order], 10.0)
    prior = per_parameter(robot, base, equations.effects, Scales(0.3 * heavy, 0.3 * velocity, 0.3 * mixing @ fast))
    information = Information(
        equations, prior, _weights(robot, stance, heavy, criteria), criteria.rate_hz, criteria.turn_s,
        criteria.slow_share * velocity, known,
    )  # fmt: skip
    corners = np.zeros((0, 3))
    if isinstance(stance, Standing):
        corners = np.concatenate([
            sole.outline @ at.rotation.T + at.translation for sole, at in zip(moving.soles, stance.place, strict=True)
        ])  # fmt: skip
    top_hz = criteria.standing_hz if robot.floating else criteria.top_hz
    harmonics = max(3, round(top_hz * seconds))
    bounds = Bounds(moving, order, criteria, Pairs(moving, criteria.clearance_m), corners)
    return Task(stance, Series(seconds, harmonics), information, bounds, criteria)


def _weights(robot: Robot, stance: Fixed | Standing, heavy: Array, criteria: MotionExcite) -> Array:
    """(rows,) 1/variance of a sample: of feet and IMU, carried to the base; of currents or torques."""
    noise = robot.noise
    std = []
    for k, joint in enumerate(robot.joints):
        unknown = criteria.unknown_noise * heavy[k]
        if joint.actuation == "current":
            std.append(abs(joint_prior(joint, "k_T")) * noise["i"] if "i" in noise else unknown)
        elif joint.actuation == "torque":
            std.append(noise.get("tau", unknown))
        else:
            std.append(np.inf)
    axes = 1.0 / np.square(std)
    if not robot.floating or not isinstance(stance, Standing):
        return np.asarray(axes)
    feet, mass = len(robot.contacts), robot.tree.mass
    lever = abs(float(stance.home[2]))  # [m] from the base down to the feet
    force = feet * noise.get("force", 1.0) ** 2 + (mass * noise.get("acc", 0.05)) ** 2
    moment = feet * noise.get("moment", 0.1) ** 2 + lever**2 * feet * noise.get("force", 1.0) ** 2
    return np.concatenate([np.full(3, 1.0 / force), np.full(3, 1.0 / moment), axes])
