"""A robot as it is identified and as it moves becomes what is planned for it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
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
IntArray = NDArray[np.intp]


def task_of(
    robot: Robot, moving: MotionRobot, seconds: float, criteria: MotionExcite = USUAL, known: Array | None = None
) -> Task:
    """known: (P, P) information before, where there is more than the maker's. Raises BadRobot."""
    order = np.array([moving.joints.index(joint.name) for joint in robot.joints], dtype=np.intp)
    stance = Standing(moving, criteria) if robot.floating else Fixed(moving)
    if robot.floating and robot.tree.bodies[0] != next(iter(moving.links)):
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
        equations, prior, _weights(robot, stance, heavy, order, criteria), criteria.rate_hz, criteria.turn_s,
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
    return Task(stance, Series(seconds, harmonics), bounds, criteria, information=information)


def _weights(robot: Robot, stance: Fixed | Standing, heavy: Array, order: IntArray, criteria: MotionExcite) -> Array:
    """(rows,) 1/variance of a sample: of feet and IMU, carried to the base; of currents or torques; and of
    encoders, whose noise sits in the regressor as inertia times acceleration."""
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
    encoders = by_encoders(stance.robot, order, noise.get("q", 0.0), criteria.cutoff_hz)
    axes = 1.0 / (np.square(std) + encoders)
    if not robot.floating or not isinstance(stance, Standing):
        return np.asarray(axes)
    feet, mass = len(robot.contacts), robot.tree.mass
    lever = abs(float(stance.home[2]))  # [m] from the base down to the feet
    force = feet * noise.get("force", 1.0) ** 2 + (mass * noise.get("acc", 0.05)) ** 2
    moment = feet * noise.get("moment", 0.1) ** 2 + lever**2 * feet * noise.get("force", 1.0) ** 2
    return np.concatenate([np.full(3, 1.0 / force), np.full(3, 1.0 / moment), axes])


def by_encoders(moving: MotionRobot, order: IntArray, noise: float, cutoff_hz: float) -> Array:
    """(J,) variance that white noise [rad] of every encoder makes of a sample of each joint's torque at home, as white
    noise that is as large below the cut-off: (2 π f)⁴ of it, averaged from 0 to there."""
    inertia = np.asarray(pin.crba(moving.model, moving.model.createData(), moving.home))
    inertia = np.triu(inertia) + np.triu(inertia, 1).T
    own = inertia[np.ix_(moving.base + order, moving.base + order)]
    return np.asarray(np.sum(own**2, axis=1) * noise**2 * (2.0 * np.pi * cutoff_hz) ** 4 / 5.0)
