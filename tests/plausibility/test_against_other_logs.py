"""What only one of several logs lacks is told of that log; what a position at one number explains, of that position."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.fuzz.small_robots import robot_yaml, simulate, write_study
from tests.plausibility.long_arm import long_arm, record
from tests.plausibility.test_examine import as_log, floating, logs, said  # noqa: F401

from exogauge.logs.findings import Finding
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

Logs = list[dict[str, np.ndarray]]


@pytest.fixture(scope="module")
def robot(floating: bool, tmp_path_factory: pytest.TempPathFactory) -> Robot:  # noqa: F811
    """Its bodies stated as well as they are known, to a tenth: of bodies in doubt by more less can be told."""
    folder = tmp_path_factory.mktemp("robot")
    write_study(folder, floating, {}, robot_yaml(floating) + "inertial_prior_std: {default: 0.1}\n")
    return load_robot(folder)


def told(robot: Robot, logs: Logs) -> list[tuple[str, Finding]]:  # noqa: F811
    found = examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(logs)])
    return [(log, each) for log, each in found if (each.rule, each.severity) != ("sign_unsure", "note")]


def with_one(logs: Logs, changed: dict[str, np.ndarray]) -> Logs:  # noqa: F811
    return [each | (changed if k == 1 else {}) for k, each in enumerate(logs)]


@pytest.mark.parametrize("kinds", ["q", "i", "qi"])
@pytest.mark.parametrize("pair", [("j1", "j2"), ("j2", "j3")])
def test_two_joints_that_are_exchanged_in_one_log_are_named_there(
    robot: Robot,
    logs: Logs,  # noqa: F811
    pair: tuple[str, str],
    kinds: str,
) -> None:
    swapped = {f"{kind}.{one}": logs[1][f"{kind}.{other}"] for kind in kinds for one, other in (pair, pair[::-1])}
    rule = {"q": "positions_exchanged", "i": "efforts_exchanged", "qi": "joints_exchanged"}[kinds]
    found = told(robot, with_one(logs, swapped))
    assert {(log, each.rule) for log, each in found} == {("log_1", rule)}
    assert all(name in found[0][1].channel + found[0][1].detail for name in pair)


def test_of_many_logs_those_that_a_robot_is_identified_from_are_looked_at_first(robot: Robot, logs: Logs) -> None:  # noqa: F811
    many = [logs[k % len(logs)] for k in range(12)]
    many[3] = many[3] | {"i.j2": -many[3]["i.j2"]}
    named = [as_log(k, each) for k, each in enumerate(many)]
    found = list(examine_against_robot(robot, named, fitted={"log_3", "log_5"}))
    assert {(log, each.channel, each.rule) for log, each in found} == {("log_3", "i.j2", "effort_reversed")}


@pytest.mark.slow
def test_another_recordings_efforts_are_told_of_their_log_alone(robot: Robot, logs: Logs) -> None:  # noqa: F811
    """Six slips of no use were found, and nothing was said; or all logs were blamed for what one of them leaves."""
    names = [name for name in logs[1] if name.startswith("i.")]
    found = told(robot, with_one(logs, {name: np.roll(logs[1][name], 700)[::-1] for name in names}))
    assert {log for log, _ in found} == {"log_1"}
    assert {each.rule for _, each in found} <= {"effort_unlike", "effort_clock"}


@pytest.mark.parametrize("degrees", [35.0])
def test_an_encoder_that_was_set_anew_before_one_log_is_told_there_with_its_angle(
    tmp_path: Path, degrees: float
) -> None:
    """Silent before, or another joint's effort was told to be unlike: zeros were sought in all logs together."""
    arm = [record(seed) for seed in (1, 2, 3)]
    moved = with_one(arm, {"q.lift": arm[1]["q.lift"] + np.radians(degrees)})
    ((log, found),) = told(long_arm(tmp_path), moved)
    assert (log, found.channel, found.rule) == ("log_1", "q.lift", "zero_moved")
    assert np.degrees(found.value or 0.0) == pytest.approx(degrees, abs=2.5)


def test_a_slip_of_one_log_that_is_wrong_otherwise_as_well_is_the_nearest_of_what_is_tried(tmp_path: Path) -> None:
    """Another robot's log may look like exchanged joints, and is not mended by exchanging them."""
    arm = [record(seed) for seed in (1, 2, 3)]
    swapped = {f"q.{one}": arm[1][f"q.{other}"] for one, other in (("pan", "lift"), ("lift", "pan"))}
    swapped |= {f"i.{name}": 3.0 * arm[0][f"i.{name}"][::-1] for name in ("elbow", "wrist")}
    found = told(long_arm(tmp_path), with_one(arm, swapped))
    assert {log for log, _ in found} == {"log_1"}
    assert "effort_unlike" in {each.rule for _, each in found}
    errors = [each for _, each in found if each.severity == "error"]
    assert errors
    assert all(each.advice.startswith("look for something else first") for each in errors)


def test_short_pieces_of_logs_as_they_are_raise_no_doubt(tmp_path: Path) -> None:
    """In five seconds a joint may bear so little that bodies ten times as heavy explain it a little better."""
    arm = [record(seed) for seed in (1, 2, 3)]
    pieces = [{name: v[k : k + 500] for name, v in each.items()} for each in arm for k in (0, 500)]
    assert [each for _, each in told(long_arm(tmp_path), pieces) if each.rule != "not_judged"] == []


@pytest.mark.parametrize(
    ("joint", "rub", "rule"),
    [
        ("lift", 8.0, "joint_reversed"),
        ("wrist", 4.0, "joint_reversed"),
        ("wrist", 8.0, "sign_unsure"),
        ("pan", 4.0, "sign_unsure"),
    ],
)
def test_a_joint_that_is_turned_wholly_is_named_or_undecided_though_friction_is_most_of_it(
    tmp_path: Path, joint: str, rub: float, rule: str
) -> None:
    """Silent before: both signs turned, friction is as it was, and other bodies make up for the little that is borne.
    A pan that turns round is the mirror image of an arm that is alike on both sides."""
    robot, names = long_arm(tmp_path), (f"q.{joint}", f"i.{joint}")
    stiff = [record(seed, rub=rub) for seed in (1, 2, 3)]
    turned = [each | {name: -each[name] for name in names} for each in stiff]
    found = [each for _, each in examine_against_robot(robot, [as_log(k, each) for k, each in enumerate(turned)])]
    assert (f"q.{joint}", rule) in {(each.channel, each.rule) for each in found}
    assert {each.channel for each in found if each.severity == "error"} <= {f"q.{joint}"}
    assert told(robot, stiff) == []


@pytest.mark.parametrize(
    ("rub", "pair"), [(2.0, ("lift", "elbow")), (4.0, ("pan", "elbow")), (8.0, ("elbow", "wrist"))]
)
def test_two_joints_that_are_exchanged_are_named_though_neither_is_in_doubt(
    tmp_path: Path, rub: float, pair: tuple[str, str]
) -> None:
    """Silent before, or gravity was told to pull elsewhere: other bodies make up for it."""
    stiff = [record(seed, rub=rub) for seed in (1, 2, 3)]
    other = dict(zip(pair, pair[::-1], strict=True))
    swapped = [each | {f"{k}.{one}": each[f"{k}.{other[one]}"] for k in "qi" for one in pair} for each in stiff]
    found = [each for _, each in told(long_arm(tmp_path), swapped)]
    assert {(each.channel, each.rule) for each in found} == {(f"q.{pair[0]}", "joints_exchanged")}
    assert f"q.{pair[1]}" in found[0].detail


@pytest.mark.parametrize("joint", ["lift", "elbow", "wrist"])
def test_a_sign_that_other_bodies_would_explain_is_named_all_the_same(tmp_path: Path, joint: str) -> None:
    """Without friction to tell it, a turned current asks for a centre of mass on the other side, and leaves little."""
    robot, name = long_arm(tmp_path), f"i.{joint}"
    light = [record(seed, rub=0.1) for seed in (1, 2, 3)]
    assert said(robot, [each | {name: -each[name]} for each in light]) == {(name, "effort_reversed")}
    assert told(robot, light) == []


@pytest.mark.slow
@pytest.mark.parametrize(("part", "every"), [(1.0, True), (1.0, False), (0.5, False)])
def test_a_position_that_stays_while_others_bear_its_motion_is_named(tmp_path: Path, part: float, every: bool) -> None:
    """The joint itself says nothing, as by its position it does not move; that of its neighbours is no slip of them."""

    def stopped(each: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        q, start = each["q.lift"].copy(), round((1.0 - part) * len(each["t"]))
        q[start:] = q[start]
        return each | {"q.lift": q}

    arm = [record(seed) for seed in (1, 2, 3)]
    found = told(long_arm(tmp_path), [stopped(each) if every or k == 1 else each for k, each in enumerate(arm)])
    judged = [(log, each) for log, each in found if each.rule != "not_judged"]
    assert {(each.channel, each.rule) for _, each in judged} == {("q.lift", "position_dead")}
    assert {log for log, _ in judged} <= ({"log_0", "log_1", "log_2"} if every else {"log_1"})


def test_a_joint_that_stands_still_while_all_is_well_is_not_blamed(tmp_path: Path) -> None:
    write_study(tmp_path, False, {})
    robot = load_robot(tmp_path)
    rng, at_rest = np.random.default_rng(3), []
    for seed in (1, 2, 3):
        each = simulate(False, seed, 20.0)
        noise = {f"i.{name}": 0.4 + 0.02 * rng.standard_normal(len(each["t"])) for name in ("j1", "j2", "j3")}
        at_rest.append(each | {f"q.{name}": np.full(len(each["t"]), 0.3) for name in ("j1", "j2", "j3")} | noise)
    assert {each.rule for _, each in told(robot, at_rest)} == {"not_judged"}
