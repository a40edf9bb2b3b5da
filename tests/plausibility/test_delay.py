"""Currents that were stored late or early are told, with how much; those that were not are left in peace."""

from __future__ import annotations

import numpy as np
import pytest
from tests.fuzz.small_robots import JOINTS, simulated_logs, write_study
from tests.plausibility.test_examine import as_log

from exogauge.logs.findings import Finding
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

Logs = list[dict[str, np.ndarray]]


@pytest.fixture(scope="module", params=[False, True], ids=["arm", "floating"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Logs]:
    folder = tmp_path_factory.mktemp("robot")
    write_study(folder, request.param, {})
    return load_robot(folder), list(simulated_logs(request.param).values())


def late(columns: dict[str, np.ndarray], seconds: float, joints: tuple[str, ...] = JOINTS) -> dict[str, np.ndarray]:
    t = columns["t"]
    return columns | {f"i.{name}": np.interp(t - seconds, t, columns[f"i.{name}"]) for name in joints}


def said(robot: Robot, logs: Logs) -> list[Finding]:
    """Of the first log; that all logs are told the same is checked."""
    found = list(examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)]))
    first = [finding for log, finding in found if log == "log_0"]
    assert len(found) == len(first) * len(logs)
    return first


@pytest.mark.parametrize("seconds", [0.04, 0.06, -0.05])
def test_a_delay_that_all_joints_share_is_one_warning_with_its_milliseconds(
    made: tuple[Robot, Logs], seconds: float
) -> None:
    robot, logs = made
    (finding,) = said(robot, [late(each, seconds) for each in logs])
    assert (finding.severity, finding.rule) == ("warning", "effort_delay")
    assert finding.value == pytest.approx(seconds, abs=0.01)
    assert all(f"i.{name}" in finding.channel + finding.detail for name in JOINTS)
    assert ("late" in finding.detail) == (seconds > 0.0)


@pytest.mark.slow
def test_friction_that_the_low_pass_turns_before_its_joint_hides_no_delay(made: tuple[Robot, Logs]) -> None:
    """Right before a turn efforts fit as if they were later: moments there told the joints not to be late."""
    robot, logs = made
    (finding,) = said(robot, [late(_rubbing(each, 10.0), 0.03) for each in logs])
    assert finding.rule == "effort_delay"
    assert finding.value == pytest.approx(0.03, abs=0.01)


def _rubbing(columns: dict[str, np.ndarray], amperes: float) -> dict[str, np.ndarray]:
    speeds = {name: np.gradient(columns[f"q.{name}"], columns["t"]) for name in JOINTS}
    smooth = {name: np.convolve(speed, np.ones(9) / 9.0, "same") for name, speed in speeds.items()}
    return columns | {f"i.{name}": columns[f"i.{name}"] + amperes * np.tanh(smooth[name] / 0.012) for name in JOINTS}


def test_of_one_late_joint_no_other_is_told(made: tuple[Robot, Logs]) -> None:
    """What a joint gains alone has to be as sure as what all gain together: that takes a longer delay."""
    robot, logs = made
    (finding,) = said(robot, [late(each, 0.1, ("j1",)) for each in logs])
    assert (finding.channel, finding.rule) == ("i.j1", "effort_delay")
    assert finding.value == pytest.approx(0.1, abs=0.015)
    assert "alike" not in finding.detail


@pytest.mark.parametrize("seconds", [0.1, 0.5, -0.35])
def test_one_log_whose_efforts_are_of_another_clock_is_told_and_no_other(
    made: tuple[Robot, Logs], seconds: float
) -> None:
    robot, logs = made
    shifted = [late(each, seconds) if k == 1 else each for k, each in enumerate(logs)]
    found = list(examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(shifted)]))
    ((log, finding),) = found
    assert (log, finding.rule) == ("log_1", "effort_clock")
    assert finding.value == pytest.approx(seconds, abs=0.05)
    assert "delay_s" in finding.advice


def test_two_samples_are_not_told(made: tuple[Robot, Logs]) -> None:
    robot, logs = made
    assert said(robot, [late(each, 0.02) for each in logs]) == []


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_coloured_noise_is_no_delay(made: tuple[Robot, Logs], seed: int) -> None:
    """A slow wander of a tenth of the current: what is left is alike at neighbours, and some shift always fits it."""
    robot, logs = made
    rng = np.random.default_rng(seed)

    def wander(values: np.ndarray) -> np.ndarray:
        slow = np.convolve(rng.standard_normal(len(values) + 99), np.ones(100), "valid")
        return values + 0.1 * np.std(values) * slow / np.std(slow)

    noisy = [each | {f"i.{name}": wander(each[f"i.{name}"]) for name in JOINTS} for each in logs]
    assert said(robot, noisy) == []


def test_one_late_log_among_others_of_another_rate_raises_no_exception(made: tuple[Robot, Logs]) -> None:
    robot, logs = made
    half = {name: values[::3] for name, values in logs[0].items()}
    assert said(robot, [half, *logs[1:]]) == []


def _creeping(columns: dict[str, np.ndarray], amperes: float, way: float) -> dict[str, np.ndarray]:
    """With friction of bristles that turn round over such a way (Dahl)."""
    rubs = dict(columns)
    for name in JOINTS:
        steps, bristle = np.diff(columns[f"q.{name}"], prepend=columns[f"q.{name}"][0]) / way, 0.0
        borne = np.zeros(len(steps))
        for k, step in enumerate(steps):
            bristle = np.sign(step) + (bristle - np.sign(step)) * np.exp(-abs(step))
            borne[k] = bristle
        rubs[f"i.{name}"] = columns[f"i.{name}"] + amperes * borne
    return rubs


@pytest.mark.slow
def test_joints_that_creep_are_of_no_other_clock(made: tuple[Robot, Logs]) -> None:
    """One log of them was told to be 180 ms late, and spoiled."""
    robot, logs = made
    found = examine_against_robot(robot, [as_log(k, _creeping(each, 2.0, 0.06)) for k, each in enumerate(logs)])
    assert not [each for _, each in found if each.rule in ("effort_clock", "effort_delay")]


@pytest.mark.slow
@pytest.mark.parametrize("way", [0.005, 0.03])
def test_friction_that_creeps_is_told_beside_a_delay_that_all_logs_share(made: tuple[Robot, Logs], way: float) -> None:
    robot, logs = made
    (finding,) = said(robot, [_creeping(each, 0.3, way) for each in logs])
    assert finding.rule == "effort_delay"
    assert "creep" in finding.advice


@pytest.mark.slow
def test_a_log_of_another_clock_is_told_although_joints_creep(made: tuple[Robot, Logs]) -> None:
    robot, logs = made
    creeping = [_creeping(each, 0.1, 0.005) for each in logs]
    shifted = [late(each, 0.5) if k == 1 else each for k, each in enumerate(creeping)]
    found = list(examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(shifted)]))
    assert [(log, each.rule) for log, each in found] == [("log_1", "effort_clock")]
