from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pytest

from exogauge.synthetic import motion
from exogauge.synthetic.disturbances import IDEAL
from exogauge.synthetic.hidden import parse_hidden
from exogauge.synthetic.lab import drawn_lab
from exogauge.synthetic.log_plans import LogPlan
from exogauge.synthetic.log_runs import Bench
from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.simulation import Recording, simulate
from exogauge.synthetic.study import write_study
from exogauge.synthetic.suit import fitted_suit
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
def bench(planner: mujoco.MjModel) -> Bench:
    """A drawn robot and both suits on it."""
    suits = {kind: fitted_suit(kind, planner, np.random.default_rng(12)) for kind in ("normal", "modified")}
    return Bench(3, draw_robot(np.random.default_rng(11)), suits, drawn_lab(3, IDEAL, ()))


@pytest.fixture(scope="session")
def worn(bench: Bench, planner: mujoco.MjModel) -> dict[tuple[str, str], Run]:
    """Seven seconds each of a bend in either suit and a twist in the normal one, by motion and kind of suit."""
    runs = {}
    for name, kind in (("bend", "normal"), ("bend", "modified"), ("twist", "normal")):
        plan = {"bend": motion.bend, "twist": motion.twist}[name](np.random.default_rng(5), 7.0, planner)
        model = mujoco_model(bench.robot, bench.suits[kind])
        runs[name, kind] = Run(bench.robot, plan, simulate(model, bench.robot, plan, lambda seconds: None))
    return runs


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two short logs."""
    out = tmp_path_factory.mktemp("sample")
    write_study(out, 3, suit="none", logs=SHORT)
    return out
