"""From payload.yaml to results.json, and what is refused on the way."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from tests.payload import foreign
from tests.payload.conftest import GRAVITY, STD, generator
from tests.payload.told import still

from exogauge.cli import main
from exogauge.criteria.criteria import Criteria
from exogauge.errors import BadStudy, NotIdentifiable
from exogauge.payload.compute import identify
from exogauge.payload.contact import Compensation, false_alarm_limit, second_zero
from exogauge.payload.contract import LogEntry
from exogauge.payload.evaluate import Evaluation, evaluate
from exogauge.payload.intake import open_payload
from exogauge.payload.log_names import log_names
from exogauge.payload.prepare import holds_of
from exogauge.payload.results import PayloadResults, results
from exogauge.payload.sensor_motion import SensorMotion
from exogauge.payload.statics import gravity_of, told_sign, touched_postures
from exogauge.payload.tables import identified_by_method, left_by_method
from exogauge.progress import Stage
from exogauge.synthetic.payload import write_payload

Array = NDArray[np.float64]
Change = Callable[[dict[str, Any], Path], None]
SHARED = Path(__file__).resolve().parents[3] / "shared/data"
KUKA = """
version: 1
name: KUKA run 1
gravity: [0, 0, -9.82085]
sensor: {wrench: [fx, fy, fz, tx, ty, tz], noise: {force_n: 0.03, moment_nm: 0.001}}
pose: {rotation: [r11, r12, r13, r21, r22, r23, r31, r32, r33], noise_rad: 1.0e-5}
time: {column: t, unit: us}
imu: {acceleration: [ax, ay, az], unit: g}
logs:
  - {file: 0-calibration_fts-accel.csv, role: postures, each_row: true}
  - {file: [1-baseline_wrench.csv, 1-baseline_accel.csv, 1-baseline_orientations.csv], role: excitation, span: [0, 3.4]}
  - {file: [1-baseline_wrench.csv, 1-baseline_accel.csv, 1-baseline_orientations.csv], role: test, span: [2.9, 7]}
settings: {cutoff_hz: 8, zero: drifted, moments: from_motion}
"""


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("payload") / "sample"
    write_payload(out, 3)
    return out


@pytest.fixture(scope="module")
def evaluation(sample: Path) -> Evaluation:
    return evaluate(open_payload(sample))


@pytest.fixture(scope="module")
def found(evaluation: Evaluation) -> PayloadResults:
    return results(evaluation)


@pytest.mark.slow
def test_the_command_writes_results_that_keep_their_schema(
    sample: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["payload", "run", str(sample), "--out", str(tmp_path)]) == 0
    written = PayloadResults.model_validate_json((tmp_path / "results.json").read_text())
    assert written.sees == "payload_on_sensor"
    schema = json.loads((tmp_path / "results.schema.json").read_text())
    assert set(schema["required"]) <= set(json.loads((tmp_path / "results.json").read_text()))
    told = capsys.readouterr().out
    assert "SYNTHETIC" in told
    assert "inclination taken" in told


@pytest.mark.slow
def test_what_is_identified_is_the_truth_within_its_interval(sample: Path, found: PayloadResults) -> None:
    truth = json.loads((sample / "truth.json").read_text())
    assert found.dynamic is not None
    assert found.static is not None
    inertia = np.array(truth["inertia_about_sensor"])
    i = [inertia[0, 0], inertia[0, 1], inertia[1, 1], inertia[0, 2], inertia[1, 2], inertia[2, 2]]
    expected = [truth["mass"], *truth["first_moment"], *i, *truth["zero"]]
    error = np.array([v.value for v in found.dynamic.values]) - expected
    std = np.array([v.std for v in found.dynamic.values])
    assert np.all(np.abs(error) < 4.0 * std)
    tilt = {v.name: v for v in found.static.values}
    assert [tilt["U"].value, tilt["V"].value] == pytest.approx(truth["tilt_deg"], abs=0.006)
    assert found.mass_error_kg == pytest.approx(error[0])
    assert list(found.dynamic.recursion.values()) == pytest.approx([v.value for v in found.dynamic.values], abs=1e-5)
    assert found.static.left_out_level is not None
    assert found.static.left_out_inclined is not None
    assert found.static.left_out_level.force_n > 50 * found.static.left_out_inclined.force_n


def test_inclination_ignored_leaves_what_the_paper_found_and_all_of_it_leaves_the_noise(found: PayloadResults) -> None:
    tilt = np.arccos(-gravity_of(*np.radians(generator.TILT_DEG))[2])
    ignored = 2 * generator.MASS * 9.81 * np.sin(tilt / 2)  # 20.3 N; its constant part goes into the zero
    noise = generator.FORCE_NOISE * 1.596  # mean norm of three unit deviates
    assert set(found.tests) == {"fast", "slow"}
    for ways in found.tests.values():
        assert ways["all"].mean[0] < noise + 0.1
        assert 2.0 < ways["level"].mean[0] < 1.2 * ignored
    assert found.tests["fast"]["static"].most[3:] > found.tests["fast"]["all"].most[3:]
    assert found.tests["fast"]["static"].mean[1] > 10 * found.tests["fast"]["all"].mean[1]


def test_the_tables_of_the_paper_are_told_in_full(sample: Path, found: PayloadResults, tmp_path: Path) -> None:
    """Three methods at two speeds, every axis, before and after (44); the norms are those of the axes."""
    truth = json.loads((sample / "truth.json").read_text())
    identified = identified_by_method(found)
    assert set(identified) == {"static", "level", "all"}
    assert identified["static"]["Ixx"] is None
    assert abs(identified["all"]["m"] - truth["mass"]) < 0.1 * abs(identified["level"]["m"] - truth["mass"])
    lines = {tuple(each[:4]): each[5:] for each in left_by_method(found)}
    assert len(lines) == 2 * 3 * 2 * 8
    for log in ("fast", "slow"):
        for way in identified:
            first = [lines[log, way, "before", axis][0] for axis in ("fx", "fy", "fz")]
            assert np.linalg.norm(first) == pytest.approx(lines[log, way, "before", "|f|"][0])
        assert lines[log, "all", "before", "|f|"][1] < lines[log, "level", "before", "|f|"][1]
        for axis in ("fx", "mz"):  # (44) takes the same off throughout
            (first, mean, std), (first_44, mean_44, std_44) = (
                lines[log, "level", state, axis] for state in ("before", "after")
            )
            assert first - first_44 == pytest.approx(mean - mean_44)
            assert std == pytest.approx(std_44)
    (tmp_path / "results.json").write_text(found.model_dump_json())
    assert main(["payload", "tables", str(tmp_path), "--out", str(tmp_path / "left.csv")]) == 0
    assert len((tmp_path / "left.csv").read_text().splitlines()) == 1 + len(lines)


def test_pushes_are_found_when_and_as_strong_as_they_were(sample: Path, found: PayloadResults) -> None:
    pushes = json.loads((sample / "truth.json").read_text())["pushes"]
    touches = found.contacts["contact"]
    assert len(touches) == len(pushes)
    for touch, push in zip(touches, pushes, strict=True):
        assert touch.start_s == pytest.approx(push["start"], abs=0.05)
        assert touch.end_s == pytest.approx(push["start"] + push["length"], abs=0.05)
        assert touch.force_n == pytest.approx(push["force"], abs=2.0)


def test_the_alarm_is_false_as_often_as_it_is_said(evaluation: Evaluation) -> None:
    """At one in twenty samples, so that it can be counted."""
    payload = evaluation.payload
    from exogauge.payload.prepare import moving, std_of

    assert evaluation.stages.excitation is not None
    chosen, gravity = evaluation.stages.excitation.chosen, evaluation.stages.gravity
    compensation = Compensation(chosen.value, chosen.covariance, gravity, evaluation.sign, std_of(payload))
    moved = moving(payload, payload.of("test")[1], gravity, None)
    limit = false_alarm_limit(0.05)
    f = compensation.external(moved.motion, moved.wrench)[:, :3]
    C = compensation.spread(moved.motion)[:, :3, :3]
    share = np.mean(np.einsum("ti,ti->t", f, np.linalg.solve(C, f[:, :, None])[:, :, 0]) > limit)
    assert share == pytest.approx(0.05, abs=0.02)


def test_44_takes_a_mass_error_off_up_to_sixty_degrees_and_makes_it_worse_beyond() -> None:
    angle = np.linspace(0.0, np.pi / 2, 900)
    R = np.zeros((900, 3, 3))
    R[:, 0, 0] = 1.0
    R[:, 1, 1] = R[:, 2, 2] = np.cos(angle)
    R[:, 2, 1], R[:, 1, 2] = np.sin(angle), -np.sin(angle)
    none = np.zeros((900, 3))
    time = np.concatenate([[0.0], np.linspace(1.0, 2.0, 899)])
    motion = SensorMotion(time, R, none, none, none, np.zeros((900, 9, 1)))
    left = np.zeros((900, 6))
    left[:, :3] = 0.1 * np.einsum("tji,j->ti", R, GRAVITY)  # 100 g too much
    zeroed, helps = second_zero(motion, left, GRAVITY)
    size = np.linalg.norm(zeroed[:, :3], axis=1)
    assert size == pytest.approx(0.1 * 9.81 * 2 * np.sin(angle / 2), abs=1e-12)
    assert np.array_equal(helps, angle <= np.pi / 3 + 1e-9)
    assert np.array_equal(size <= 0.1 * 9.81 + 1e-9, helps)


@pytest.mark.slow
@pytest.mark.skipif(not (SHARED / "kuka_ft_payload").is_dir(), reason="no recordings beside the repository")
def test_a_real_run_with_three_clocks_and_an_imu_of_unknown_axes(tmp_path: Path) -> None:
    for path in (SHARED / "kuka_ft_payload").glob("*.csv"):
        (tmp_path / path.name).symlink_to(path)
    (tmp_path / "payload.yaml").write_text(KUKA)
    found = results(evaluate(open_payload(tmp_path)))
    assert found.imu is not None
    assert found.dynamic is not None
    assert found.imu.angle_deg > 60.0
    assert abs(found.imu.lag_ms - 8.416) < 1.96 * found.imu.lag_std_ms  # as its makers say
    assert found.imu.lag_std_ms < 4.0
    rms = np.array(found.tests["1-baseline_wrench 2.9–7 s"]["all"].rms[:3])
    assert np.all(rms <= [0.18, 0.09, 0.13])
    still = np.array(found.tests["1-baseline_wrench 2.9–7 s"]["static"].rms[:3])
    assert np.linalg.norm(rms) < 0.5 * np.linalg.norm(still)
    assert found.dynamic.mass_from_motion_alone.value == pytest.approx(0.932, rel=0.04)
    undecided = {v.name for v in found.dynamic.values if not v.identified}
    assert {"Ixx", "Izz"} <= undecided
    assert found.dynamic.mu is None
    assert (found.missing.verdict, found.missing.reason) == ("undecided", "noise_unknown")


def rewritten(path: Path, change: Callable[[dict[str, Array]], None]) -> None:
    """One log with other columns."""
    table = pq.read_table(path)
    columns = {name: table[name].to_numpy().copy() for name in table.column_names}
    change(columns)
    pq.write_table(pa.table(columns), path)


def cut(log: str, samples: int) -> Change:
    return lambda content, folder: rewritten(
        folder / "logs" / f"{log}.parquet", lambda c: c.update({k: v[:samples] for k, v in c.items()})
    )


def scale(names: str | tuple[str, ...], factor: float) -> Change:
    def change(content: dict[str, Any], folder: Path) -> None:
        for log in folder.glob("logs/*.parquet"):
            rewritten(log, lambda c: c.update({k: v * factor for k, v in c.items() if k.startswith(names)}))

    return change


def coarse(content: dict[str, Any], folder: Path) -> None:
    """A weight of a fifth of a newton, told in newtons."""
    rng = np.random.default_rng(3)

    def change(columns: dict[str, Array]) -> None:
        for name, step in [*((f"f{axis}", 1.0) for axis in "xyz"), *((f"m{axis}", 0.05) for axis in "xyz")]:
            light = 5e-4 * columns[name] + 0.15 * step * rng.standard_normal(len(columns[name]))
            columns[name] = np.round(light / step) * step

    for log in folder.glob("logs/*.parquet"):
        rewritten(log, change)


def key(*path: str, value: Any) -> Change:
    def change(content: dict[str, Any], folder: Path) -> None:
        place = content
        for part in path[:-1]:
            place = place[part]
        place[path[-1]] = value

    return change


def broken(log: str, change: Callable[[dict[str, Array]], None]) -> Change:
    return lambda content, folder: rewritten(folder / "logs" / f"{log}.parquet", change)


def put(name: str, row: int, value: float) -> Callable[[dict[str, Array]], None]:
    def change(columns: dict[str, Array]) -> None:
        columns[name][row] = value

    return change


def of_two_clocks(content: dict[str, Any], folder: Path) -> None:
    """Every third wrench and every second pose, in two files, the pose a little later than the first wrench."""
    for entry in content["logs"]:
        path = folder / entry["file"]
        table = pq.read_table(path)
        joints = [name for name in table.column_names if name[0] == "q"]
        wrench, pose = table.drop(joints), table.select(["t", *joints])
        every = np.arange(table.num_rows)
        pq.write_table(wrench.take(every[::3]), path.with_suffix(".wrench.parquet"))
        pq.write_table(pose.take(every[7::2]), path.with_suffix(".pose.parquet"))
        entry["file"] = [entry["file"].replace(".parquet", f".{part}.parquet") for part in ("wrench", "pose")]


@pytest.mark.slow
def test_pose_and_wrench_of_two_clocks_and_rates_are_as_good_as_of_one(sample: Path, tmp_path: Path) -> None:
    folder = tmp_path / "two"
    shutil.copytree(sample, folder)
    content = yaml.safe_load((folder / "payload.yaml").read_text())
    of_two_clocks(content, folder)
    (folder / "payload.yaml").write_text(yaml.safe_dump(content))
    found = results(evaluate(open_payload(folder)))
    truth = json.loads((sample / "truth.json").read_text())
    assert found.dynamic is not None
    assert found.dynamic.method == "gtls"
    assert found.dynamic.mu == pytest.approx(1.0, abs=0.1)
    assert found.missing.verdict == "none"
    values = {each.name: each for each in found.dynamic.values}
    inertia = np.array(truth["inertia_about_sensor"])
    for name, true in (("m", truth["mass"]), ("Ixx", inertia[0, 0]), ("Iyz", inertia[1, 2]), ("Izz", inertia[2, 2])):
        assert abs(values[name].value - true) < 3.5 * values[name].std
    assert values["Izz"].std < 0.01
    assert len(found.contacts["contact.wrench"]) == len(truth["pushes"])


def postures_alone(folder: Path) -> None:
    content = yaml.safe_load((folder / "payload.yaml").read_text())
    content["logs"] = content["logs"][:1]
    (folder / "payload.yaml").write_text(yaml.safe_dump(content))


@pytest.mark.slow
def test_an_identification_says_at_which_stage_it_is(tmp_path: Path) -> None:
    said: list[tuple[float, str, Stage]] = []
    foreign.write(tmp_path, 1, seconds=6.0)
    identify(tmp_path, tmp_path / "whole", lambda *each: said.append(each), {})
    assert list(dict.fromkeys(stage for _, _, stage in said)) == [
        Stage.READING, Stage.POSTURES, Stage.KINEMATICS, Stage.EXCITATION, Stage.MISSING, Stage.CONTACT, Stage.WRITING,
    ]  # fmt: skip
    shares = [share for share, _, _ in said]
    assert shares == sorted(shares)
    assert "smoothing the motion of other" in {message for _, message, _ in said}
    postures_alone(tmp_path)
    said.clear()
    identify(tmp_path, tmp_path / "out", lambda *each: said.append(each), {})
    assert {stage for _, _, stage in said} == {Stage.READING, Stage.POSTURES, Stage.WRITING}


@pytest.mark.slow
def test_logs_of_one_name_are_all_told_and_one_log_twice_is_refused(
    sample: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two days' logs lie under one name in two folders, one file is cut in two, and none displaces another."""
    shutil.copytree(sample, tmp_path / "days")
    content = yaml.safe_load((tmp_path / "days" / "payload.yaml").read_text())
    logs = tmp_path / "days" / "logs"
    (logs / "again").mkdir()
    for name in ("fast", "contact"):
        shutil.copy(logs / f"{name}.parquet", logs / "again" / f"{name}.parquet")
    kept = [each for each in content["logs"] if each["role"] in ("postures", "contact") or "fast" in each["file"]]
    more = [
        {"file": "logs/again/fast.parquet", "role": "test"}, {"file": "logs/again/contact.parquet", "role": "contact"},
        {"file": "logs/slow.parquet", "role": "test", "span": [0, 5]},
        {"file": "logs/slow.parquet", "role": "test", "span": [5, 10]},
    ]  # fmt: skip
    content["logs"] = [*kept, *more]
    (tmp_path / "days" / "payload.yaml").write_text(yaml.safe_dump(content))
    found = results(evaluate(open_payload(tmp_path / "days")))
    assert set(found.tests) == {"logs/fast", "logs/again/fast", "slow 0–5 s", "slow 5–10 s"}
    assert set(found.contacts) == {"logs/contact", "logs/again/contact"}

    content["logs"].append({"file": "logs/again/fast.parquet", "role": "test"})
    (tmp_path / "days" / "payload.yaml").write_text(yaml.safe_dump(content))
    assert main(["payload", "run", str(tmp_path / "days"), "--out", str(tmp_path / "out")]) != 0
    told = capsys.readouterr().err
    assert "logs/again/fast.parquet" in told
    assert "`span`" in told


@pytest.mark.parametrize(
    ("logs", "expected"),
    [
        ([("a.csv", "test"), ("b.csv", "test")], ["a", "b"]),
        ([("a.csv", "test"), ("a.parquet", "test")], ["a.csv", "a.parquet"]),
        ([("a.csv", "excitation"), ("a.csv", "test")], ["a excitation", "a test"]),
        ([("x/postures.csv", "test"), ("y.csv", "postures")], ["postures test", "y"]),
        ([("a.csv", "test"), ("a", "test")], ["a.csv", "a"]),
        ([("a.csv", "test"), ("x/a.csv", "test"), ("a.csv.gz", "test")], ["a", "x/a", "a.csv"]),
    ],
)  # fmt: skip
def test_no_two_logs_are_told_under_one_name(logs: list[tuple[str, Any]], expected: list[str]) -> None:
    assert log_names([LogEntry(file=(file,), role=role) for file, role in logs], "payload.yaml") == expected


def test_postures_alone_tell_mass_centre_and_zero(sample: Path, tmp_path: Path) -> None:
    shutil.copytree(sample, tmp_path / "still")
    postures_alone(tmp_path / "still")
    found = results(evaluate(open_payload(tmp_path / "still")))
    assert found.dynamic is None
    assert found.static is not None
    assert found.mass_error_kg == pytest.approx(0.0, abs=0.006)
    assert (found.missing.verdict, found.missing.reason) == ("undecided", "no_motion")
    assert {v.name for v in found.static.values} >= {"m", "cx", "fx0", "mz0", "U", "V"}


def posed(how: str) -> Change:
    """The pose of the sensor as it would be logged, in place of joint angles; `how` says what is wrong with it."""

    def change(content: dict[str, Any], folder: Path) -> None:
        model = pin.buildModelFromUrdf(str(folder / "arm.urdf"))
        data, frame = model.createData(), model.getFrameId("ft")

        def logged(columns: dict[str, Array]) -> None:
            q = np.column_stack([columns[f"q.{joint}"] for joint in generator.JOINTS])
            R = np.empty((len(q), 3, 3))
            for k, angles in enumerate(q):
                pin.framesForwardKinematics(model, data, angles)
                R[k] = data.oMf[frame].rotation
            R = {"transposed": np.swapaxes(R, 1, 2), "stretched": 1.02 * R}.get(how, R)
            quaternion = Rotation.from_matrix(R).as_quat(scalar_first=how == "order")
            columns.update({f"k{k}": each for k, each in enumerate(quaternion.T)})
            columns.update({f"r{k}": each for k, each in enumerate(R.reshape(-1, 9).T)})

        content["logs"] = content["logs"][:1]
        rewritten(folder / "logs/postures.parquet", logged)
        turned = {"quaternion": [f"k{k}" for k in range(4)], "quaternion_order": "xyzw"}
        content["pose"] = {"noise_rad": 2e-5} | (
            turned if how == "order" else {"rotation": [f"r{k}" for k in range(9)]}
        )
        del content["sensor"]["frame"]

    return change


def turned_about_gravity(columns: dict[str, Array]) -> None:
    """All postures alike but for the first joint, which stands upright."""
    rng = np.random.default_rng(0)
    for name, values in columns.items():
        spread = generator.ENCODER_NOISE if name[0] == "q" else 0.5 if name[0] == "f" else 0.05
        if name != "t":
            columns[name] = values[:200].mean() + spread * rng.standard_normal(len(values))
    columns["q.a1"] = columns["q.a1"] + 0.2 * np.floor(columns["t"] / 2)


def on_another_day(content: dict[str, Any], folder: Path) -> None:
    """Pose and wrench in two files, whose clocks have nothing in common."""
    table = pq.read_table(folder / "logs/excitation.parquet")
    time, joints = table["t"].to_numpy(), [name for name in table.column_names if name[0] == "q"]
    pq.write_table(table.drop(joints), folder / "logs/wrench.parquet")
    pq.write_table(
        pa.table({"t": time + 1000.0} | {name: table[name] for name in joints}), folder / "logs/pose.parquet"
    )
    content["logs"][1]["file"] = ["logs/wrench.parquet", "logs/pose.parquet"]


def with_a_word(content: dict[str, Any], folder: Path) -> None:
    table = pq.read_table(folder / "logs/postures.parquet").slice(0, 100)
    rows = np.column_stack([table[name].to_numpy() for name in table.column_names]).astype(str)
    rows[40, 3] = "sticky"
    lines = [",".join(each) for each in ([table.column_names, *rows.tolist()])]
    (folder / "logs/postures.csv").write_text("\n".join(lines))
    content["logs"] = [{"file": "logs/postures.csv", "role": "postures"}]


BAD: dict[str, tuple[Change, str]] = {
    "transposed": (posed("transposed"), r"postures\.parquet.*fit the transpose.*R_base_sensor"),
    "quaternion's order": (posed("order"), r"postures\.parquet.*quaternion_order: wxyz"),
    "no rotation": (posed("stretched"), r"postures\.parquet, row 1, column 'r0'.*0\.04.*row by row"),
    "all alike in gravity": (broken("postures", turned_about_gravity), r"postures\.parquet: .*gravity has other"),
    "two postures": (
        key("logs", value=[{"file": "logs/postures.parquet", "role": "postures", "span": [0.0, 3.6]}]),
        r"postures\.parquet: 2 postures.*at least six",
    ),
    "clocks apart": (on_another_day, r"clocks do not overlap.*wrench\.parquet.*pose\.parquet 1000"),
    "a word": (with_a_word, r"postures\.csv, row 41, column '.*sticky"),
    "N·mm": (scale(("mx", "my", "mz"), 1000.0), r"postures\.parquet, column 'mx'.*Nmm"),
    "kgf": (scale(("fx", "fy", "fz"), 1.0 / 9.80665), r"excitation\.parquet, column 'mx'.*9\.[6-9].*force_unit: kgf"),
    "an IMU in no log": (key("imu", value={"acceleration": ["ax", "ay", "az"]}), r"imu\.acceleration.*value: ax"),
    "sign": (key("sensor", "sees", value="sensor_on_payload"), "payload_on_sensor"),
    "gravity upwards": (key("gravity", value=[0, 0, 9.81]), "sees"),
    "gravity in g": (key("gravity", value=[0, 0, -1.0]), r"row \d+, column 'gravity'.*\[0, 0, -9\.81\]"),
    "wrench in other axes": (key("sensor", "axes", value="base"), "axes: sensor"),
    "degrees": (scale("q.", 180 / np.pi), "angle_unit: deg"),
    "unknown joint": (key("pose", "joints", value={"a9": "q.a1"}), "joint"),
    "unknown frame": (key("sensor", "frame", value="wrist"), "frame"),
    "unknown column": (key("sensor", "wrench", value=["Fx", "fy", "fz", "mx", "my", "mz"]), "column"),
    "unknown key": (key("sensor", "nois", value=3), "nois"),
    "unit": (key("sensor", "force_unit", value="dyn"), r"payload\.yaml, column 'sensor\.force_unit'.*kgf"),
    "missing value": (broken("postures", put("fz", 40, np.nan)), "row 41"),
    "infinite": (broken("excitation", put("q.a4", 7, np.inf)), "row 8"),
    "time twice": (broken("excitation", put("t", 100, 99 / 250)), "row 101"),
    "nothing stood still": (key("logs", value=[{"file": "logs/fast.parquet", "role": "postures"}]), "postures"),
    "nothing moved": (
        key(
            "logs",
            value=[
                {"file": "logs/postures.parquet", "role": "postures"},
                {"file": "logs/postures.parquet", "role": "excitation", "span": [0.0, 1.0]},
            ],
        ),
        "excitation",
    ),
    "no samples": (cut("excitation", 0), "0 samples"),
    "a few samples": (cut("fast", 5), "5 samples"),
    "nothing on the sensor": (scale(("fx", "fy", "fz", "mx", "my", "mz"), 0.0), "nothing hangs"),
    "steps larger than the weight": (coarse, "nothing hangs on the sensor, or less than its steps of 1 N show"),
    "nothing turned": (
        broken("excitation", lambda c: c.update({k: np.full(len(v), v[0]) for k, v in c.items() if k[0] == "q"})),
        "excitation|inertia",
    ),
    "one column for two joints": (key("pose", "joints", "a2", value="q.a1"), "twice"),
    "one column for two axes": (key("sensor", "wrench", value=["fx", "fx", "fz", "mx", "my", "mz"]), "twice"),
    "negative mass": (key("ground_truth", value={"mass_kg": -3.0}), "greater than 0"),
    "no file": (key("logs", value=[{"file": "logs/none.parquet", "role": "postures"}]), "logs/none.parquet"),
    "a span outside": (
        key("logs", value=[{"file": "logs/postures.parquet", "role": "postures", "span": [500.0, 600.0]}]),
        "overlap",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_input_is_refused_with_advice(
    what: str, sample: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change, said = BAD[what]
    folder = tmp_path / "bad"
    shutil.copytree(sample, folder)
    content = yaml.safe_load((folder / "payload.yaml").read_text())
    change(content, folder)
    (folder / "payload.yaml").write_text(yaml.safe_dump(content))
    assert main(["payload", "run", str(folder), "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert re.search(said, told), told
    assert "Traceback" not in told


@pytest.mark.slow
def test_a_wrench_wholly_in_another_unit_is_told_where_it_was_weighed(sample: Path, tmp_path: Path) -> None:
    """kgf and kgf·m read as N and N·m: forces and moments agree, and the weighed mass alone tells."""
    folder = tmp_path / "bad"
    shutil.copytree(sample, folder)
    scale(("f", "m"), 1.0 / 9.80665)({}, folder)
    warnings = evaluate(open_payload(folder)).warnings
    assert sum("force_unit" in each for each in warnings) == 1


@pytest.mark.slow
def test_a_cut_off_channel_is_told_with_the_results(sample: Path, tmp_path: Path) -> None:
    folder = tmp_path / "bad"
    shutil.copytree(sample, folder)
    values = pq.read_table(folder / "logs/fast.parquet")["fz"].to_numpy()
    limit = float(np.quantile(values, 0.8))
    rewritten(folder / "logs/fast.parquet", lambda c: c.update(fz=np.minimum(c["fz"], limit)))
    (told,) = [each for each in evaluate(open_payload(folder)).warnings if "cut off" in each]
    row = int(re.search(r"logs/fast\.parquet, row (\d+), column 'fz'", told)[1])  # type: ignore[index]
    assert values[row - 1] >= limit


@pytest.mark.slow
@pytest.mark.parametrize("posture", [0, 7])
def test_a_posture_that_was_touched_is_left_out_and_told(
    sample: Path, evaluation: Evaluation, tmp_path: Path, posture: int
) -> None:
    folder = tmp_path / "touched"
    shutil.copytree(sample, folder)
    clean = evaluation.stages.postures
    assert clean is not None
    assert not clean.touched
    assert clean.holds.spans is not None
    start, end = clean.holds.spans[posture]

    def lean_on_it(columns: dict[str, Array]) -> None:
        columns["fy"][(columns["t"] >= start) & (columns["t"] <= end)] += 2.0

    rewritten(folder / "logs/postures.parquet", lean_on_it)
    found = evaluate(open_payload(folder) if posture else still(folder))
    (told,) = [each for each in found.warnings if "touched" in each]
    size = re.search(rf"Posture {posture + 1}, {start:.2f} to {end:.2f} s: ([\d.]+) N", told)
    assert size is not None
    assert float(size[1]) == pytest.approx(2.0, abs=0.2)
    assert found.stages.postures is not None
    assert len(found.stages.postures.holds) == len(clean.holds) - 1
    assert found.stages.postures.chosen.mass == pytest.approx(clean.chosen.mass, abs=0.005)
    assert found.missing.decision.verdict == ("none" if posture else "undecided")


@pytest.mark.skipif(not (SHARED / "kuka_ft_payload").is_dir(), reason="no recordings beside the repository")
def test_a_real_imu_in_another_unit_is_refused_and_no_real_posture_is_called_touched(tmp_path: Path) -> None:
    for path in (SHARED / "kuka_ft_payload").glob("*.csv"):
        (tmp_path / path.name).symlink_to(path)
    (tmp_path / "payload.yaml").write_text(KUKA.replace("unit: g}", "unit: m/s^2}"))
    payload = open_payload(tmp_path)
    holds, _ = holds_of(payload)
    assert not touched_postures(holds, np.array(payload.file.gravity), told_sign(holds, np.array(payload.file.gravity)))
    with pytest.raises(BadStudy, match=r"ax.*IMU reads 0\.10.*imu\.unit"):
        evaluate(payload)


@pytest.mark.slow
def test_noise_with_heavy_tails_is_no_push(sample: Path, tmp_path: Path) -> None:
    """Single readings that jump far, again and again: nobody touched anything, and nothing is left out."""
    folder, rng = tmp_path / "jumping", np.random.default_rng(3)
    shutil.copytree(sample, folder)

    def jump(columns: dict[str, Array]) -> None:
        for name, std in zip(("fx", "fy", "fz", "mx", "my", "mz"), STD, strict=True):
            columns[name] += 0.6 * std * rng.standard_t(2.2, len(columns[name]))

    rewritten(folder / "logs/excitation.parquet", jump)
    found = evaluate(open_payload(folder))
    assert not [each for each in found.warnings if "touched" in each]
    assert found.stages.excitation is not None
    assert not found.stages.excitation.left_out
    assert found.missing.decision.verdict != "none"


@pytest.mark.slow
def test_a_push_while_exciting_is_left_out_and_told(sample: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pushed"
    shutil.copytree(sample, folder)

    def push(columns: dict[str, Array]) -> None:
        columns["fx"][1000:1100] += 30.0
        columns["fy"][:60] += 30.0

    rewritten(folder / "logs/excitation.parquet", push)
    evaluation = evaluate(open_payload(folder))
    assert not any("-0." in each for each in evaluation.warnings), "before the log begins"
    assert any("touched" in each and "4.0" in each for each in evaluation.warnings) or any(
        "touched" in each and "3.8" in each for each in evaluation.warnings
    )
    assert evaluation.stages.excitation is not None
    truth = json.loads((sample / "truth.json").read_text())
    assert evaluation.stages.excitation.chosen.value[0] == pytest.approx(truth["mass"], abs=0.01)


@pytest.mark.slow
def test_what_decided_stands_in_the_results_and_other_numbers_decide_otherwise(
    sample: Path, found: PayloadResults
) -> None:
    folder_payload = open_payload(sample, roles=("postures", "excitation"))
    usual = Criteria()
    told = {each.name: each for each in found.criteria}
    assert told["payload_dynamic.decided"].value == usual.payload_dynamic.decided
    assert len(told["payload.hangs_hz"].why) > 20
    assert {name.partition(".")[0] for name in told} >= {"judging", "payload", "payload_static", "payload_dynamic"}
    looser = replace(usual, payload_dynamic=replace(usual.payload_dynamic, decided=0.5))
    other = results(evaluate(folder_payload, criteria=looser))
    assert {each.name: each.value for each in other.criteria}["payload_dynamic.decided"] == 0.5
    never = replace(usual, payload_dynamic=replace(usual.payload_dynamic, decided=0.0))
    with pytest.raises(NotIdentifiable):
        evaluate(folder_payload, criteria=never)
