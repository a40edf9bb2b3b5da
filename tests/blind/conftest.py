from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest

from exogauge.blind.generator import arm
from exogauge.blind.generator.axis_run import AxisRun, axis_runs
from exogauge.blind.generator.excess import Baseline, baselines
from exogauge.blind.generator.motion import Motion, excitations
from exogauge.blind.generator.robot_files import robot_urdf
from exogauge.blind.generator.true_robot import TrueRobot, draw_robot
from exogauge.synthetic.robot_facts import Link


@dataclass(frozen=True)
class Arm:
    """A drawn arm that has run two logs; model: the same bodies in pinocchio."""

    links: Sequence[Link]
    robot: TrueRobot
    motion: Motion
    runs: list[AxisRun]
    absorbing: list[Baseline]
    model: pin.Model


@pytest.fixture(scope="session")
def arm6() -> Arm:
    links = arm.draw_arm(np.random.default_rng(4))
    robot = draw_robot(np.random.default_rng(5), links)
    joints = [link.joint for link in links if link.joint is not None]
    motion = excitations(np.random.default_rng(6), joints, 2, 12.0)
    runs = axis_runs(np.random.default_rng(7), robot, motion)
    model = pin.buildModelFromXML(robot_urdf(arm.NAME, links))
    for body, phi in enumerate(robot.phi):
        model.inertias[body + 1] = pin.Inertia.FromDynamicParameters(phi)
    return Arm(links, robot, motion, runs, baselines(robot.tree, motion, runs), model)
