"""Motions that tests plan, and tables of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.human import Contacts
from exogauge.motion.person import Person
from exogauge.motion.plan.asked import Asked
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing

SOON = replace(USUAL, approach_s=0.7)  # home is near


def bend(robot: MotionRobot, pitch: float, seconds: float) -> Asked:
    """One bend of the trunk, the pelvis tilting with it, hands straight up forward at once: fast where it is short."""
    step = 1.0 / USUAL.nodes_per_s
    time = step * np.arange(round(seconds / step) + 1)
    s = np.clip(2.0 * np.minimum(time, time[-1] - time) / time[-1], 0.0, 1.0)
    grown = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    q = np.tile(robot.home, (len(time), 1))
    q[:, at(robot, "torso_pitch")] += pitch * grown
    for side in "lr":
        q[:, at(robot, f"{side}_shoulder_pitch")] -= 1.2 * grown
    stray = np.full(robot.model.nq, np.inf)
    stray[:3], stray[3:6] = USUAL.pelvis_m, USUAL.pelvis_rad
    stray[robot.base + np.array(robot.beyond("thorax"))] = USUAL.limb_rad
    stray[robot.base + np.array(robot.torso)] = USUAL.trunk_rad
    return Asked(q, stray, step, np.ones((len(time), 2), bool), (standing(robot),) * len(time))


def at(robot: MotionRobot, joint: str) -> int:
    return robot.base + robot.joints.index(joint)


def weak(robot: MotionRobot, share: float) -> MotionRobot:
    """With that share of the torque that it has."""
    return replace(robot, limits=replace(robot.limits, torque=share * robot.limits.torque))


def raises_a_knee(seconds: float = 2.0) -> Person:
    """The left foot goes up by 20 cm and ahead by 10, and comes down where it was."""
    time = np.arange(0.0, seconds + 1e-9, 1.0 / USUAL.nodes_per_s)
    still = np.tile(np.eye(3), (len(time), 1, 1))
    s = np.clip((time - 0.5) / (seconds - 1.0), 0.0, 1.0)
    feet = np.zeros((len(time), 2, 3))
    feet[:, 0, [0, 2]] = np.sin(np.pi * s)[:, None] ** 2 * [0.1, 0.2]
    contacts = Contacts((s <= 0.0) | (s >= 1.0), np.ones(len(time), bool))
    return Person("raise", time, np.zeros((len(time), 3)), still, still, {}, 0.8, contacts, feet=feet)


Columns = dict[str, np.ndarray]


def columns_of(file: Path) -> Columns:
    names = file.read_text().splitlines()[0].split(",")
    return dict(zip(names, np.loadtxt(file, delimiter=",", skiprows=1).T, strict=True))


def table(file: Path, columns: Columns) -> Path:
    rows = np.column_stack(list(columns.values()))
    file.write_text("\n".join([",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n")
    return file


def with_cell(columns: Columns, name: str, row: int, value: float) -> Columns:
    changed = columns[name].copy()
    changed[row] = value
    return columns | {name: changed}
