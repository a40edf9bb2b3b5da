from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from scipy.signal import butter, sosfiltfilt

from exogauge.errors import BadInput
from exogauge.synthetic import sensors, write_sample
from exogauge.synthetic.log_plans import LogPlan, log_plans
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.simulation import LOG_RATE_HZ
from exogauge.synthetic.study import write_study

pytestmark = pytest.mark.slow

ONE_SHORT_LOG = (LogPlan("id_1", "identification", "excitation", 7.0),)
BENDS = tuple(
    replace(plan, duration_s=7.0)
    for plan in log_plans("both")
    if plan.name in ("bend_plain_1", "bend_plain_2", "bend_normal_1", "bend_modified_1")
)


@pytest.fixture(scope="module")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study with both suits, of short bends only."""
    out = tmp_path_factory.mktemp("suits")
    write_study(out, 3, logs=BENDS)
    return out


def test_a_sample_is_a_whole_study_that_says_it_is_synthetic(folder: Path) -> None:
    study = yaml.safe_load((folder / "study.yaml").read_text(encoding="utf-8"))
    robot = yaml.safe_load((folder / study["robot"]).read_text(encoding="utf-8"))
    assert "SYNTHETIC" in study["name"]
    assert "SYNTHETIC" in (folder / "README.txt").read_text(encoding="utf-8")
    assert (folder / robot["urdf"]).is_file()
    for entry in study["logs"]:
        assert b"SYNTHETIC" in pq.read_schema(folder / entry["file"]).metadata[b"exogauge"]


def test_logs_hold_the_columns_of_the_contract(folder: Path) -> None:
    expected = ["t", *(f"q.{name}" for name in JOINT_NAMES), *(f"i.{name}" for name in JOINT_NAMES)]
    expected += [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    expected += [f"ft.{foot}.{part}" for foot in FEET for part in ("fx", "fy", "fz", "mx", "my", "mz")]
    table = pq.read_table(folder / "logs/id_1.parquet")
    assert table.column_names == expected
    assert table.num_rows == 12 * 200
    np.testing.assert_allclose(np.diff(table["t"].to_numpy()), 0.005, atol=1e-12)


def test_angles_are_counted_in_encoder_steps(folder: Path) -> None:
    angle = pq.read_table(folder / "logs/id_1.parquet")["q.torso_pitch"].to_numpy()
    counts = angle / sensors.ENCODER_STEP
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)


@pytest.mark.parametrize("kind", ["i", "acc", "gyro", "force", "moment"])
def test_sensors_are_as_noisy_as_the_robot_file_says(kind: str) -> None:
    error = sensors.noisy(np.full(100_000, 0.3), kind, np.random.default_rng(0)) - 0.3
    assert error.std() == pytest.approx(sensors.NOISE[kind], rel=0.03)


def test_positions_are_as_noisy_as_the_robot_file_says(run) -> None:
    """Above 50 Hz, a quarter of the rate, no plan moves a joint: white noise would have half of its power there."""
    fast = sosfiltfilt(butter(6, 50.0, "highpass", fs=LOG_RATE_HZ, output="sos"), sensors.encoder(run.recording.q), 0)
    robust = np.median(np.abs(fast[200:-200]), axis=0) / 0.6745 / np.sqrt(0.5)
    assert np.sqrt(np.mean(robust**2)) == pytest.approx(sensors.NOISE["q"], rel=0.25)
    assert (sensors.encoder(run.recording.q) - run.recording.q).std() < sensors.NOISE["q"], "not the encoder alone"


def test_truth_names_every_body_and_joint(folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert set(truth) >= {"parameters", "joints", "bands", "effects"}
    assert len(truth["parameters"]) == 35 * 10 + 34 * 6
    assert truth["parameters"]["k_T[torso_pitch]"] == truth["joints"]["torso_pitch"]["k_T"]
    assert all(joint["tau_s"] >= joint["tau_c"] for joint in truth["joints"].values())


def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(tmp_path: Path) -> None:
    for name, seed in (("a", 4), ("b", 4), ("c", 5)):
        write_study(tmp_path / name, seed, logs=ONE_SHORT_LOG)
    files = ["robot.yaml", "robot.urdf", "study.yaml", "device.yaml", "truth.json", "logs/id_1.parquet"]
    a, b, c = ([(tmp_path / name / file).read_bytes() for file in files] for name in "abc")
    assert a == b
    assert a[:2] == c[:2], "what is told of the robot a priori does not depend on the seed"
    for mine, other in zip(a[2:], c[2:], strict=True):
        assert mine != other


@pytest.mark.slow
def test_two_processes_write_the_same_bytes_as_one(tmp_path: Path, complete: Path) -> None:
    shares: list[float] = []
    write_study(tmp_path, 3, logs=BENDS, progress=lambda share, what: shares.append(share), processes=2)
    for file in ("study.yaml", "truth.json", "device.yaml", *(f"logs/{plan.name}.parquet" for plan in BENDS)):
        assert (tmp_path / file).read_bytes() == (complete / file).read_bytes(), file
    assert len(shares) > len(BENDS)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_every_log_names_the_device_that_it_was_made_with(complete: Path) -> None:
    study = yaml.safe_load((complete / "study.yaml").read_text(encoding="utf-8"))
    truth = json.loads((complete / "truth.json").read_text(encoding="utf-8"))
    by_name = {Path(entry["file"]).stem: entry for entry in study["logs"]}
    assert {entry["motion"] for entry in study["logs"]} == {"bend"}
    assert by_name["bend_plain_1"]["role"] == "without_device"
    assert by_name["bend_normal_1"]["role"] == by_name["bend_modified_1"]["role"] == "with_device"
    assert study["device"] == "device.yaml"
    assert {name: entry.get("device") for name, entry in by_name.items() if "device" in entry} == {
        "bend_modified_1": "device_modified.yaml"
    }
    for file, times in (("device.yaml", 1.0), ("device_modified.yaml", 2.0)):
        device = yaml.safe_load((complete / file).read_text(encoding="utf-8"))
        told = {
            band["name"]: {key: band[key] for key in ("stiffness_n_per_m", "natural_length_m")}
            for band in device["bands"]
        }
        assert truth["devices"][device["name"]] == told
        assert {b["stiffness_n_per_m"] for b in device["bands"] if b["group"] == "A"} == {197.8 * times}
        assert {b["name"] for b in device["bands"] if b.get("ground_truth")} == {"A_left", "A_right"}
        if times == 1.0:
            assert truth["bands"] == told


def test_repetitions_share_the_motion_and_nothing_else(complete: Path) -> None:
    """Another beginning of the log, another arrival, other noise; the same motion once they are aligned."""
    first, second = (pq.read_table(complete / f"logs/bend_plain_{n}.parquet") for n in (1, 2))
    t, early, late = first["t"].to_numpy(), first["q.torso_pitch"].to_numpy(), second["q.torso_pitch"].to_numpy()
    inner, shifts = (t > 0.2) & (t < 6.5), np.arange(-0.08, 0.0801, 0.001)
    gap = [np.abs(np.interp(t[inner] + s, second["t"].to_numpy(), late) - early[inner]).max() for s in shifts]
    assert min(gap) < 2e-4
    assert gap[len(shifts) // 2] > 10 * min(gap), "they need aligning"
    assert not np.array_equal(first["gyro.x"].to_numpy()[:1000], second["gyro.x"].to_numpy()[:1000])


def test_a_complete_study_repeats_each_motion_five_times_in_each_suit_and_twice_more_without_at_the_end() -> None:
    plans = [plan for plan in log_plans("both") if plan.repeats]
    counts = {}
    for plan in plans:
        counts[plan.motion, plan.suit] = counts.get((plan.motion, plan.suit), 0) + 1
    times = {None: 7, "normal": 5, "modified": 5}
    assert counts == {(motion, suit): n for motion in ("bend", "twist") for suit, n in times.items()}
    assert [plan.suit for plan in plans[-4:]] == [None] * 4
    assert len({plan.name for plan in log_plans("both")}) == len(log_plans("both"))


@pytest.mark.parametrize(
    ("suit", "hidden", "effects"),
    [
        ("both", None, ["stribeck"]),
        ("both", ["none"], []),
        ("both", ["payload@head"], ["payload"]),
        ("none", None, []),
    ],
)
def test_what_is_hidden_by_default_depends_on_the_suit(
    tmp_path: Path, suit: str, hidden: list[str] | None, effects: list[str]
) -> None:
    write_study(tmp_path, 3, hidden, suit, logs=())
    truth = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    assert [effect["effect"] for effect in truth["effects"]] == effects


def test_hiding_an_effect_changes_nothing_else_of_the_robot(tmp_path: Path, folder: Path) -> None:
    write_study(tmp_path, 3, hidden=["stribeck@torso_pitch"], suit="none", logs=())
    hidden = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    plain = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert hidden["parameters"] == plain["parameters"]
    assert [(e["effect"], e["where"]) for e in hidden["effects"]] == [("stribeck", {"joint": "torso_pitch"})]


def test_progress_only_rises_and_ends_at_one(tmp_path: Path) -> None:
    shares: list[float] = []
    write_study(tmp_path, 0, suit="none", logs=ONE_SHORT_LOG, progress=lambda share, what: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"seed": 1, "suit": "heavy"}, "unknown_suit"),
        ({"seed": 1, "hidden": ["none", "stribeck@torso_pitch"]}, "hidden_contradicts"),
        ({"seed": -1}, "seed_negative"),
        ({"seed": 1, "hidden": ["gremlin@head"]}, "unknown_effect"),
    ],
)
def test_what_cannot_be_made_is_refused_before_anything_is_written(tmp_path: Path, arguments, rule: str) -> None:
    with pytest.raises(BadInput) as caught:
        write_sample(tmp_path / "out", **arguments)
    assert caught.value.faults[0].rule == rule
    assert not (tmp_path / "out").exists()
