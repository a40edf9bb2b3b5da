"""Each disturbance, read back from the logs by what it has to be there: no formula of the generator is used.

A study with one disturbance and the ideal one of the same seed share every other random number, noise included. What
they differ in is the disturbance.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from scipy.signal import butter, periodogram, sosfiltfilt
from tests.synthetic.balance import balance

from exogauge.synthetic.disturbances import IDEAL, LAB, chosen
from exogauge.synthetic.lab import drawn_lab
from exogauge.synthetic.log_plans import LogPlan, log_plans
from exogauge.synthetic.log_runs import Bench, run_log
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.sensors import ENCODER_STEP
from exogauge.synthetic.simulation import LOG_RATE_HZ, Recording
from exogauge.synthetic.study import write_study
from exogauge.synthetic.suit import BANDS
from exogauge.synthetic.true_robot import draw_robot

pytestmark = pytest.mark.slow

SEED = 3
BY_NAME = {plan.name: plan for plan in log_plans("normal")}
ONE = LogPlan("id_1", "identification", "excitation", 7.0)
SHORT = (ONE, *(replace(BY_NAME[name], duration_s=7.0) for name in ("bend_normal_1", "bend_normal_2")))
RUNS = tuple(BY_NAME[name] for name in ("bend_plain_1", "bend_plain_2"))
ARM = [k for k, name in enumerate(JOINT_NAMES) if "hip" not in name and "knee" not in name and "ankle" not in name]
TEXTS = {  # sha-256 of the ideal sample's files before there were disturbances
    "robot.urdf": "1ca81d1ddc54ed8a",
    "robot.yaml": "72ca35d50c69e3e8",
    "device.yaml": "03dd492a28247ca9",
    "study.yaml": "49bba03c07559f96",
    "README.txt": "b4fded79b7eb7fa7",
}
VALUES = {  # of its logs, in rows 100, 600, 1300
    ("id_1", "t"): (0.5, 3, 6.5),
    ("id_1", "q.torso_pitch"): (-0.0001121723, 0.2672405, 0.001714224),
    ("id_1", "i.torso_pitch"): (0.1, -2.625, -1.57),
    ("id_1", "acc.x"): (0.478, 0.99, 0.51),
    ("id_1", "gyro.y"): (-0.0028, -0.0056, 0.001),
    ("id_1", "ft.l_foot.fz"): (180.45, 215.15, 179.95),
    ("id_1", "ft.r_foot.my"): (-3.968, -6.21, -4.5),
    ("bend_normal_1", "t"): (0.5, 3, 6.5),
    ("bend_normal_1", "q.torso_pitch"): (0.001619788, 0.5205842, 0.001599175),
    ("bend_normal_1", "i.torso_pitch"): (-1.445, -2.37, -1.42),
    ("bend_normal_1", "acc.x"): (0.458, -0.504, 0.44),
    ("bend_normal_1", "gyro.y"): (0.003, 0.003, -0.0078),
    ("bend_normal_1", "ft.l_foot.fz"): (180.8, 179.15, 179.2),
    ("bend_normal_1", "ft.r_foot.my"): (-3.974, -3.654, -4.166),
}

Make = Callable[..., Path]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """(words of `--with`, plans) -> the folder of that study, made once. A log is the same whatever else is recorded: a
    test that looks at one asks for that alone, and finds it among those of `make()`."""

    @cache
    def made(*words: str, plans: tuple[LogPlan, ...] = SHORT) -> Path:
        out = tmp_path_factory.mktemp("lab")
        write_study(out, SEED, suit="normal", logs=plans, disturbed=chosen("ideal", words))
        return out

    return made


def _table(folder: Path, log: str, *kinds: str) -> np.ndarray:
    """(T, C) of the columns that begin so, in their order."""
    table = pq.read_table(folder / f"logs/{log}.parquet")
    columns = [name for name in table.column_names if name.startswith(kinds)]
    return np.column_stack([table[name].to_numpy() for name in columns]).astype(float)


def load_yaml(path: Path) -> dict:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def _truth(folder: Path) -> dict:
    return json.loads((folder / "truth.json").read_text(encoding="utf-8"))


def _wrench(folder: Path, log: str) -> np.ndarray:
    return _table(folder, log, "ft.").reshape(-1, 2, 6)


def test_the_ideal_sample_is_what_it_was_before_there_were_disturbances(tmp_path: Path) -> None:
    """Texts byte for byte. Logs to what their noise is, torques to half of it: another build of MuJoCo, or another
    processor, rounds in another way, and feet that stand share what is left over as their contacts were solved."""
    plans = (ONE, SHORT[1])
    write_study(tmp_path, SEED, suit="normal", logs=plans, disturbed=IDEAL)
    for file, expected in TEXTS.items():
        text = (tmp_path / file).read_text(encoding="utf-8").replace("uncertainty: none\n", "")
        text = text.partition("soles:\n")[0] if file == "robot.yaml" else text  # said since then, as are shapes
        text = re.sub(r" *<collision.*?</collision>\n", "", text, flags=re.DOTALL)
        text = re.sub(r",? *started: [0-9.]+", "", text)
        text = text.replace("The torque that the suit really gave in each log is in truth/.\n", "")
        assert hashlib.sha256(text.encode()).hexdigest()[:16] == expected, file
    loose = {"t": 1e-9, "q": 1e-5, "i": 0.011, "acc": 0.007, "gyro": 7e-4, "ft": 0.5}
    for (log, column), values in VALUES.items():
        found = _table(tmp_path, log, column)[[100, 600, 1300], 0]
        np.testing.assert_allclose(found, values, atol=loose[column.partition(".")[0]], err_msg=f"{log} {column}")
    assert not {"disturbances", "session", "tolerances"} & set(_truth(tmp_path))


def test_all_left_out_is_ideal_byte_for_byte(tmp_path: Path, make: Make) -> None:
    write_study(tmp_path, SEED, suit="normal", logs=SHORT, disturbed=chosen("lab", left_out=list(LAB)))
    for path in sorted(make().rglob("*.*")):
        assert (tmp_path / path.relative_to(make())).read_bytes() == path.read_bytes(), path.name


ROWS = round((RUNS[0].duration_s - 0.1) * LOG_RATE_HZ)  # that all runs have, whenever their logs begin


def _ideal(make: Make, name: str) -> np.ndarray:
    return _table(make(plans=RUNS), name, "q.")[:ROWS]


def _departures(make: Make, word: str) -> list[np.ndarray]:
    """(ROWS, J) [rad] of each run from the ideal run of the same log: starts, arrivals and noise cancel."""
    return [_table(make(word, plans=RUNS), p.name, "q.")[:ROWS] - _ideal(make, p.name) for p in RUNS]


def test_runs_differ_by_what_is_stated_smoothly(make: Make) -> None:
    """10 mrad, as friction holds the lightest joints within 3 mrad of what they are asked for."""
    first, second = _departures(make, "runs_differ=10mrad")
    for departure in (first, second):  # two that are independent differ by sqrt 2 of it
        assert np.sqrt(np.mean(departure[:, ARM] ** 2)) == pytest.approx(0.01 / np.sqrt(2.0), rel=0.15)
    apart = (first - second)[:, ARM]
    assert np.sqrt(np.mean(apart**2)) == pytest.approx(0.01, rel=0.15)
    frequency, power = periodogram(apart, LOG_RATE_HZ, axis=0, window="hann")
    assert power[frequency > 0.6].sum() < 0.02 * power.sum()
    legs = [k for k in range(len(JOINT_NAMES)) if k not in ARM]
    assert 3e-3 < np.sqrt(np.mean((first - second)[:, legs] ** 2)) < 0.03, "the legs follow, the feet stay"


def test_runs_differ_by_a_constant(make: Make) -> None:
    first, second = _departures(make, "runs_offset=3mrad")
    apart = (first - second)[:, ARM]
    assert np.sqrt(np.mean(apart.mean(axis=0) ** 2)) == pytest.approx(3e-3, rel=0.5)
    assert np.mean(apart.std(axis=0)) < 2e-4


def test_the_simulated_robot_stands_and_moves_as_such_a_run_does(make: Make) -> None:
    """The feet carry the same weight, and what the plan does differently the joints do within tracking."""
    moved, ideal = (_wrench(make(*words, plans=RUNS), "bend_plain_1") for words in (("runs_differ=3mrad",), ()))
    assert moved[:, :, 2].sum(axis=1).mean() == pytest.approx(ideal[:, :, 2].sum(axis=1).mean(), abs=0.2)
    assert np.abs(moved[:, 0, 2] - ideal[:, 0, 2]).max() > 3.0, "but not on the same foot"


def test_a_run_is_larger_or_smaller_by_what_the_truth_says(make: Make) -> None:
    logs, pitch = _truth(make("runs_amplitude=3%", plans=RUNS))["session"]["logs"], JOINT_NAMES.index("torso_pitch")
    for plan, departure in zip(RUNS, _departures(make, "runs_amplitude=3%"), strict=True):
        ideal = _ideal(make, plan.name)[:, pitch]
        slope = ideal @ departure[:, pitch] / (ideal @ ideal)
        assert slope == pytest.approx(logs[plan.name]["amplitude"] - 1.0, abs=5e-4)
    assert {plan["amplitude"] for plan in logs.values()} != {1.0}


def test_a_run_is_early_and_late(make: Make) -> None:
    pitch = JOINT_NAMES.index("torso_pitch")
    late = []
    for plan, departure in zip(RUNS, _departures(make, "runs_timing=20ms"), strict=True):
        speed = np.gradient(_ideal(make, plan.name)[:, pitch], 1 / LOG_RATE_HZ)
        moving = np.abs(speed) > 0.2
        late.append(-departure[moving, pitch] / speed[moving])
        changes = np.abs(np.diff(-departure[:, pitch] / np.where(moving, speed, np.nan)))
        assert np.nanmax(changes) < 0.002, "smoothly, from one sample to the next"
    assert np.sqrt(np.mean(np.concatenate(late) ** 2)) == pytest.approx(0.02, rel=0.4)


def test_angles_are_counted_in_the_steps_asked_for_and_as_noisy_as_told(make: Make) -> None:
    folder = make("encoder_steps=3.8urad", plans=(ONE,))
    counts = _table(folder, "id_1", "q.") / 3.8e-6
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    told = yaml.safe_load((folder / "robot.yaml").read_text(encoding="utf-8"))["noise"]["q"]
    fast = sosfiltfilt(butter(6, 50.0, "highpass", fs=LOG_RATE_HZ, output="sos"), counts * 3.8e-6, 0)
    assert 0.3 * told < np.sqrt(2.0 * np.mean(fast**2)) < 3.0 * told


def _run(words: list[str], plan: LogPlan, after: tuple[LogPlan, ...] = ()) -> tuple[Bench, Recording]:
    """The last of several logs, as it is before any sensor; the robot without a suit."""
    robot = draw_robot(np.random.default_rng(11))
    bench = Bench(SEED, robot, {}, drawn_lab(SEED, chosen("ideal", words), (*after, plan)))
    return bench, run_log(bench, plan, np.random.default_rng(1))


def test_a_warm_motor_gives_less_torque_per_ampere_and_warm_grease_resists_less() -> None:
    """k_T and k_d of the last log, by least squares on what another dynamics library says of its motion."""
    last = LogPlan("val_1", "validation", "excitation", 12.0)
    before = tuple(replace(ONE, name=f"id_{n}", duration_s=600.0) for n in range(2))
    bench, recording = _run(["kt_warming=4%", "friction_warming=20%"], last, before)
    rows, _, asked = balance(recording, bench.robot)
    record = bench.lab.record((*before, last), {})
    share = {kind: record["disturbances"][kind]["share"] for kind in ("kt_warming", "friction_warming")}
    warmer = np.mean(record["session"]["logs"]["val_1"]["warmer"])
    assert 0.3 < warmer < 0.7
    for name in ("torso_pitch", "torso_yaw", "l_shoulder_roll", "r_knee_pitch"):
        j, truth = JOINT_NAMES.index(name), bench.robot.joints[name]
        dq, ddq = recording.dq[rows, j], recording.ddq[rows, j]
        left = asked[:, j] + recording.friction[rows, j] + truth.J_r * ddq - truth.tau_o
        columns = np.column_stack([recording.current[rows, j], -(dq + ddq * 5e-4)])
        (k_T, k_d), *_ = np.linalg.lstsq(columns, left, rcond=None)
        assert k_T / truth.k_T - 1.0 == pytest.approx(-share["kt_warming"][name] * warmer, abs=3e-4), name
        assert k_d / truth.k_d - 1.0 == pytest.approx(-share["friction_warming"][name] * warmer, abs=5e-3), name
        sliding = np.abs(dq) > 0.05
        tau_c = np.median(np.abs(recording.friction[rows, j][sliding]))
        assert tau_c / truth.tau_c - 1.0 == pytest.approx(-share["friction_warming"][name] * warmer / 2, abs=2e-3)
        assert 0.02 <= share["kt_warming"][name] <= 0.06


def test_parameters_are_those_of_the_identification_logs_on_the_average() -> None:
    plans = (ONE, replace(ONE, name="id_2"), *RUNS)
    logs = drawn_lab(SEED, LAB, plans).record(plans, {})["session"]["logs"]
    assert np.mean([logs[name]["warmer"] for name in ("id_1", "id_2")]) == pytest.approx(0.0, abs=1e-3)
    starts = [entry["start_s"] for entry in logs.values()]
    warmth = [value for entry in logs.values() for value in entry["warmer"]]
    assert starts == sorted(starts)
    assert warmth == sorted(warmth)


def test_friction_grows_with_the_torque_passed_on() -> None:
    bench, recording = _run(["load_friction=5%"], replace(ONE, duration_s=12.0))
    rows, _, asked = balance(recording, bench.robot)
    shares = bench.lab.record((ONE,), {})["disturbances"]["load_friction"]["share"]
    assert all(0.03 <= share <= 0.07 for share in shares.values())
    for name in ("torso_pitch", "l_shoulder_roll", "r_knee_pitch"):
        j = JOINT_NAMES.index(name)
        sliding = np.abs(recording.dq[rows, j]) > 0.05
        friction, load = np.abs(recording.friction[rows, j])[sliding], np.abs(asked[:, j])[sliding]
        slope, least = np.polyfit(load, friction, 1)
        assert slope == pytest.approx(shares[name], abs=4e-3), name
        assert least == pytest.approx(bench.robot.joints[name].tau_c, rel=0.01)


def _weight(truth: dict) -> float:
    return 9.81 * sum(value for name, value in truth["parameters"].items() if name.startswith("m["))


def test_standing_both_feet_read_so_much_more_than_the_weight(make: Make) -> None:
    for folder, expected in ((make(), 1.0), (make("feet_gain=3%", plans=SHORT[1:2]), 1.03)):
        still = _wrench(folder, "bend_normal_1")[:100, :, 2].sum(axis=1).mean()
        assert still / _weight(_truth(folder)) == pytest.approx(expected, abs=2e-3)


def test_each_foot_has_a_gain_of_its_own_and_one_in_common(make: Make) -> None:
    folder = make("foot_gains=2%", plans=(ONE,))
    gain = _truth(folder)["disturbances"]["foot_gains"]["gain"]
    ratio = _wrench(folder, "id_1")[:, :, 2].mean(axis=0) / _wrench(make(), "id_1")[:, :, 2].mean(axis=0)
    np.testing.assert_allclose(ratio, [gain[foot] for foot in FEET], atol=1e-4)
    drawn = np.array([drawn_lab(seed, {"foot_gains": 0.02}, ()).gain - 1.0 for seed in range(200)])
    assert drawn.std() == pytest.approx(0.02, rel=0.15)
    assert np.corrcoef(drawn.T)[0, 1] == pytest.approx(0.64, abs=0.12)


def test_zeros_drift_on_through_the_session(make: Make) -> None:
    folder = make("feet_drift=5N")
    truth = _truth(folder)
    end = np.array([truth["disturbances"]["feet_drift"]["zero_at_end"][foot] for foot in FEET])
    for name, entry in truth["session"]["logs"].items():
        zero = (_wrench(folder, name) - _wrench(make(), name)).mean(axis=0)
        middle = (entry["start_s"] + 3.5) / truth["session"]["end_s"]
        np.testing.assert_allclose(zero[:, :3], (middle * end)[:, :3], atol=0.03)
        np.testing.assert_allclose(zero[:, 3:], (middle * end)[:, 3:], atol=0.002)
    assert np.all((np.abs(end[:, :3]) >= 2.5) & (np.abs(end[:, :3]) <= 5.0))
    assert np.all((np.abs(end[:, 3:]) >= 0.5) & (np.abs(end[:, 3:]) <= 1.0))


def test_a_tilted_foot_sensor_sees_weight_from_the_side(make: Make) -> None:
    folder = make("feet_tilt=1deg", plans=(ONE,))
    tilt = np.array([_truth(folder)["disturbances"]["feet_tilt"]["rotation_vector"][foot] for foot in FEET])
    told, true = (_wrench(each, "id_1")[:100].mean(axis=0) for each in (folder, make()))
    seen = (told - true)[:, :2] / true[:, 2:3]
    np.testing.assert_allclose(seen, np.column_stack([tilt[:, 1], -tilt[:, 0]]), atol=2e-3)


def test_gravity_comes_from_half_a_degree_beside_in_the_imu(make: Make) -> None:
    folder = make("imu_mounting=0.5deg", plans=(ONE,))
    told, true = (_table(each, "id_1", "acc.")[:100].mean(axis=0) for each in (folder, make()))
    angle = np.arccos(told @ true / np.linalg.norm(told) / np.linalg.norm(true))
    assert np.rad2deg(angle) == pytest.approx(0.5, abs=0.01)
    turned, rate = (_table(each, "id_1", "gyro.") for each in (folder, make()))
    assert np.abs(np.linalg.norm(turned, axis=1) - np.linalg.norm(rate, axis=1)).max() < 1e-3


def test_via_points_are_stated_as_a_tape_measure_tells_them(tmp_path: Path, make: Make) -> None:
    errors = []
    for seed in range(4):
        write_study(tmp_path / str(seed), seed, logs=(), disturbed=chosen("ideal", ["via_points=5mm"]))
        files = [
            yaml.safe_load((tmp_path / str(seed) / f).read_text()) for f in ("device.yaml", "device_modified.yaml")
        ]
        stated = [[p["xyz"] for band in file["bands"] for p in band["via_points"]] for file in files]
        assert stated[0] == stated[1], "the same suit, measured once"
        errors.append(np.array(stated[0]) - [p.xyz for band in BANDS for p in band.via_points])
        truth = _truth(tmp_path / str(seed))
        told = truth["disturbances"]["via_points"]["true"]
        assert [p["xyz"] for b in BANDS for p in told[b.name]] == [list(p.xyz) for b in BANDS for p in b.via_points]
        for band in files[0]["bands"]:
            assert band["natural_length_m"] == truth["bands"][band["name"]]["natural_length_m"]
    assert np.std(errors) == pytest.approx(5e-3, rel=0.1)
    assert abs(np.mean(errors)) < 1e-3
    log = "logs/bend_normal_1.parquet"
    assert (make("via_points=5mm", plans=SHORT[1:2]) / log).read_bytes() == (make() / log).read_bytes(), (
        "only the file is wrong"
    )


def test_the_suit_is_put_on_anew_for_every_log(make: Make) -> None:
    logs = _truth(make("donning=3mm"))["session"]["logs"]
    first, second = (logs[f"bend_normal_{n}"]["bands"] for n in (1, 2))
    assert first != second
    assert "bands" not in logs["id_1"]
    nominal = _truth(make())["bands"]
    preload = [
        entry["natural_length_m"] - nominal[band]["natural_length_m"]
        for worn in (first, second)
        for band, entry in worn.items()
    ]
    ends = [
        np.array(p["xyz"]) - band.via_points[place].xyz
        for worn in (first, second)
        for band in BANDS
        for place, p in zip((0, -1), worn[band.name]["ends"], strict=True)
    ]
    assert np.std(ends) == pytest.approx(3e-3, rel=0.4)
    assert 0.5e-3 < np.std(preload) < 4e-3
    current = [_table(make(*words), "bend_normal_1", "i.torso_pitch") for words in (("donning=3mm",), ())]
    assert 0.002 < np.abs(current[0] - current[1]).mean() < 0.2, "it pulls otherwise, and not much"


def test_stamps_jitter_about_an_even_clock(make: Make) -> None:
    folder = make("clock_jitter=50us", plans=(ONE,))
    t = _table(folder, "id_1", "t")[:, 0]
    assert np.diff(t).min() > 0.0
    assert np.std(t - np.arange(len(t)) / LOG_RATE_HZ) == pytest.approx(50e-6, rel=0.08)
    q = [_table(each, "id_1", "q.") for each in (folder, make())]
    np.testing.assert_array_equal(*q)


def test_one_disturbance_leaves_the_others_random_numbers_alone() -> None:
    plans = (ONE,)
    whole, alone = drawn_lab(SEED, LAB, plans), drawn_lab(SEED, {"feet_drift": LAB["feet_drift"]}, plans)
    np.testing.assert_array_equal(whole.drift, alone.drift)
    assert whole.gain.std() > 0.0
    assert alone.gain.tolist() == [1.0, 1.0]


def test_the_truth_tells_every_disturbance_with_its_numbers(tmp_path: Path) -> None:
    every = chosen("lab", ["runs_offset", "load_friction", "feet_gain"])
    write_study(tmp_path, SEED, suit="normal", logs=SHORT, disturbed=every)
    truth, study = _truth(tmp_path), yaml.safe_load((tmp_path / "study.yaml").read_text(encoding="utf-8"))
    assert {name: entry["size"] for name, entry in truth["disturbances"].items()} == every
    drawn = {name for name, entry in truth["disturbances"].items() if set(entry) - {"size", "unit"}}
    of_a_log = {"runs_differ", "runs_offset", "runs_amplitude", "runs_timing", "encoder_steps", "donning"}
    assert drawn == set(every) - of_a_log - {"clock_jitter"}
    assert set(truth["session"]["logs"]) == {Path(entry["file"]).stem for entry in study["logs"]}
    assert truth["tolerances"]
    robot, device = (load_yaml(tmp_path / f"{name}.yaml")["uncertainty"] for name in ("robot", "device"))
    assert robot["imu_tilt"] == pytest.approx(np.deg2rad(0.5) / np.sqrt(2.0), rel=0.01)
    assert robot["ft_gain"] == pytest.approx(0.012)
    assert device["via_points"] == 0.005
    assert robot["viscous_drift"] == pytest.approx(2.0 * robot["coulomb_drift"], rel=0.05)  # of two digits
    assert robot.pop("zeros_taken") == "session"
    assert all(value > 0.0 for value in (*robot.values(), *device.values()))
    assert "laboratory" in study["name"]


def test_a_foot_sensor_beside_its_frame_has_its_moments_about_there(make: Make) -> None:
    folder = make("feet_place=20mm", plans=(ONE,))
    places = _truth(folder)["disturbances"]["feet_place"]["beside_m"]
    told, true = (_wrench(each, "id_1") for each in (folder, make()))
    np.testing.assert_allclose(told[..., :3], true[..., :3], atol=1e-3)
    for f, foot in enumerate(FEET):
        expected = -np.cross(places[foot], true[:, f, :3])
        assert np.abs(expected).max() > 1.0
        np.testing.assert_allclose((told - true)[:, f, 3:], expected, atol=0.1)  # forces are noisy, by a lever of 20 mm


def test_encoders_count_from_zeros_of_their_own(make: Make) -> None:
    folder = make("encoder_zeros=2mrad", plans=(ONE,))
    zeros = list(_truth(folder)["disturbances"]["encoder_zeros"]["zero"].values())
    told, true = (_table(each, "id_1", "q.") for each in (folder, make()))
    assert 1e-3 < np.std(zeros) < 3e-3
    np.testing.assert_allclose(told - true, np.broadcast_to(zeros, told.shape), atol=2 * ENCODER_STEP)


def test_streams_are_late_by_what_the_truth_says(make: Make) -> None:
    """Ten samples and more, so that the shift is seen at a glance."""
    folder = make("streams_late=50ms", plans=(ONE,))
    late = _truth(folder)["disturbances"]["streams_late"]["late_s"]
    told, true, t = (
        _table(folder, "id_1", "gyro."),
        _table(make(), "id_1", "gyro."),
        _table(folder, "id_1", "t")[:, 0],
    )
    np.testing.assert_array_equal(_table(folder, "id_1", "q."), _table(make(), "id_1", "q."))
    shifts = np.linspace(-0.2, 0.2, 81)
    misses = [np.sum((told - np.column_stack([np.interp(t - shift, t, c) for c in true.T])) ** 2) for shift in shifts]
    assert shifts[int(np.argmin(misses))] == pytest.approx(late["imu"], abs=0.011)
