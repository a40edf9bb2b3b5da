"""An IMU that sits otherwise than robot.yaml states is told, with what mends it; one that sits right is not."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from tests.fuzz.small_robots import simulated_logs, write_study
from tests.plausibility.test_examine import as_log

from exogauge.logs.findings import Expectation, Finding
from exogauge.logs.gyro_rules import gyro_against_tilt
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

Logs = list[dict[str, np.ndarray]]
STATED = pin.utils.rotate("x", 0.4)
YAW = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
ROLL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
CYCLE = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])


@pytest.fixture(scope="module")
def logs() -> Logs:
    return list(simulated_logs(True).values())


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    folder: Path = tmp_path_factory.mktemp("robot")
    write_study(folder, True, {})
    return load_robot(folder)


def turned(
    columns: dict[str, np.ndarray], P: np.ndarray, kinds: tuple[str, ...] = ("acc", "gyro")
) -> dict[str, np.ndarray]:
    """As an IMU would have logged it whose axes are those of P: logged = P true."""
    result = dict(columns)
    for kind in kinds:
        logged = np.column_stack([columns[f"{kind}.{axis}"] for axis in "xyz"]) @ P.T
        result |= {f"{kind}.{axis}": logged[:, i] for i, axis in enumerate("xyz")}
    return result


def said(robot: Robot, logs: Logs) -> list[tuple[str, Finding]]:
    return list(examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)]))


def mapped(advice: str, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What a reader does who follows the advice."""
    said = re.findall(r"([xyz]) := (-?)([xyz])", advice)
    assert len(said) == 3, advice
    follow = {
        f"{kind}.{axis}": (-1.0 if minus else 1.0) * columns[f"{kind}.{source}"]
        for kind in ("acc", "gyro") for axis, minus, source in said
    }  # fmt: skip
    return columns | follow


def test_an_imu_as_stated_is_not_doubted(robot: Robot, logs: Logs) -> None:
    assert said(robot, logs) == []


@pytest.mark.parametrize("P", [YAW, ROLL, CYCLE, YAW.T @ ROLL, np.diag([-1.0, -1.0, 1.0])])
def test_exchanged_axes_are_told_once_in_each_log_and_the_advice_mends_them(
    robot: Robot, logs: Logs, P: np.ndarray
) -> None:
    wrong = [turned(each, P) for each in logs]
    found = said(robot, wrong)
    assert [(log, each.severity, each.channel, each.rule) for log, each in found] == [
        (f"log_{k}", "error", "acc", "imu_frame") for k in range(len(logs))
    ]
    for (_, finding), each, clean in zip(found, wrong, logs, strict=True):
        mended = mapped(finding.advice, each)
        for name in ("acc.x", "acc.y", "acc.z", "gyro.x", "gyro.y", "gyro.z"):
            assert np.array_equal(mended[name], clean[name])


@pytest.mark.parametrize("P", [YAW, CYCLE, CYCLE.T])
def test_a_gyro_turned_against_its_accelerometer_is_told_and_mended(logs: Logs, P: np.ndarray) -> None:
    for k, clean in enumerate(logs[:2]):
        wrong = turned(clean, P, ("gyro",))
        (finding,) = gyro_against_tilt(as_log(k, wrong), Expectation())
        assert (finding.severity, finding.rule) == ("error", "gyro_frame")
        mended = mapped(finding.advice, wrong)
        assert all(np.array_equal(mended[f"gyro.{axis}"], clean[f"gyro.{axis}"]) for axis in "xyz")
        assert list(gyro_against_tilt(as_log(k, clean), Expectation())) == []


def test_a_skew_mounting_is_told_with_its_angles(robot: Robot, logs: Logs) -> None:
    """robot.yaml's rpy is that of R_base_imu: with logged = P true, R_base_imu becomes R_stated P^T."""
    P = pin.rpy.rpyToMatrix(0.3, -0.5, 0.9)
    for _, finding in said(robot, [turned(each, P) for each in logs]):
        assert ":=" not in finding.advice
        angles = re.search(r"rpy: \[(.*?)\]", finding.advice)
        assert angles
        told = pin.rpy.rpyToMatrix(*(float(each) for each in angles[1].split(",")))
        assert np.linalg.norm(pin.log3(told.T @ STATED @ P.T)) < np.radians(3.0)


def test_a_mounting_a_few_degrees_off_is_not_told(robot: Robot, logs: Logs) -> None:
    P = pin.utils.rotate("y", np.radians(5.0))
    assert [each for _, each in said(robot, [turned(each, P) for each in logs]) if each.channel == "acc"] == []


def test_an_accelerometer_with_its_sign_reversed_is_told_as_such(robot: Robot, logs: Logs) -> None:
    found = said(robot, [turned(each, -np.eye(3), ("acc",)) for each in logs])
    assert {(each.channel, each.rule) for _, each in found} == {("acc", "acceleration_sign")}


def test_where_gravity_stays_along_one_axis_only_the_tilt_is_told(robot: Robot, logs: Logs) -> None:
    """A body that stands still: about the vertical the IMU may be turned as it likes, and nobody can tell."""
    still = {name: np.full_like(v, v[300]) for name, v in logs[0].items()} | {"t": logs[0]["t"]}
    up = np.array([still[f"acc.{axis}"][0] for axis in "xyz"])
    about_vertical = pin.exp3(1.5 * up / np.linalg.norm(up))
    ((_, nothing),) = said(robot, [turned(still, about_vertical)])
    assert nothing.rule == "not_judged"
    ((_, finding),) = said(robot, [turned(still, ROLL)])
    assert finding.rule == "imu_frame"
    assert "the turn about gravity these logs cannot tell" in finding.detail


@pytest.mark.slow
def test_feet_that_do_not_bear_the_robot_alone_say_nothing_of_the_imu(robot: Robot, logs: Logs) -> None:
    half = [each | {name: 0.5 * v for name, v in each.items() if name.startswith("ft.")} for each in logs]
    found = said(robot, [turned(each, ROLL) for each in half])
    assert [each for _, each in found if each.rule in ("imu_frame", "acceleration_sign")] == []
