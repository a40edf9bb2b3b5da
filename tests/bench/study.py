"""Talos as a user has it: a log with currents, IMU and two foot sensors, brought to the equations that are solved."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from tests.bench.problems import RATE_HZ, Problem

from exogauge.effects.catalogue import choose
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared, prepare
from exogauge.identification.turns import rest_detection
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.row_blocks import RowBlocks

Array = NDArray[np.float64]

EFFECTS = ("motor_gain", "viscous", "coulomb", "static_friction", "motor_offset")
FEET = {"l_foot": "leg_left_6_joint", "r_foot": "leg_right_6_joint"}
CUTOFF_HZ = 10.0
GAIN = 5.0  # [N·m/A] of every motor


def robot_of(problem: Problem) -> Robot:
    """Current-driven joints; a floating robot has an IMU in the base and sensors in the feet."""
    tree = problem.tree
    joints = tuple(Joint(name, "current", prior={"k_T": GAIN}) for name in tree.joints)
    sensors: tuple[WrenchSensor, ...] = ()
    if tree.floating:
        link = {joint: tree.bodies[list(tree.dof).index(k)] for k, joint in enumerate(tree.joints)}
        sensors = tuple(WrenchSensor(name, link[joint], "contact", 1.0) for name, joint in FEET.items())
    pose = pin.SE3.Identity() if tree.floating else None
    return Robot(problem.name, tree, joints, pose, sensors, np.eye(len(joints)))


def log_of(problem: Problem) -> Log:
    """Channels of the contract; every measured force of the base is carried by the sensors as they are."""
    motion, names, channels = problem.motion, problem.tree.joints, dict[str, Array]()
    first = 6 if problem.tree.floating else 0
    for k, name in enumerate(names):
        channels[f"q.{name}"] = motion.q[:, k]
        friction = 2.0 * np.tanh(motion.dq[:, k] / 0.01) + 0.5 * motion.dq[:, k]
        channels[f"i.{name}"] = (problem.forces[:, first + k] + friction) / GAIN
    if first:
        for k, axis in enumerate("xyz"):
            channels[f"acc.{axis}"], channels[f"gyro.{axis}"] = motion.acc[:, k], motion.gyro[:, k]
        for foot in FEET:
            for k, component in enumerate(("fx", "fy", "fz", "mx", "my", "mz")):
                channels[f"ft.{foot}.{component}"] = 0.5 * problem.forces[:, k]
    return Log(problem.name, np.arange(problem.samples) / RATE_HZ, channels)


def equations_of(problem: Problem) -> tuple[Equations, Prepared]:
    """The equations with five effects per joint, and the log filtered at 10 Hz; all samples kept."""
    robot, log = robot_of(problem), log_of(problem)
    blocks = RowBlocks(problem.tree, problem.base, robot.axes_from_joints)
    equations = Equations(robot, blocks, problem.base, choose(EFFECTS))
    prepared = prepare(robot, log, CUTOFF_HZ, rest_detection(robot, [log], CUTOFF_HZ))
    return equations, prepared
