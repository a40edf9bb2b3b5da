"""Motions that identify: gradients against differences, bounds against MuJoCo, promises against identification."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml
from scipy.signal import butter, sosfiltfilt
from tests.motion.robots import arm_folder, sample_folder

from exogauge.cli import main
from exogauge.criteria.motion_excite import MotionExcite
from exogauge.estimation.statistics import Statistics
from exogauge.experiment.envelope import random_motion, within
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording
from exogauge.identification.solution import first_weights
from exogauge.motion.excite.excited import Excited
from exogauge.motion.excite.known import information_of
from exogauge.motion.excite.promise import AS_STATED, planned_log
from exogauge.motion.excite.search import Task, point
from exogauge.motion.excite.task import by_encoders, task_of
from exogauge.motion.plan.judge import judge
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.base import BaseTurn
from exogauge.robots.moving.stance import Standing
from exogauge.robots.moving.touching import Pairs
from exogauge.studies.intake.robot_file import load_robot

QUICK = MotionExcite(top_hz=0.6, standing_hz=0.6, per_period=8, drawn=1, steps=25)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return arm_folder(tmp_path_factory.mktemp("arm"), "ur10")


@pytest.fixture(scope="module")
def human(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return sample_folder(tmp_path_factory.mktemp("robot"))


def task(path: Path, seconds: float = 6.0, criteria: MotionExcite = QUICK) -> Task:
    return task_of(load_robot(path.parent, path.name), load_motion_robot(path), seconds, criteria)


def bare(of: Task) -> Task:
    """Without shapes that could touch."""
    robot = replace(of.stance.robot, shapes=())
    return replace(of, bounds=replace(of.bounds, pairs=Pairs(robot, of.criteria.clearance_m)))


def along(of: Task, x: np.ndarray, dear: float, seed: int) -> tuple[float, float]:
    """A slope of the cost by the gradient, and by differences."""
    d = np.random.default_rng(seed).standard_normal(x.shape) * of.sizes
    there, back = (point(of, x + sign * 1e-5 * d, dear)[0] for sign in (1.0, -1.0))
    return float(np.sum(point(of, x, dear)[1] * d)), (there - back) / 2e-5


def test_the_gradient_of_an_arm_is_that_of_differences(arm: Path) -> None:
    """Beyond its bounds, so that these pull too."""
    of = bare(task(arm))
    x = 1.4 * random_motion(of, np.random.default_rng(0))
    assert point(of, x, 100.0)[2] > 1.0
    for seed in range(3):
        exact, differences = along(of, x, 100.0, seed)
        assert exact == pytest.approx(differences, rel=1e-5, abs=1e-5)


def test_what_comes_too_near_pulls(arm: Path) -> None:
    """Hulls have edges, at which a difference may be off; a slope that is wrong is off everywhere."""
    of = task(arm)
    x, clear = 1.4 * random_motion(of, np.random.default_rng(0)), bare(of)
    d = np.random.default_rng(1).standard_normal(x.shape) * of.sizes

    def pull(x: np.ndarray) -> float:
        return point(of, x, 100.0)[0] - point(clear, x, 100.0)[0]

    exact = float(np.sum((point(of, x, 100.0)[1] - point(clear, x, 100.0)[1]) * d))
    off = [abs((pull(x + h * d) - pull(x - h * d)) / (2 * h) - exact) for h in (1e-4, 3e-5, 1e-5, 3e-6, 1e-6)]
    assert abs(exact) > 1e-3
    assert min(off) < 1e-3 * abs(exact)


@pytest.mark.slow
def test_the_gradient_of_a_standing_robot_is_that_of_differences(human: Path) -> None:
    """Through legs that follow; with bounds so tight that balance, friction and position pull."""
    of = bare(task(human, 4.0, replace(QUICK, kept=0.3)))
    x = random_motion(of, np.random.default_rng(0))
    for seed in range(2):
        exact, differences = along(of, x, 10.0, seed)
        assert exact == pytest.approx(differences, rel=1e-5, abs=1e-5)


@pytest.mark.slow
def test_legs_torques_are_those_of_feet_that_share_evenly_and_they_pull(human: Path) -> None:
    """As `plan.judge` says them, which a search did not know; with bounds so low that they alone pull."""
    of = bare(task(human, 4.0, replace(QUICK, kept=0.9)))
    robot = of.stance.robot
    legs = np.concatenate([robot.leg(foot) for foot in (0, 1)]) - robot.base
    torque = np.full(len(robot.joints), np.inf)
    torque[legs] = 25.0
    robot = replace(robot, limits=replace(robot.limits, torque=torque))
    x = random_motion(of, np.random.default_rng(3))
    of = replace(of, bounds=replace(of.bounds, robot=robot))
    assert of.largest(x, 50.0)[1].startswith("torque of")
    planned = Excited(of, x)
    judged = judge(robot, planned, of.stance.place, rate=20.0)
    whole = planned.at(judged.time)
    found = {name: share for part in of.bounds.parts(*whole, of.loads(of.motion(whole)))
             for name, share in zip(part.names, part.share.T, strict=True)}  # fmt: skip
    for k in legs:  # of a bound and its other side the latter is named last
        assert found[f"torque of {robot.joints[k]}"] == pytest.approx(-judged.torque[:, k] / 25.0, abs=1e-4)
    for seed in range(2):
        exact, differences = along(of, x, 1000.0, seed)  # feet are held to 1e-9 m, which shows in differences
        assert exact == pytest.approx(differences, rel=2e-4)


def test_what_a_turning_base_feels_and_its_slopes() -> None:
    rng, h = np.random.default_rng(1), 1e-6
    q, v, a = rng.standard_normal((3, 3, 6)) * 0.5
    weights = rng.standard_normal((3, 3, 3))

    def total(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> float:
        felt = BaseTurn.of(q[:, 3:], v[:, 3:], a[:, 3:]).felt(a[:, :3])
        return float(sum(np.sum(w * each) for w, each in zip(weights, felt, strict=True)))

    turn = BaseTurn.of(q[:, 3:], v[:, 3:], a[:, 3:])
    later = BaseTurn.of(q[:, 3:] + h * v[:, 3:], v[:, 3:], a[:, 3:])
    spin = np.swapaxes(turn.rotation, 1, 2) @ (later.rotation - turn.rotation) / h
    assert turn.felt(a[:, :3])[1] == pytest.approx(np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], 1), abs=1e-5)
    slopes = turn.back(a[:, :3], *weights)
    for which, exact in enumerate(slopes):
        for at in np.ndindex(3, 6):
            parts = [[each.copy() for each in (q, v, a)] for _ in range(2)]
            parts[0][which][at] += h
            parts[1][which][at] -= h
            assert exact[at] == pytest.approx((total(*parts[0]) - total(*parts[1])) / (2 * h), abs=1e-6)


def test_encoders_noise_counts_as_what_it_makes_of_a_torque_below_the_cutoff(arm: Path) -> None:
    """White noise of the encoders, differentiated twice and low-passed, times inertia at home; beside white noise."""
    moving, rate, cutoff = load_motion_robot(arm), 1000.0, 10.0
    order = np.arange(len(moving.joints))
    said = by_encoders(moving, order, 1e-4, cutoff)
    noise = 1e-4 * np.random.default_rng(0).standard_normal((200_000, len(order)))
    low_pass = butter(20, 2.0 * cutoff / rate, output="sos")
    fast = np.gradient(np.gradient(sosfiltfilt(low_pass, noise, axis=0), axis=0), axis=0) * rate**2
    M = pin.crba(moving.model, moving.data, moving.home)
    torque = fast @ (np.triu(M) + np.triu(M, 1).T)
    white = sosfiltfilt(low_pass, np.random.default_rng(1).standard_normal(200_000)).var()  # what is left of variance 1
    assert said == pytest.approx(torque.var(axis=0) / white, rel=0.15)  # no filter has an edge
    assert by_encoders(moving, order, 0.0, cutoff).max() == 0.0


def test_feet_stay_and_rates_are_derivatives(human: Path) -> None:
    of = bare(task(human, 4.0))
    x = random_motion(of, np.random.default_rng(2))
    assert isinstance(of.stance, Standing)
    h = 5e-4  # below, what Newton leaves of the feet (1e-9 m) shows in differences
    time = np.array([1.3, 2.1])
    before, here, after = (of.stance.whole(*of.series.motion(x, time + k * h)) for k in (-1, 0, 1))
    assert here[1] == pytest.approx((after[0] - before[0]) / (2 * h), abs=1e-5)
    assert here[2] == pytest.approx((after[1] - before[1]) / (2 * h), abs=1e-4)
    planned = Excited(of, x)
    assert planned.at(np.array([0.0]))[0][0] == pytest.approx(of.stance.home, abs=1e-9)


@pytest.mark.slow
def test_a_robot_whose_home_lies_at_a_bound_can_move(arm: Path) -> None:
    of = bare(task(arm))
    robot = replace(of.stance.robot, home=of.stance.robot.limits.lower.copy())
    of = replace(of, stance=type(of.stance)(robot), bounds=replace(of.bounds, robot=robot, order=of.order))
    x = within(of, 3.0 * random_motion(of, np.random.default_rng(0)))
    assert of.largest(x)[0] <= 1.0 + 1e-9
    assert np.abs(x[:, :-1]).max() > 0.1


@pytest.mark.parametrize("seconds", ["0", "1e9", "nan"])
def test_a_length_that_makes_no_motion_is_refused(arm: Path, seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["motion", "excite", "--robot", str(arm), "--seconds", seconds]) == 2
    assert "seconds" in capsys.readouterr().err


def test_a_result_of_another_robot_is_refused(arm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = tmp_path / "results.json"
    other.write_text(json.dumps({"identification": {"parameters": [{"name": "m[x]", "std": 1.0}]}}))
    assert main(["motion", "excite", "--robot", str(arm), "--from", str(other)]) == 2
    assert "a parameter of this robot is missing" in capsys.readouterr().err


def test_an_axis_that_is_seldom_in_steady_motion_tells_no_noise(arm: Path) -> None:
    """Three rows are explained exactly by an axis' own coefficients, so that their noise would be nothing."""
    information = task(arm).information
    equations, rng = information.equations, np.random.default_rng(0)
    statistics = Statistics.empty(equations.size, equations.columns())
    for axis, rows in ((0, 3), (1, 100)):
        kind = equations.layout.axis(axis)
        statistics.add_rows(kind, np.asfortranarray(rng.normal(size=(rows, len(equations.columns()[kind]) + 1))))
    weights = first_weights(equations, statistics, information.prior)
    assert weights[equations.layout.axis(0)] == 0.0
    assert weights[equations.layout.axis(1)] > 0.0


@pytest.mark.slow
def test_what_logs_know_is_what_their_noise_leaves(arm: Path) -> None:
    """A log of a planned motion, then the same once more: the search's information is that of the identification."""
    of = task(arm)
    planned, robot = Excited(of, within(of, random_motion(of, np.random.default_rng(0)))), load_robot(arm.parent)
    log = planned_log(robot, planned)
    noisy = {
        name: values + 1e-3 * np.random.default_rng(1).standard_normal(len(values))
        for name, values in log.channels.items()
    }
    known = information_of(identify(robot, [Recording(replace(log, channels=noisy), False)], AS_STATED))
    after = task_of(robot, of.stance.robot, 6.0, QUICK, known)
    assert np.linalg.eigvalsh(after.information.before).min() > 0.0
    assert after.told(planned.x).cost < of.told(planned.x).cost


@pytest.mark.slow
def test_the_command_counts_in_what_a_study_knows(
    arm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A log of a first motion on disk, as a study; then the next motion, from the command alone."""
    shutil.copytree(arm.parent, tmp_path / "study")
    of, rng = task(arm), np.random.default_rng(1)
    first = planned_log(load_robot(arm.parent), Excited(of, within(of, random_motion(of, np.random.default_rng(0)))))
    noise = {"q": 1e-5, "tau": 0.1}
    columns = {"t": first.time} | {
        name: values + noise[name.partition(".")[0]] * rng.standard_normal(len(values))
        for name, values in first.channels.items()
    }
    table = np.column_stack(list(columns.values()))
    np.savetxt(tmp_path / "study" / "first.csv", table, "%.9g", ",", header=",".join(columns), comments="")
    logs = [{"file": "first.csv", "role": "identification"}]
    study = {"version": 1, "name": "first", "robot": "robot.yaml", "logs": logs}
    (tmp_path / "study" / "study.yaml").write_text(yaml.safe_dump(study))
    out = tmp_path / "next.csv"
    robot = str(tmp_path / "study" / "robot.yaml")
    command = ["motion", "excite", "--robot", robot, "--seconds", "3", "--json", "--out", str(out)]
    assert main([*command, "--study", str(tmp_path / "study")]) == 0
    told = [each for each in json.loads(out.with_suffix(".json").read_text())["parameters"] if each["before"] > 0.0]
    left = np.array([each["std"] / each["before"] for each in told])
    assert np.median(left) < 1.0
    assert left.min() < 0.8
    assert left.max() < 2.0  # of a longer log noise is known better, and may be told as more
