from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.signal import butter, lfilter, sosfiltfilt

from exogauge.logs.doctor import RULES, Expectation, JointLimits, examine
from exogauge.logs.model import Log, Note

REAL = Path(__file__).resolve().parents[3] / "shared" / "data"
RATE, SAMPLES = 200.0, 6000
WEIGHT = 39.0 * 9.81
EXPECTED = Expectation(
    rate_hz=RATE,
    joints={name: JointLimits(-1.5, 1.5, 6.0) for name in ("hip", "knee", "finger")}
    | {"ankle": JointLimits(-1.5, 1.5, 6.0, gear=200.0), "wheel": JointLimits()},
    weight_n=WEIGHT,
    contacts={"l_foot": 1.0, "r_foot": 1.0},
    actuation={"hip": "current", "knee": "current", "ankle": "torque", "finger": "current"},
    noise={"q": 6e-5, "i": 0.05, "tau": 0.05, "acc": 0.05, "gyro": 0.005, "force": 1.0, "moment": 0.1},
)
CLOCK = Expectation(rate_hz=RATE)
Channels = dict[str, np.ndarray]
ENCODER = 2 * np.pi / 2**16


def healthy(rng: np.random.Generator) -> tuple[np.ndarray, Channels]:
    """Thirty seconds of a robot on two feet: three joints swing, a finger rests, the trunk tilts."""
    time = np.arange(SAMPLES) / RATE
    channels: Channels = {}
    for joint, (slow, fast) in {"hip": (0.3, 1.7), "knee": (0.45, 2.6), "ankle": (0.6, 3.4)}.items():
        position = 0.5 * np.sin(2 * np.pi * slow * time) + 0.1 * np.sin(2 * np.pi * fast * time + 0.4)
        channels[f"q.{joint}"] = np.round((position + 2e-5 * rng.standard_normal(SAMPLES)) / ENCODER) * ENCODER
        channels[f"dq.{joint}"] = np.gradient(position, time) + 1e-3 * rng.standard_normal(SAMPLES)
        effort = 8.0 * np.sin(position) + np.tanh(30 * np.gradient(position, time))
        kind = "tau" if joint == "ankle" else "i"
        channels[f"{kind}.{joint}"] = effort + 0.05 * rng.standard_normal(SAMPLES)
    channels["q.finger"] = np.full(SAMPLES, 0.2)
    channels["dq.finger"] = 1e-3 * rng.standard_normal(SAMPLES)
    channels["i.finger"] = 0.01 * rng.standard_normal(SAMPLES)

    pitch, roll = 0.25 * np.sin(2 * np.pi * 0.25 * time), 0.15 * np.sin(2 * np.pi * 0.4 * time + 1.0)
    up = np.column_stack([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
    gyro = np.column_stack([np.gradient(roll, time), np.gradient(pitch, time) * np.cos(roll), 0.05 * np.sin(time)])
    gyro[:, 2] -= np.gradient(pitch, time) * np.sin(roll)
    shake = 0.3 * np.sin(2 * np.pi * 3.0 * time)
    for column, axis in enumerate("xyz"):
        channels[f"acc.{axis}"] = 9.81 * up[:, column] + shake + 0.05 * rng.standard_normal(SAMPLES)
        channels[f"gyro.{axis}"] = gyro[:, column] + 0.005 * rng.standard_normal(SAMPLES)
    share = 0.5 + 0.2 * np.sin(2 * np.pi * 0.4 * time)
    for foot, part in (("l_foot", share), ("r_foot", 1.0 - share)):
        for axis, size in {"fx": 20.0, "fy": 10.0, "mx": 8.0, "my": 12.0, "mz": 2.0}.items():
            wave = size * np.sin(2 * np.pi * 0.7 * time + len(axis))
            channels[f"ft.{foot}.{axis}"] = wave + (0.1 if axis[0] == "m" else 1.0) * rng.standard_normal(SAMPLES)
        channels[f"ft.{foot}.fz"] = WEIGHT * part + rng.standard_normal(SAMPLES)
    return time, channels


def doubts(time: np.ndarray, channels: Channels, expected: Expectation = EXPECTED) -> set[tuple[str, str]]:
    return {(f.rule, f.channel) for f in examine(Log("log", time, channels), expected) if f.severity != "note"}


@pytest.mark.parametrize("seed", range(5))
def test_a_healthy_log_raises_no_doubt(seed):
    assert doubts(*healthy(np.random.default_rng(seed))) == set()


def test_a_joint_that_rests_is_noted_not_blamed():
    time, channels = healthy(np.random.default_rng(0))
    notes = {(f.rule, f.channel) for f in examine(Log("log", time, channels), EXPECTED)}
    assert ("does_not_move", "q.finger") in notes


@pytest.mark.parametrize("step", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("noise", [0.0, 0.005, 0.05])
def test_a_posture_held_at_the_largest_current_is_not_taken_for_clipping(step, noise):
    time = np.arange(SAMPLES) / RATE
    rise = np.clip(time / 10.0, 0.0, 1.0)
    current = 3.0 * rise**2 * (3.0 - 2.0 * rise) + noise * np.random.default_rng(0).standard_normal(SAMPLES)
    held = {"i.knee": np.round(current / step) * step}
    assert "saturated" not in {rule for rule, _ in doubts(time, held, CLOCK)}


@pytest.mark.parametrize("decimals", [6, 7, 12])
def test_steps_of_an_encoder_that_were_rounded_are_no_values_that_are_held(decimals):
    time, step = np.arange(SAMPLES) / RATE, 2 * np.pi / 2**17
    slow = -1.7 + 0.4 * step * RATE * np.sin(2.0 * np.pi * 0.25 * time) / (2.0 * np.pi * 0.25)
    slow += 0.4 * step * np.random.default_rng(0).standard_normal(SAMPLES)
    channels = {"q.knee": np.round(np.round(slow / step) * step, decimals)}
    assert "held" not in {rule for rule, _ in doubts(time, channels, CLOCK)}


def clip(channels: Channels) -> None:
    channels["i.knee"] = np.clip(channels["i.knee"], -3.0, 3.0)


def hum(channels: Channels) -> None:
    channels["tau.ankle"] += 0.4 * np.random.default_rng(1).standard_normal(SAMPLES)


def lose(channels: Channels) -> None:
    del channels["tau.ankle"]


def freeze(channels: Channels) -> None:
    channels["acc.y"][2000:2200] = channels["acc.y"][2000]


def drop(channels: Channels) -> None:
    channels["tau.ankle"][700:703] = np.nan


def unplug(channels: Channels) -> None:
    channels["i.hip"][:] = 0.0


def round_off(channels: Channels) -> None:
    channels["q.knee"] = np.round(channels["q.knee"], 1)
    del channels["dq.knee"]


def in_degrees(channels: Channels) -> None:
    channels["q.hip"] = np.degrees(channels["q.hip"])
    del channels["dq.hip"]


def in_counts(channels: Channels) -> None:
    channels["q.hip"] = np.round(channels["q.hip"] / ENCODER)
    del channels["dq.hip"]


def on_the_motors_side(channels: Channels) -> None:
    channels["q.ankle"] = 200.0 * channels["q.ankle"]
    del channels["dq.ankle"]


def velocity_in_degrees(channels: Channels) -> None:
    channels["dq.ankle"] = np.degrees(channels["dq.ankle"])


def shift_zero(channels: Channels) -> None:
    channels["q.hip"] += 1.2


def milliamperes(channels: Channels) -> None:
    channels["i.hip"] *= 1000.0


def wrong_joint(channels: Channels) -> None:
    channels["dq.hip"] = channels["dq.knee"].copy()


def reverse(channels: Channels) -> None:
    channels["dq.knee"] *= -1.0


def lag(channels: Channels) -> None:
    channels["dq.hip"] = np.roll(channels["dq.hip"], 4)


def filter_causally(channels: Channels) -> None:
    channels["dq.ankle"] = lfilter(*butter(1, 8.0, fs=RATE), channels["dq.ankle"])


def filter_both_ways(channels: Channels) -> None:
    channels["dq.ankle"] = sosfiltfilt(butter(2, 3.0, fs=RATE, output="sos"), channels["dq.ankle"])


def scale(kind: str, factor: float) -> Callable[[Channels], None]:
    def change(channels: Channels) -> None:
        for name in channels:
            if name.startswith(kind):
                channels[name] = channels[name] * factor

    return change


def store_low_passed(channels: Channels) -> None:
    for name in channels:
        if name.startswith(("i.", "tau.")) and np.ptp(channels[name]) > 0.0:
            channels[name] = sosfiltfilt(butter(4, 3.0, fs=RATE, output="sos"), channels[name])


def remove_gravity(channels: Channels) -> None:
    for axis in "xyz":
        channels[f"acc.{axis}"] = channels[f"acc.{axis}"] - sosfiltfilt(
            butter(2, 1.0, fs=RATE, output="sos"), channels[f"acc.{axis}"]
        )


def exchange_gyro(channels: Channels) -> None:
    channels["gyro.x"], channels["gyro.y"] = -channels["gyro.y"], channels["gyro.x"]


def silence_gyro(channels: Channels) -> None:
    for axis in "xyz":
        channels[f"gyro.{axis}"] = 0.005 * np.random.default_rng(ord(axis)).standard_normal(SAMPLES)


def couple_first(channels: Channels) -> None:
    for foot in ("l_foot", "r_foot"):
        force, couple = ([channels[f"ft.{foot}.{kind}{axis}"] for axis in "xyz"] for kind in "fm")
        for kind, columns in (("f", couple), ("m", force)):
            channels.update({f"ft.{foot}.{kind}{axis}": c for axis, c in zip("xyz", columns, strict=True)})


def lying_sensors(channels: Channels) -> None:
    for foot in ("l_foot", "r_foot"):
        up, side = f"ft.{foot}.fz", f"ft.{foot}.fx"
        channels[up], channels[side] = channels[side], channels[up]


def lose_counts(channels: Channels) -> None:
    channels["q.hip"][3000:] += 0.2
    del channels["dq.hip"]


def miss_one(channels: Channels) -> None:
    channels["q.finger"] += 2e-5 * np.random.default_rng(1).standard_normal(SAMPLES)
    channels["q.finger"][1234] = 0.0
    del channels["dq.finger"]


def log_too_often(channels: Channels) -> None:
    channels["tau.ankle"] = channels["tau.ankle"][np.arange(SAMPLES) // 4 * 4]


def read_slowly(channels: Channels) -> None:
    channels["q.knee"] = channels["q.knee"][np.arange(SAMPLES) // 5 * 5]
    del channels["dq.knee"]


def stop_foot(channels: Channels) -> None:
    for axis in ("fx", "fy", "fz", "mx", "my", "mz"):
        channels[f"ft.l_foot.{axis}"][2000:4000] = channels[f"ft.l_foot.{axis}"][2000]


CASES = [
    ("not_finite", "tau.ankle", drop),
    ("dead", "i.hip", unplug),
    ("frozen", "acc.y", freeze),
    ("held", "tau.ankle", log_too_often),
    ("held", "q.knee", read_slowly),
    ("saturated", "i.knee", clip),
    ("coarse", "q.knee", round_off),
    ("noisier_than_declared", "tau.ankle", hum),
    ("stored_low_passed", "i.*", store_low_passed),
    ("joint_missing", "tau.ankle", lose),
    ("degrees", "q.hip", in_degrees),
    ("motor_side", "q.ankle", on_the_motors_side),
    ("counts", "q.hip", in_counts),
    ("position_jumps", "q.hip", lose_counts),
    ("position_jumps", "q.finger", miss_one),
    ("beyond_limits", "q.hip", shift_zero),
    ("current_in_milliamperes", "i.hip", milliamperes),
    ("velocity_unlike", "dq.hip", wrong_joint),
    ("velocity_scaled", "dq.knee", reverse),
    ("velocity_lags", "dq.hip", lag),
    ("velocity_lags", "dq.ankle", filter_causally),
    ("velocity_filtered", "dq.ankle", filter_both_ways),
    ("acceleration_unit", "acc", scale("acc", 1 / 9.81)),
    ("acceleration_scale", "acc", scale("acc", 1.2)),
    ("gravity_missing", "acc", remove_gravity),
    ("gyro_in_degrees", "gyro", scale("gyro", 57.3)),
    ("gyro_sign", "gyro", scale("gyro", -1.0)),
    ("gyro_scale", "gyro", scale("gyro", 2.0)),
    ("gyro_frame", "gyro", exchange_gyro),
    ("gyro_still", "gyro", silence_gyro),
    ("wrench_sign", "ft.*", scale("ft", -1.0)),
    ("wrench_sign", "ft.*", scale("ft.r_foot", -1.0)),
    ("force_unit", "ft.*", scale("ft", 1 / 9.81)),
    ("force_unit", "ft.*", scale("ft", 1e-3)),
    ("couple_first", "ft.*", couple_first),
    ("weight_on_another_axis", "ft.*", lying_sensors),
    ("weight_differs", "ft.*", scale("ft", 1.3)),
    ("weight_missing", "ft.*", scale("ft", 0.05)),
    ("wrench_stands", "ft.l_foot", stop_foot),
]


@pytest.mark.parametrize(("rule", "channel", "corrupt"), CASES, ids=[f"{case[0]}-{case[2].__name__}" for case in CASES])
def test_one_fault_fires_its_own_rule_and_no_other(rule, channel, corrupt):
    time, channels = healthy(np.random.default_rng(7))
    corrupt(channels)
    assert doubts(time, channels) == {(rule, channel)}


@pytest.mark.parametrize(
    ("value", "rests", "severity"), [(None, False, "error"), (0.0, False, "warning"), (None, True, "warning")]
)
def test_a_drive_that_stands_while_its_joint_moves_spoils_its_log(value, rests, severity):
    """Not one that is off and coasts, nor one whose joint rests."""
    time, channels = healthy(np.random.default_rng(7))
    span = slice(2000, 2500)
    channels["tau.ankle"][span] = channels["tau.ankle"][2000] if value is None else value
    if rests:
        channels["q.ankle"][span] = channels["q.ankle"][2000]
    found = [f for f in examine(Log("log", time, channels), EXPECTED) if f.rule == "frozen"]
    assert [(f.channel, f.severity) for f in found] == [("tau.ankle", severity)]


@pytest.mark.parametrize("times", [0.0, 1.0], ids=["nothing", "last"])
@pytest.mark.parametrize("span", [slice(0, 2000), slice(2000, 4000), slice(4000, None)])
def test_a_foot_whose_sensor_stops_while_joints_move_spoils_its_log(times, span):
    time, channels = healthy(np.random.default_rng(7))
    for axis in ("fx", "fy", "fz", "mx", "my", "mz"):
        channels[f"ft.l_foot.{axis}"][span] = times * channels[f"ft.l_foot.{axis}"][span][0]
    (found,) = (f for f in examine(Log("log", time, channels), EXPECTED) if f.severity == "error")
    assert (found.rule, found.channel) == ("wrench_stands", "ft.l_foot")
    first, last = time[span][[0, -1]]
    assert f"{first:.4g} to {last:.4g} s" in found.detail


def test_one_force_that_drops_to_nothing_spoils_its_log():
    time, channels = healthy(np.random.default_rng(7))
    channels["ft.r_foot.fz"][1000:3000] = 0.0
    found = {(f.rule, f.channel) for f in examine(Log("log", time, channels), EXPECTED) if f.severity == "error"}
    assert found == {("wrench_stands", "ft.r_foot.fz")}


def step_aside(channels: Channels, foot: str, steps: list[slice]) -> None:
    """The foot is in the air and reads exactly nothing; the other bears what both did."""
    other = {"l_foot": "r_foot", "r_foot": "l_foot"}[foot]
    for axis in ("fx", "fy", "fz", "mx", "my", "mz"):
        for span in steps:
            channels[f"ft.{other}.{axis}"][span] += channels[f"ft.{foot}.{axis}"][span]
            channels[f"ft.{foot}.{axis}"][span] = 0.0


@pytest.mark.parametrize("steps", [[slice(2000, 4000)], [slice(k, k + 150) for k in range(300, 5700, 300)]])
def test_a_foot_in_the_air_that_reads_nothing_is_not_taken_for_dead(steps):
    time, channels = healthy(np.random.default_rng(7))
    step_aside(channels, "l_foot", steps)
    assert not {f.rule for f in examine(Log("log", time, channels), EXPECTED)} & {"wrench_stands"}


def test_a_foot_that_stands_still_with_all_joints_is_not_taken_for_dead():
    """A simulator without noise: while nothing moves, nothing changes."""
    time, channels = healthy(np.random.default_rng(7))
    for values in channels.values():
        values[2000:4000] = values[2000]
    assert not [f for f in examine(Log("log", time, channels), EXPECTED) if f.severity == "error"]


def swaying(lever: float, hz: float, degrees: float, gyro: float = 1.0) -> Log:
    """The IMU of a base that pitches about a point so far below it."""
    rng, time = np.random.default_rng(3), np.arange(SAMPLES) / RATE
    w = 2.0 * np.pi * hz
    pitch = np.radians(degrees) * np.sin(w * time)
    rate, acceleration = w * np.radians(degrees) * np.cos(w * time), -(w**2) * pitch
    acc = [lever * acceleration - 9.81 * np.sin(pitch), 0.0 * time, 9.81 * np.cos(pitch) - lever * rate**2]
    channels = {
        f"acc.{axis}": each + 0.05 * rng.standard_normal(SAMPLES) for axis, each in zip("xyz", acc, strict=True)
    }
    for axis, each in zip("xyz", (0.0 * time, rate, 0.0 * time), strict=True):
        channels[f"gyro.{axis}"] = gyro * each + 0.002 * rng.standard_normal(SAMPLES)
    return Log("log", time, channels)


@pytest.mark.parametrize("degrees", [3.0, 10.0])
@pytest.mark.parametrize(("lever", "hz"), [(1.0, 0.39), (1.0, 0.8), (1.2, 0.5), (-0.5, 0.5), (-0.4, 0.9)])
def test_a_base_that_accelerates_as_it_turns_about_its_ankles_or_a_hook_has_no_gyro_in_doubt(lever, hz, degrees):
    assert [f.rule for f in examine(swaying(lever, hz, degrees)) if f.channel == "gyro"] == []


@pytest.mark.parametrize(("gyro", "rule"), [(0.5, "gyro_scale"), (2.0, "gyro_scale"), (-1.0, "gyro_sign")])
def test_a_gyro_that_is_off_by_more_than_that_is_told(gyro, rule):
    (found,) = [f for f in examine(swaying(0.3, 0.25, 10.0, gyro)) if f.channel == "gyro"]
    assert found.rule == rule
    if rule == "gyro_scale":  # a log whose clock is wrong looks the same
        assert f"times too {'slow' if gyro > 1.0 else 'fast'}" in found.advice


@pytest.mark.parametrize("gyro", [0.0, 1.0])
@pytest.mark.parametrize(("hz", "degrees"), [(0.2, 6.0), (0.3, 10.0)])
def test_a_gyro_of_noise_alone_is_an_error_where_no_sway_on_a_level_base_moves_gravity_so_far(hz, degrees, gyro):
    found = [(f.severity, f.rule) for f in examine(swaying(0.3, hz, degrees, gyro)) if f.channel == "gyro"]
    assert found == ([("error", "gyro_still")] if gyro == 0.0 else [])


def test_a_base_that_sways_level_is_asked_for_not_blamed():
    """5 cm at 0.5 Hz, and no rotation at all: no gyro tells more than its noise."""
    rng, log = np.random.default_rng(3), swaying(0.0, 0.5, 0.0)
    shifts = 0.05 * (np.pi**2) * np.sin(np.pi * log.time)
    log = replace(log, channels=log.channels | {"acc.x": shifts + 0.05 * rng.standard_normal(SAMPLES)})
    found = [(f.severity, f.rule) for f in examine(log) if f.channel == "gyro"]
    assert found == [("warning", "gyro_still")]


def test_where_degrees_and_the_motors_side_both_stay_within_limits_neither_is_chosen():
    time, channels = healthy(np.random.default_rng(8))
    channels["q.hip"] = 60.0 * channels["q.hip"]
    geared = replace(EXPECTED, joints={"hip": JointLimits(-1.5, 1.5, 6.0, gear=60.0)})
    (finding,) = (f for f in examine(Log("log", time, channels), geared) if f.channel == "q.hip" and f.row)
    assert "degrees or the motor's side of a gear of 60" in finding.detail
    assert "do not tell which" in finding.advice


@pytest.mark.parametrize("values", [lambda q: 3.0 * q, lambda q: 0.0 * q + 90.0], ids=["three-times", "one-number"])
def test_what_is_beyond_its_limits_by_little_or_never_changes_is_not_told_as_degrees(values):
    """Degrees are 57 times radians; and an encoder that stays at one number says nothing of its unit."""
    time, channels = healthy(np.random.default_rng(8))
    channels["q.hip"] = values(channels["q.hip"])
    found = {f.rule: f.severity for f in examine(Log("log", time, channels), EXPECTED) if f.channel == "q.hip"}
    assert "degrees" not in found
    assert found["beyond_limits"] == "warning"


def test_where_no_gear_is_stated_degrees_may_be_the_motors_angle():
    time, channels = healthy(np.random.default_rng(8))
    in_degrees(channels)
    (finding,) = (f for f in examine(Log("log", time, channels), EXPECTED) if f.rule == "degrees")
    assert "`gear_ratio`" in finding.advice


def test_a_velocity_in_degrees_is_told_by_its_scale_and_its_limit():
    time, channels = healthy(np.random.default_rng(7))
    velocity_in_degrees(channels)
    assert doubts(time, channels) == {("velocity_scaled", "dq.ankle"), ("beyond_speed", "dq.ankle")}


def test_the_clock_is_compared_with_what_was_declared():
    time, channels = healthy(np.random.default_rng(8))
    assert doubts(time * 1.05, {"i.hip": channels["i.hip"]}, CLOCK) == {("rate_differs", "t")}
    findings = examine(Log("milliseconds", time * 1000.0, {"i.hip": channels["i.hip"]}), CLOCK)
    assert [(f.severity, f.rule) for f in findings] == [("error", "rate_differs")]


def test_a_clock_with_a_gap_and_one_that_jitters_are_told_apart():
    time, channels = healthy(np.random.default_rng(9))
    torn = time + np.where(np.arange(SAMPLES) > 3000, 0.4, 0.0)
    channels = {"i.hip": channels["i.hip"]}
    found = [f for f in examine(Log("torn", torn, channels), CLOCK) if f.severity != "note"]
    assert [(f.rule, f.row) for f in found] == [("clock_has_gaps", 3001)]
    jittered = time + np.random.default_rng(9).uniform(0, 0.4 / RATE, SAMPLES)
    assert doubts(jittered, channels, CLOCK) == {("clock_jitters", "t")}


def test_a_clock_that_does_not_run_stops_the_examination():
    time, channels = healthy(np.random.default_rng(10))
    channels["i.hip"][:] = np.nan
    time[100] = time[99]
    findings = examine(Log("stuck", time, channels), EXPECTED)
    assert [(f.rule, f.row) for f in findings] == [("time_not_increasing", 101)]
    assert [f.rule for f in examine(Log("empty", np.zeros(0), {}))] == ["too_short"]


@pytest.mark.parametrize("samples", [3, 10, 60, 300])
@pytest.mark.parametrize("content", ["nan", "zero", "constant", "noise", "huge"])
def test_no_log_is_too_odd_to_be_examined(samples, content):
    rng = np.random.default_rng(11)
    names = list(healthy(rng)[1])
    make = {
        "nan": lambda: np.full(samples, np.nan),
        "zero": lambda: np.zeros(samples),
        "constant": lambda: np.full(samples, 3.3),
        "noise": lambda: rng.standard_normal(samples),
        "huge": lambda: 1e60 * rng.standard_normal(samples),
    }[content]
    findings = examine(Log("odd", np.arange(samples) / RATE, {name: make() for name in names}), EXPECTED)
    assert all(finding.rule and finding.detail for finding in findings)


@pytest.mark.slow
def test_every_rule_speaks_in_some_case():
    rng = np.random.default_rng(12)
    silent = {rule.__name__ for rule in RULES}
    for _, _, corrupt in [("", "", velocity_in_degrees), *CASES]:
        time, channels = healthy(rng)
        corrupt(channels)
        bad_clock = 1.05 * np.where(time > 10.0, time + 1.0, time) + 1e-3 * rng.random(SAMPLES)
        cut = Log("cut", time, channels, notes=(Note("cut_at_gaps", "1 gap"),))
        for log in (Log("log", time, channels), Log("bad clock", bad_clock, channels), cut):
            silent -= {rule.__name__ for rule in RULES if rule.__name__ in silent and any(rule(log, EXPECTED))}
    slow = Log("slow", 20.0 * time, channels)
    silent -= {rule.__name__ for rule in RULES if rule.__name__ in silent and any(rule(slow, Expectation()))}
    assert silent == set()


@pytest.mark.skipif(not (REAL / "dfki_double_pendulum").exists(), reason="real logs are not here")
def test_a_real_pendulum_log_shows_its_jittering_clock():
    table = pq.read_table(REAL / "dfki_double_pendulum" / "traj_154220.parquet")
    columns = {"pos_meas": "q", "vel_meas": "dq", "tau_meas": "tau"}
    channels = {
        f"{kind}.joint_{n}": table[f"{column}{n}"].to_numpy() for column, kind in columns.items() for n in (1, 2)
    }
    log = Log("swing", table["time"].to_numpy(), channels)
    assert doubts(log.time, channels, Expectation(rate_hz=500.0)) == {("clock_jitters", "t")}


@pytest.mark.skipif(not (REAL / "icub_walking").exists(), reason="real logs are not here")
def test_a_real_walking_log_shows_a_bad_clock_and_tells_good_velocities_from_bad_ones():
    """Divided by its jittering stamps, the knee's position seems to have another derivative (correlation 0.35)."""
    with h5py.File(REAL / "icub_walking" / "walking.mat") as file:
        time = np.ravel(file["estimatorJointsTime"])
        channels = {f"q.{j}": np.array(file["estimatorJointsPos"][j]) for j in range(26)}
        channels |= {f"dq.{j}": np.array(file["estimatorJointsVel"][j]) for j in range(26)}
        channels |= {f"acc.{axis}": np.array(file["imuAcc"][k]) for k, axis in enumerate("xyz")}
        channels |= {f"gyro.{axis}": np.array(file["imuOmega"][k]) for k, axis in enumerate("xyz")}
        channels |= {f"ft.{foot}.fz": np.ravel(file[f"{foot}ForceZ"]) for foot in ("lf", "rf")}
    expected = Expectation(weight_n=33.08 * 9.81, contacts={"lf": 1.0, "rf": 1.0})
    found = {(f.rule, f.channel) for f in examine(Log("walk", time, channels), expected) if f.severity != "note"}
    assert ("clock_jitters", "t") in found
    doubted = {channel for rule, channel in found if rule.startswith("velocity")}
    assert {"dq.0", "dq.1", "dq.2"} <= doubted  # the neck
    assert not {f"dq.{leg}" for leg in range(14, 26)} & doubted
    assert not {rule for rule, channel in found if channel.startswith(("ft", "acc"))}


def test_steps_smaller_than_the_noise_are_not_coarse():
    rng = np.random.default_rng(3)
    noisy = np.round((0.5 + 0.02 * rng.standard_normal(4000)) / 0.005) * 0.005  # 20 mA of noise in steps of 5 mA
    stepped = np.round(np.sin(np.arange(4000) / 300.0) / 0.05) * 0.05
    log = Log("log", np.arange(4000) / 200.0, {"i.hip": noisy, "i.knee": stepped})
    assert [found.channel for found in examine(log) if found.rule == "coarse"] == ["i.knee"]


@pytest.mark.parametrize(("keep", "told"), [(1, False), (5, False), (20, True)])
def test_a_log_with_few_samples_of_a_turn_says_so(keep, told):
    time, channels = healthy(np.random.default_rng(12))
    some = Log("log", time[::keep], {name: each[::keep] for name, each in channels.items()})
    found = [f for f in examine(some) if f.rule == "slowly_sampled"]
    assert bool(found) is told
    assert not told or "50 Hz" in found[0].advice
