"""Feet whose columns were exchanged, or that are late, are named, and no joint for them; others raise no doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.discrepancy.test_partial_names import AXES, FEET, record, robot  # noqa: F401

from exogauge.logs.model import Log
from exogauge.plausibility.examine import examine_against_robot, examine_one_by_one
from exogauge.robots.description import Robot


@pytest.fixture(scope="module")
def logs() -> list[Log]:
    return [record(seed, 0.0, 0.0) for seed in (4, 5)]


def exchanged(log: Log) -> Log:
    both = {f"ft.{foot}.{axis}": f"ft.{other}.{axis}" for foot, other in (FEET, FEET[::-1]) for axis in AXES}
    return replace(log, channels=log.channels | {name: log.channels[other] for name, other in both.items()})


def said(robot: Robot, logs: list[Log]) -> list[tuple[str, str, str]]:  # noqa: F811
    return [(log, each.channel, each.rule) for log, each in examine_against_robot(robot, logs)]


@pytest.mark.slow
def test_feet_that_are_exchanged_are_named_and_nothing_else(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    found = said(robot, [exchanged(each) for each in logs])
    assert found == [(each.name, "ft.left", "wrenches_exchanged") for each in logs]


@pytest.mark.slow
def test_feet_that_are_exchanged_are_named_where_they_bear_nearly_alike(robot: Robot) -> None:  # noqa: F811
    """As in bends: what the trunk asks for goes into both feet alike, and is large beside what an exchange changes."""
    logs = [record(seed, 0.0, 0.0, alike=True) for seed in (4, 5)]
    assert said(robot, logs) == []
    found = said(robot, [exchanged(each) for each in logs])
    assert found == [(each.name, "ft.left", "wrenches_exchanged") for each in logs]


def test_the_base_is_looked_at_in_single_logs_with_a_device_too(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    """What a device does to a joint is no reason for a doubt there."""
    pulled = [
        replace(each, channels=each.channels | {"tau.arm": each.channels["tau.arm"] - 9.0 * each.channels["q.arm"]})
        for each in logs
    ]
    assert list(examine_one_by_one(robot, pulled)) == []
    feet = {f"ft.{foot}.{axis}" for foot in FEET for axis in AXES}
    late = {name: np.roll(values, 40) if name in feet else values for name, values in pulled[1].channels.items()}
    slipped = [exchanged(pulled[0]), replace(pulled[1], channels=late)]
    found = [(log, each.channel, each.rule) for log, each in examine_one_by_one(robot, slipped)]
    assert found == [(logs[0].name, "ft.left", "wrenches_exchanged"), (logs[1].name, "ft.*", "wrench_clock")]


def test_feet_as_they_are_raise_no_doubt(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    assert said(robot, logs) == []


@pytest.mark.parametrize("times", [1000.0, 100.0, 1.0 / 9.80665, 0.001])
def test_moments_in_another_unit_are_named_and_nothing_else(robot: Robot, logs: list[Log], times: float) -> None:  # noqa: F811
    """N·mm and N·cm taken for N·m, kgf·m likewise, and N·m for N·mm."""
    names = [f"ft.{foot}.{axis}" for foot in FEET for axis in AXES[3:]]
    wrong = [
        replace(each, channels=each.channels | {name: times * each.channels[name] for name in names}) for each in logs
    ]
    found = list(examine_against_robot(robot, wrong))
    assert [(log, each.channel, each.rule) for log, each in found] == [
        (each.name, "ft.*", "moment_unit") for each in logs
    ]
    for _, each in found:
        assert each.value == pytest.approx(1.0 / times)


@pytest.mark.parametrize(
    ("feet", "read"),
    [(FEET[:1], ("y", "x", "z")), (FEET[1:], ("z", "y", "x")), (FEET[:1], ("-y", "x", "z")),
     (FEET, ("y", "x", "z")), (FEET, ("-x", "-y", "z")), (FEET, ("-y", "x", "z"))],
)  # fmt: skip
def test_a_foots_exchanged_axes_are_named_and_no_joint_for_them(
    robot: Robot,  # noqa: F811
    logs: list[Log],
    feet: tuple[str, ...],
    read: tuple[str, str, str],
) -> None:
    """read: what was written in the columns of x, y and z."""

    def written(log: Log) -> Log:
        columns = {
            f"ft.{foot}.{kind}{axis}": (-1.0 if "-" in source else 1.0) * log.channels[f"ft.{foot}.{kind}{source[-1]}"]
            for foot in feet for kind in "fm" for axis, source in zip("xyz", read, strict=True)
        }  # fmt: skip
        return replace(log, channels=log.channels | columns)

    found = list(examine_against_robot(robot, [written(each) for each in logs]))
    channel = "ft.*" if len(feet) == 2 else f"ft.{feet[0]}"
    assert {(each.channel, each.rule) for _, each in found} == {(channel, "wrench_axes")}
    for _, each in found:  # what undoes it: of each axis the column that it was written in
        for axis, source in zip("xyz", read, strict=True):
            assert f"{source[-1]} := {'-' if '-' in source else ''}{axis}" in each.advice


@pytest.mark.slow
def test_the_axes_of_a_foot_that_bears_little_are_named_too(robot: Robot) -> None:  # noqa: F811
    """What they leave is little of all that the moments change, and all that they themselves change."""
    logs = [record(seed, 0.0, 0.0, aside=True) for seed in (4, 5)]
    assert said(robot, logs) == []
    turned = [
        replace(each, channels=each.channels | {
            f"ft.left.{kind}{axis}": sign * each.channels[f"ft.left.{kind}{source}"]
            for kind in "fm" for axis, source, sign in (("x", "y", 1.0), ("y", "x", -1.0))
        }) for each in logs
    ]  # fmt: skip
    found = list(examine_against_robot(robot, turned))
    assert [(log, each.channel, each.rule) for log, each in found] == [
        (each.name, "ft.left", "wrench_axes") for each in logs
    ]
    assert all("x := -y, y := x, z := z" in each.advice for _, each in found)


def test_feet_that_tell_their_vertical_force_alone_are_no_measure_of_torques(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    rest = {f"ft.{foot}.{axis}": np.zeros(logs[0].samples) for foot in FEET for axis in AXES if axis != "fz"}
    found = list(examine_against_robot(robot, [replace(each, channels=each.channels | rest) for each in logs]))
    told = {(log, each.channel) for log, each in found if each.rule == "wrench_incomplete" and each.severity == "error"}
    assert told == {(each.name, f"ft.{foot}") for each in logs for foot in FEET}


def test_a_foot_in_the_air_throughout_is_none_that_is_half_measured(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    lifted = {f"ft.left.{axis}": np.zeros(logs[0].samples) for axis in AXES}
    found = list(examine_against_robot(robot, [replace(each, channels=each.channels | lifted) for each in logs]))
    assert all(each.rule != "wrench_incomplete" for _, each in found)


@pytest.mark.slow
def test_a_reversed_accelerometer_is_no_reversal_of_both_feet(robot: Robot) -> None:  # noqa: F811
    """Of a body that moves slowly moments do not tell the two apart; the weight does. Feet and joints were blamed."""
    log = record(4, 0.0, 0.0, slower=4.0)
    turned = replace(log, channels={name: -v if name[:3] == "acc" else v for name, v in log.channels.items()})
    assert said(robot, [turned]) == [(log.name, "acc", "acceleration_sign")]


def test_a_leg_with_a_wrong_sign_is_no_exchange(robot: Robot, logs: list[Log]) -> None:  # noqa: F811
    turned = [replace(each, channels=each.channels | {"tau.left_leg": -each.channels["tau.left_leg"]}) for each in logs]
    assert {(channel, rule) for _, channel, rule in said(robot, turned)} == {("tau.left_leg", "effort_reversed")}


@pytest.mark.parametrize(
    ("kinds", "channel", "rule"), [(("ft",), "ft.*", "wrench_clock"), (("acc", "gyro"), "acc", "imu_clock")]
)
@pytest.mark.parametrize("milliseconds", [-150, 120, 300])
def test_feet_or_an_imu_of_another_clock_are_told_with_the_time_and_nothing_else(
    robot: Robot,  # noqa: F811
    logs: list[Log],
    milliseconds: int,
    kinds: tuple[str, ...],
    channel: str,
    rule: str,
) -> None:
    def late(log: Log) -> Log:
        shift = milliseconds // 5  # samples
        read = {name: np.roll(each, shift) if name.startswith(kinds) else each for name, each in log.channels.items()}
        cut = slice(abs(shift), len(log.time) - abs(shift))
        return replace(log, time=log.time[cut], channels={name: each[cut] for name, each in read.items()})

    found = list(examine_against_robot(robot, [late(each) for each in logs]))
    assert [(log, each.channel, each.rule) for log, each in found] == [(each.name, channel, rule) for each in logs]
    for _, each in found:
        assert each.value == pytest.approx(1e-3 * milliseconds, abs=max(0.015, 0.1e-3 * abs(milliseconds)))


@pytest.mark.slow
@pytest.mark.parametrize("alike", [False, True])
def test_feet_that_are_late_show_in_slow_motions_of_bodies_that_are_off(robot: Robot, alike: bool) -> None:  # noqa: F811
    """What a delay leaves there is less than what bodies do that weigh a tenth more than described."""
    log = record(4, 0.0, 0.0, slower=4.0, alike=alike)
    assert list(examine_one_by_one(robot, [log])) == []
    read = {name: np.roll(each, 40) if name.startswith("ft") else each for name, each in log.channels.items()}
    late = replace(log, time=log.time[40:-40], channels={name: each[40:-40] for name, each in read.items()})
    ((_, found),) = examine_one_by_one(robot, [late])
    assert (found.channel, found.rule) == ("ft.*", "wrench_clock")
    assert found.value == pytest.approx(0.2, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("feet", [FEET, FEET[:1]])
def test_moments_that_are_told_about_the_joint_are_named_with_the_place(
    robot: Robot,  # noqa: F811
    logs: list[Log],
    feet: tuple[str, ...],
) -> None:
    """The legs' joints are 0.4 m above the soles: M about the joint is M about the sole, less p × F."""

    def told(log: Log) -> Log:
        columns = dict[str, np.ndarray]()
        for foot in feet:
            columns[f"ft.{foot}.mx"] = log.channels[f"ft.{foot}.mx"] + 0.4 * log.channels[f"ft.{foot}.fy"]
            columns[f"ft.{foot}.my"] = log.channels[f"ft.{foot}.my"] - 0.4 * log.channels[f"ft.{foot}.fx"]
        return replace(log, channels=log.channels | columns)

    wrong = [told(each) for each in logs]
    expected = {(each.name, f"ft.{foot}", "wrench_point") for each in logs for foot in feet}
    for found in (list(examine_against_robot(robot, wrong)), list(examine_one_by_one(robot, wrong))):
        assert {(log, each.channel, each.rule) for log, each in found} == expected
        for _, each in found:
            assert f"the joint {each.channel.removeprefix('ft.')}_leg, [0.000, 0.000, 0.400] m" in each.detail
            assert each.value == pytest.approx(0.4)


@pytest.mark.slow
@pytest.mark.parametrize("slower", [4.0, 16.0])
def test_what_is_noise_of_forces_does_not_say_where_a_foot_measures(robot: Robot, slower: float) -> None:  # noqa: F811
    """About the base it is a moment too, as another point of the foot would give: a point up there fitted best, and
    that the left foot tells its moments about its joint was not said."""
    log, rng = record(4, 0.0, 0.0, slower=slower, alike=True), np.random.default_rng(4)
    forces = {f"ft.{foot}.f{axis}": log.channels[f"ft.{foot}.f{axis}"] for foot in FEET for axis in "xyz"}
    noisy = {name: each + 6.0 * rng.standard_normal(len(each)) for name, each in forces.items()}
    one = replace(log, channels=log.channels | noisy)
    assert list(examine_one_by_one(robot, [one])) == []
    told = {
        "ft.left.mx": one.channels["ft.left.mx"] + 0.4 * noisy["ft.left.fy"],
        "ft.left.my": one.channels["ft.left.my"] - 0.4 * noisy["ft.left.fx"],
    }
    found = [each for _, each in examine_one_by_one(robot, [replace(one, channels=one.channels | told)])]
    assert [(each.channel, each.rule) for each in found] == [("ft.left", "wrench_point")]
