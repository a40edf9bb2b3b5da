"""Of one slip in a log the doctor names the joint and what is wrong; of none it says nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from tests.fuzz.small_robots import JOINTS, simulate, simulated_logs, write_study

from exogauge.cli import main
from exogauge.logs.model import Log
from exogauge.plausibility.examine import examine_against_robot, examine_one_by_one
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

Columns = Mapping[str, np.ndarray]


@pytest.fixture(scope="module", params=[False, True], ids=["arm", "floating"])
def floating(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture(scope="module")
def logs(floating: bool) -> list[dict[str, np.ndarray]]:
    return list(simulated_logs(floating).values())


@pytest.fixture(scope="module")
def robot(floating: bool, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    folder = tmp_path_factory.mktemp("robot")
    write_study(folder, floating, {})
    return load_robot(folder)


def said(robot: Robot, logs: list[dict[str, np.ndarray]]) -> set[tuple[str, str]]:
    """(channel, rule) over all logs."""
    found = examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)])
    return {(finding.channel, finding.rule) for _, finding in found if finding.severity == "error"}


def as_log(number: int, columns: Columns) -> Log:
    return Log(f"log_{number}", columns["t"], {name: values for name, values in columns.items() if name != "t"})


def test_what_is_as_described_raises_no_doubt(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    assert said(robot, logs) == set()


@pytest.mark.parametrize("joint", JOINTS)
def test_a_current_with_the_wrong_sign_is_named(robot: Robot, logs: list[dict[str, np.ndarray]], joint: str) -> None:
    name = f"i.{joint}"
    assert said(robot, [each | {name: -each[name]} for each in logs]) == {(name, "effort_reversed")}


@pytest.mark.parametrize("joint", JOINTS)
def test_of_logs_with_a_device_a_wrong_sign_alone_is_named(
    robot: Robot, logs: list[dict[str, np.ndarray]], joint: str
) -> None:
    """Whatever springs pull on the joint, by as much as it bears itself, either way."""
    name, pulled = f"i.{joint}", list[dict[str, np.ndarray]]()
    for number, each in enumerate(logs):
        course = each[f"q.{joint}"] - each[f"q.{joint}"].mean()
        pull = (-1.0) ** number * each[name].std() * course / course.std()
        pulled.append(each | {name: each[name] + pull})
    assert list(examine_one_by_one(robot, [as_log(k, each) for k, each in enumerate(pulled)])) == []
    turned = [as_log(k, each | {name: -each[name]} if k else each) for k, each in enumerate(pulled)]
    found = {(log, each.channel, each.rule) for log, each in examine_one_by_one(robot, turned)}
    assert found <= {(log.name, name, "effort_reversed") for log in turned[1:]}
    bare = [as_log(k, each | {name: -each[name]} if k else each) for k, each in enumerate(logs)]
    found = {(log, each.channel, each.rule) for log, each in examine_one_by_one(robot, bare)}
    assert found == {(log.name, name, "effort_reversed") for log in bare[1:]}


@pytest.mark.parametrize("joint", JOINTS)
def test_a_position_with_the_wrong_sign_is_named(robot: Robot, logs: list[dict[str, np.ndarray]], joint: str) -> None:
    name = f"q.{joint}"
    assert said(robot, [each | {name: -each[name]} for each in logs]) == {(name, "position_reversed")}


@pytest.mark.parametrize(("one", "other"), [("j1", "j2"), ("j2", "j3")])
def test_exchanged_currents_are_named_as_such(
    robot: Robot, logs: list[dict[str, np.ndarray]], one: str, other: str
) -> None:
    names = f"i.{one}", f"i.{other}"
    swapped = [each | {names[0]: each[names[1]], names[1]: each[names[0]]} for each in logs]
    ((channel, rule),) = said(robot, swapped)
    assert rule == "efforts_exchanged"
    assert channel in names


@pytest.mark.parametrize("factor", [1000.0, 80.0, 0.001])
def test_a_current_in_another_unit_is_named_on_joints_that_bear_something(
    robot: Robot, logs: list[dict[str, np.ndarray]], factor: float
) -> None:
    assert said(robot, [each | {"i.j2": factor * each["i.j2"]} for each in logs]) == {("i.j2", "effort_scale")}


def test_degrees_are_named(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    assert said(robot, [each | {"q.j2": np.degrees(each["q.j2"])} for each in logs]) == {("q.j2", "position_scale")}


def test_channels_without_life_are_named(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    nothing = [each | {"i.j2": 0.0 * each["i.j2"]} for each in logs]
    assert said(robot, nothing) == {("i.j2", "effort_dead")}
    half = [each | {"i.j2": each["i.j2"] * (np.arange(len(each["t"])) % 1000 < 500)} for each in logs]
    assert ("i.j2", "effort_mostly_zero") in said(robot, half)
    if robot.floating:
        return  # a joint that stands on a swaying body bears as much as one that moves
    frozen = [each | {"q.j2": 0.0 * each["q.j2"]} for each in logs]
    assert ("q.j2", "position_dead") in said(robot, frozen)


def test_a_slip_in_one_log_is_told_of_that_log_only(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    turned = [each | ({"i.j2": -each["i.j2"]} if k == 1 else {}) for k, each in enumerate(logs)]
    found = list(examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(turned)]))
    assert {(log, finding.channel, finding.rule) for log, finding in found} == {("log_1", "i.j2", "effort_reversed")}


@pytest.mark.slow
@pytest.mark.parametrize("floating", [False, True], indirect=True)
def test_friction_that_is_a_spring_after_every_turn_is_no_slip(robot: Robot, floating: bool) -> None:
    """Gears creep before they slide: on small motions half of an effort is unlike gravity, inertia and friction."""
    slow = [simulate(floating, seed, 20.0, 0.06, 0.005) for seed in (1, 2)]
    found = list(examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(slow)]))
    assert [each for _, each in found if each.severity != "note"] == []


def test_that_nothing_moves_is_told_and_so_is_a_joint_that_does_not(
    robot: Robot, logs: list[dict[str, np.ndarray]]
) -> None:
    """What cannot be judged is not the same as nothing wrong."""
    rng = np.random.default_rng(0)

    def at_rest(each: dict[str, np.ndarray], *names: str) -> dict[str, np.ndarray]:
        return each | {n: each[n][0] + 1e-5 * rng.standard_normal(len(each[n])) for n in names}

    for names, told in ((("q.j1", "q.j2", "q.j3"), ("q.*", "warning")), (("q.j3",), ("i.j3", "note"))):
        still = [as_log(k, at_rest(each, *names)) for k, each in enumerate(logs)]
        found = [each for _, each in examine_against_robot(robot, still) if each.rule == "not_judged"]
        assert {(each.channel, each.severity) for each in found} == {told}


def test_joints_at_rest_say_nothing_of_their_signs(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    rng = np.random.default_rng(0)
    still = [
        each
        | {name: np.full_like(v, v[0]) + 1e-5 * rng.standard_normal(len(v)) for name, v in each.items() if name != "t"}
        for each in logs
    ]
    assert said(robot, [each | {"i.j2": -each["i.j2"]} for each in still]) == set()


def test_logs_of_which_none_can_be_looked_at_say_nothing(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    for count in (1, 5, 500):
        short = [
            {name: np.full(count, v[0]) if name != "t" else v[:count] for name, v in each.items()} for each in logs
        ]
        assert said(robot, short) == set()


@pytest.mark.parametrize(
    "other", [lambda q: q[::-1], lambda q: np.abs(q - q.mean()) + 0.3], ids=["backwards", "folded"]
)
def test_what_leaves_a_joint_unlike_its_description_is_told_as_that_or_as_the_nearest_of_what_is_tried(
    tmp_path: Path, other: Callable[[np.ndarray], np.ndarray]
) -> None:
    """A column of another recording, and an angle that lost its sign: no slip that is looked for."""
    write_study(tmp_path, False, {})
    wrong = [each | {"q.j1": other(each["q.j1"])} for each in simulated_logs(False).values()]
    found = examine_against_robot(load_robot(tmp_path), [as_log(k, each) for k, each in enumerate(wrong)])
    told = [finding for _, finding in found]
    assert told
    assert all(each.rule == "effort_unlike" or each.advice.startswith("look for something else first") for each in told)


@pytest.mark.parametrize("other", ["j1", "j3"])
def test_a_current_of_another_source_is_no_factor(robot: Robot, logs: list[dict[str, np.ndarray]], other: str) -> None:
    """Bodies that are off by a hundred times explain any column, and so does a factor of a hundred that frees them."""
    wrong = [each | {"i.j2": each[f"i.{other}"][::-1]} for each in logs]
    found = [each for _, each in examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(wrong)])]
    assert {each.channel for each in found} == {"i.j2"}
    assert {each.rule for each in found} == {"effort_unlike"}


def test_a_current_that_lost_its_sign_is_told(robot: Robot, logs: list[dict[str, np.ndarray]]) -> None:
    lost = [each | {"i.j2": np.abs(each["i.j2"])} for each in logs]
    found = [each for _, each in examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(lost)])]
    assert {each.channel for each in found} == {"i.j2"}
    assert "effort_scale" not in {each.rule for each in found}


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [8.0, -15.0, 40.0])
def test_an_encoder_that_was_zeroed_elsewhere_is_told_with_its_angle(
    robot: Robot, logs: list[dict[str, np.ndarray]], degrees: float
) -> None:
    """Which joint's, is said where the logs tell; otherwise all that explain it as well are."""
    off = [each | {"q.j2": each["q.j2"] + np.radians(degrees)} for each in logs]
    found = [each for _, each in examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(off)])]
    assert {each.rule for each in found} == {"position_offset"}
    own = [each for each in found if each.channel == "q.j2"]
    assert own or all("to q.j2" in each.detail for each in found)
    for each in own:
        assert np.degrees(each.value or 0.0) == pytest.approx(degrees, abs=2.5)


@pytest.mark.slow
def test_the_doctor_says_first_what_the_robot_contradicts(
    floating: bool, logs: list[dict[str, np.ndarray]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ("id_1", "id_2", "val_1")
    turned = {name: each | {"i.j2": -each["i.j2"]} for name, each in zip(names, logs, strict=True)}
    assert main(["doctor", str(write_study(tmp_path, floating, turned))]) == 1
    first, second, _, third, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("ERROR effort reversed: 1. Turn its sign")
    assert "channel" in second
    assert "i.j2" in third
    assert "id_1, id_2, val_1" in third
