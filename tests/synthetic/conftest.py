from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pytest

from exogauge.synthetic import motion
from exogauge.synthetic.hidden import parse_hidden
from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.simulation import Recording, simulate
from exogauge.synthetic.study import LogPlan, write_study
from exogauge.synthetic.true_robot import TrueRobot, a_priori_robot, draw_robot

SHORT = (LogPlan("id_1", "identification", "excitation", 12.0), LogPlan("bend_plain", "validation", "bend", 7.0))


@dataclass(frozen=True)
class Run:
    robot: TrueRobot
    plan: motion.Plan
    recording: Recording


@pytest.fixture(scope="session")
def planner() -> mujoco.MjModel:
    return mujoco_model(a_priori_robot())


@pytest.fixture(scope="session")
def run(planner: mujoco.MjModel) -> Run:
    """Twelve seconds of excitation, without noise; one knee has a Stribeck peak."""
    rng = np.random.default_rng(7)
    robot = draw_robot(rng, parse_hidden(["stribeck@l_knee_pitch"], rng))
    plan = motion.excitation(rng, 12.0, planner)
    return Run(robot, plan, simulate(mujoco_model(robot), robot, plan, lambda seconds: None))


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two short logs."""
    out = tmp_path_factory.mktemp("sample")
    write_study(out, 3, logs=SHORT)
    return out
