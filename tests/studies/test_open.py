"""Study and robot files become a Robot, settings and recordings that fit together, or a fault with its place."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml

from exogauge.errors import BadInput, BadLog, BadRobot, BadStudy
from exogauge.studies.intake.open import needed_channels, open_study, read_recordings, read_worn
from exogauge.studies.intake.robot_file import load_robot, motor_from_joint, read_robot
from exogauge.support.settings import SupportSettings

Rewrite = Callable[[str, str, str], Path]
SUIT = """version: 1
name: {name}
bands:
  - name: A
    via_points:
      - {{link: chest_1, xyz: [-0.1, 0, 0.2]}}
      - {{link: BODY, xyz: [-0.12, 0, 0.1]}}
"""


@pytest.fixture
def worn(folder: Path, rewrite: Rewrite) -> Path:
    """The study with a log without a device, and one log each with two devices."""
    for name in ("plain", "worn", "other"):
        (folder / "logs" / f"{name}.parquet").write_bytes((folder / "logs/id_1.parquet").read_bytes())
    for file, name in (("suit.yaml", "Suit"), ("thin.yaml", "Thin")):
        (folder / file).write_text(SUIT.format(name=name))
    extra = """  - {file: logs/plain.parquet, role: without_device, motion: bend}
  - {file: logs/worn.parquet, role: with_device, motion: bend}
  - {file: logs/other.parquet, role: with_device, device: thin.yaml}
"""
    rewrite("study.yaml", "robot: robot.yaml\n", "robot: robot.yaml\ndevice: suit.yaml\n")
    return rewrite("study.yaml", "settings:", extra + "settings:")


def test_the_robot_file_becomes_the_robot(folder: Path) -> None:
    robot = load_robot(folder, "robot.yaml")
    assert robot.tree.joints == ("torso_yaw", "torso_pitch", "r_elbow")
    assert robot.sensors[0].sign == -1.0
    assert robot.inertial_std == {"": 0.25, "chest_1": 0.1}
    assert robot.joints[1].prior == {"k_T": 5.0, "J_r": 0.3}
    assert robot.T_base_imu.isApprox(pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.2])))


def test_axes_have_a_unit_diagonal_and_divide_each_motor_row_by_its_own_gear(folder: Path) -> None:
    with open_study(folder) as study:
        M = motor_from_joint(study.robot_file)
        C = study.robot.axes_from_joints
    np.testing.assert_allclose(M, [[100, 0, 0], [0, 45, 0], [0, 32, 32]])
    np.testing.assert_allclose(C, [[1, 0, 0], [0, 1, 0], [0, 1, 1]])
    np.testing.assert_allclose(np.diag(np.diag(M)) @ C, M)


def test_an_imu_pose_in_the_base_link_equals_the_frame(rewrite: Rewrite, folder: Path) -> None:
    by_frame = load_robot(folder).T_base_imu
    by_pose = load_robot(rewrite("robot.yaml", "{frame: imu_link}", "{parent: BODY, xyz: [0, 0, 0.2]}")).T_base_imu
    assert by_frame.isApprox(by_pose)
    turned = load_robot(rewrite("robot.yaml", "[0, 0, 0.2]", "[0, 0, 0.2], rpy: [0, 0, 1.5707963267948966]"))
    np.testing.assert_allclose(turned.T_base_imu.rotation @ [1, 0, 0], [0, 1, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("sees", "sign"),
    [("world_on_robot", 1), ("robot_on_world", -1), ("payload_on_sensor", 1), ("sensor_on_payload", -1)],
)
def test_what_a_sensor_sees_sets_its_sign(rewrite: Rewrite, sees: str, sign: float) -> None:
    assert load_robot(rewrite("robot.yaml", "robot_on_world", sees)).sensors[0].sign == sign


def test_a_fixed_base_finds_its_root(rewrite: Rewrite) -> None:
    rewrite("robot.yaml", "base: floating\nbase_link: BODY\nimu: {frame: imu_link}\n", "base: fixed\n")
    robot = load_robot(rewrite("robot.yaml", "role: contact", "role: cut"))
    assert not robot.floating
    assert robot.T_base_imu is None
    assert robot.tree.bodies == ("chest_0", "chest_1", "r_arm", "BODY")  # which the sensor under it carries too
    assert set(robot.tree.cuts.values()) == {(0, 1, 2, 3)}
    assert not any(name.startswith(("acc", "gyro")) for name in needed_channels(robot))


def test_a_joint_without_logged_torque_needs_its_position_only(rewrite: Rewrite) -> None:
    text = "{name: torso_yaw, actuation: current, gear_ratio: 100, prior: {k_T: 5.0, tau_c: 1}, prior_std: {k_T: 1.0}}"
    robot = load_robot(rewrite("robot.yaml", text, "{name: torso_yaw, actuation: none}"))
    assert robot.joints[0].actuation == "none"
    assert [name for name in needed_channels(robot) if name.endswith(".torso_yaw")] == ["q.torso_yaw"]


@pytest.mark.parametrize(
    ("old", "new", "row", "words"),
    [
        ("{name: torso_yaw,", "{name: torso_jaw,", 9, "Did you mean 'torso_yaw'"),
        ("base_link: BODY", "base_link: BODI", 4, "Did you mean 'BODY'"),
        ("frame: imu_link", "frame: imu_lnk", 5, "Did you mean 'imu_link'"),
        ("frame: imu_link", "frame: chest_1", 5, "sits on 'chest_1'"),
        ("frame: foot_sensor", "frame: foot_sensr", 7, "foot_sensor"),
        ("joints: [torso_pitch, r_elbow]", "joints: [torso_pitch, l_elbow]", 13, "Did you mean 'r_elbow'"),
        ("[[45.0, 0.0]", "[[44.0, 0.0]", 14, "Make them equal"),
        ("[32.0, 32.0]]", "[32.0, -32.0]]", 14, "Make them equal"),
        ("elbow, actuation: torque", "elbow, actuation: none", 13, "that of 'r_elbow' is not logged"),
        ("chest_1: 0.1", "chest: 0.1", 16, "Did you mean 'chest_"),
        ("chest_1: 0.1", "imu_link: 0.1", 16, "fixed to 'BODY'"),
        ("{name: r_elbow,", "{name: torso_yaw,", 11, "twice"),
        ("urdf: robot.urdf", "urdf: robots.urdf", 2, "Did you mean 'robot.urdf'"),
    ],
)
def test_an_unknown_name_is_told_where_it_is_written(
    rewrite: Rewrite, old: str, new: str, row: int, words: str
) -> None:
    with pytest.raises(BadInput) as caught:
        load_robot(rewrite("robot.yaml", old, new))
    (fault,) = caught.value.faults
    assert fault.file == "robot.yaml"
    assert words in str(fault)
    assert fault.row in (row, None)


def test_recordings_are_fitted_or_held_out_by_role(worn: Path) -> None:
    with open_study(worn) as study:
        recordings = read_recordings(study)
    assert [(each.log.name, each.held_out) for each in recordings] == [
        ("id_1", False),
        ("val_1", True),
        ("plain", True),
    ]


def test_logs_with_a_device_know_it_and_their_motion(worn: Path) -> None:
    with open_study(worn) as study:
        first, second = read_worn(study)
        assert (first.log.name, first.motion, first.device) == ("worn", "bend", study.devices["suit.yaml"])
        assert (second.log.name, second.motion, second.device.name) == ("other", "other", "Thin")
        assert first.log.samples == 400
        assert list(study.devices) == ["suit.yaml", "thin.yaml"]
        assert study.log_devices == (None, None, None, "suit.yaml", "thin.yaml")
        assert {name: each.motion for name, each in study.motions.items()} == {
            "id_1": None, "val_1": "bend", "plain": "bend", "worn": "bend", "other": None,
        }  # fmt: skip
        assert study.motions["plain"].role == "without_device"
        assert [each.code for each in study.notices] == ["session_unknown"]
        assert study.support_settings.started == {}


def test_a_worn_log_lacks_no_column_either(worn: Path, log_writer: Callable[..., None]) -> None:
    with open_study(worn) as study:
        log_writer(worn / "logs/worn.parquet", study.robot, drop=("q.r_elbow",))
        with pytest.raises(BadLog) as caught:
            read_worn(study)
    assert [(fault.file, fault.column) for fault in caught.value.faults] == [("logs/worn.parquet", "q.r_elbow")]


@pytest.mark.parametrize(
    ("steps", "done", "skipped"),
    [
        ("", ["identify", "support", "stiffness", "discrepancy"], []),
        ("steps: [stiffness]\n", ["identify", "support", "stiffness"], []),
        ("steps: [support]\n", ["identify", "support"], []),
        ("steps: [identify]\n", ["identify"], []),
        ("steps: [discrepancy]\n", ["identify", "discrepancy"], []),
    ],
)
def test_what_stands_on_a_step_asks_for_it(
    worn: Path, rewrite: Rewrite, steps: str, done: list[str], skipped: list[str]
) -> None:
    with open_study(rewrite("study.yaml", "settings:", steps + "settings:")) as study:
        assert [each.step for each in study.steps if each.skipped is None] == done
        assert [each.step for each in study.steps if each.skipped is not None] == skipped


def test_without_a_held_out_log_nothing_can_be_claimed_and_the_step_says_so(folder: Path, rewrite: Rewrite) -> None:
    text = (folder / "study.yaml").read_text()
    rewrite("study.yaml", text, text.replace("role: validation", "role: identification"))
    with open_study(folder) as study:
        reasons = {each.step: each.skipped for each in study.steps}
    assert "held out" in str(reasons["discrepancy"])


def test_without_a_log_with_the_device_support_is_skipped_and_says_why(folder: Path) -> None:
    with open_study(folder) as study:
        reasons = {each.step: each.skipped for each in study.steps}
    assert reasons["identify"] is None
    assert "with_device" in str(reasons["support"])
    assert "with_device" in str(reasons["stiffness"])


def test_a_devices_fault_is_told_when_the_study_is_opened(worn: Path, rewrite: Rewrite) -> None:
    rewrite("thin.yaml", "link: chest_1", "link: chest_2")
    with pytest.raises(BadStudy) as caught:
        open_study(rewrite("suit.yaml", "link: BODY", "link: BODI"))
    assert [(fault.file, fault.row) for fault in caught.value.faults] == [("suit.yaml", 7), ("thin.yaml", 6)]


def test_two_devices_of_one_name_are_refused(worn: Path, rewrite: Rewrite) -> None:
    with pytest.raises(BadStudy, match="has the same name"):
        open_study(rewrite("thin.yaml", "name: Thin", "name: Suit"))


def test_limits_on_motions_are_no_setting_of_the_identification(rewrite: Rewrite) -> None:
    root = rewrite("study.yaml", "settings: {", "settings: {motion_doubtful: 0.2, ")
    with open_study(root, {"motion_different": 0.7}) as study:
        assert study.support_settings == SupportSettings(doubtful=0.2, different=0.7)


def test_one_file_is_split_into_fitted_and_held_out_rows(rewrite: Rewrite) -> None:
    rewrite("study.yaml", "file: logs/id_1.parquet,", "file: logs/id_1.parquet, rows: [0, 300],")
    root = rewrite("study.yaml", "file: logs/val_1.parquet,", "file: logs/id_1.parquet, rows: [300, 400],")
    with open_study(root) as study:
        first, second = read_recordings(study)
    assert (first.log.name, second.log.name) == ("id_1_0_300", "id_1_300_400")
    assert (first.log.samples, second.log.samples) == (300, 100)
    assert second.log.time[0] == pytest.approx(1.5)


@pytest.mark.slow
def test_a_zip_gives_the_same_recordings(folder: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "s.zip", "w") as archive:
        for each in folder.rglob("*.*"):
            archive.write(each, each.relative_to(folder).as_posix())
    with open_study(tmp_path / "s.zip") as zipped, open_study(folder / "study.yaml") as plain:
        for a, b in zip(read_recordings(zipped), read_recordings(plain), strict=True):
            np.testing.assert_array_equal(a.log.channels["q.torso_yaw"], b.log.channels["q.torso_yaw"])
        assert zipped.bundle.inputs == plain.bundle.inputs


def test_a_missing_column_is_named_for_every_log(folder: Path, log_writer: Callable[..., None]) -> None:
    with open_study(folder) as study:
        for name in ("id_1", "val_1"):
            log_writer(folder / "logs" / f"{name}.parquet", study.robot, drop=("i.torso_yaw", "ft.foot.mz"))
        with pytest.raises(BadLog) as caught:
            read_recordings(study)
    assert [(fault.file, fault.column) for fault in caught.value.faults] == [
        ("logs/id_1.parquet", "i.torso_yaw"),
        ("logs/id_1.parquet", "ft.foot.mz"),
        ("logs/val_1.parquet", "i.torso_yaw"),
        ("logs/val_1.parquet", "ft.foot.mz"),
    ]


@pytest.mark.slow
def test_damaged_logs_are_all_named_at_once(folder: Path) -> None:
    for name in ("id_1", "val_1"):
        path = folder / "logs" / f"{name}.parquet"
        path.write_bytes(path.read_bytes()[:-100])
    with open_study(folder) as study, pytest.raises(BadLog) as caught:
        read_recordings(study)
    assert [(fault.file, fault.rule) for fault in caught.value.faults] == [
        ("logs/id_1.parquet", "unreadable_file"),
        ("logs/val_1.parquet", "unreadable_file"),
    ]


def test_the_callers_settings_go_on_top(folder: Path) -> None:
    with open_study(folder, {"cutoff_hz": 20, "consistency": "physical"}) as study:
        assert study.settings.cutoff_hz == 20.0
        assert study.settings.consistency == "physical"
        assert study.settings.prior_strength == 1.0
    with pytest.raises(BadStudy, match="Did you mean 'solver'"):
        open_study(folder, {"solvr": "rows"})


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("role: identification", "role: validation", "no log to identify from"),
        ("settings: {", "settings: {effects: [viscos], ", "Did you mean 'viscous'"),
        ("logs/val_1.parquet, role", "logs/id_1.parquet, role", "two logs would be named 'id_1'"),
        ("logs/val_1", "logs/val_2", "no such file"),
        ("settings:", "device: device.yaml\nsettings:", "no such file"),
        ("role: validation", "role: with_device", "no device file is named"),
        ("role: validation", "role: validation, device: device.yaml", "wears no device"),
        ("settings: {", "settings: {motion_doubtful: 0.6, ", "motion_doubtful below motion_different"),
    ],
)
def test_a_study_that_cannot_be_done_says_why(rewrite: Rewrite, old: str, new: str, words: str) -> None:
    with pytest.raises(BadStudy, match=words):
        open_study(rewrite("study.yaml", old, new))


def test_motor_side_columns_need_a_gear_ratio(rewrite: Rewrite) -> None:
    columns = "{a: {channel: q.torso_yaw, unit: rad, side: motor}}"
    mapping = f"version: 1\nfiles:\n  - file: v.csv\n    rate_hz: 100\n    columns: {columns}\n"
    root = rewrite("robot.yaml", "gear_ratio: 100, ", "")
    (root / "m.yaml").write_text(mapping)
    (root / "v.csv").write_text("a\n" + "1\n" * 20)
    rewrite("study.yaml", "logs/id_1.parquet,", "v.csv, mapping: m.yaml,")
    with open_study(root) as study, pytest.raises(BadRobot, match="without gear_ratio: torso_yaw"):
        read_recordings(study)


def test_the_urdf_is_kept_as_it_was(folder: Path) -> None:
    with open_study(folder) as study:
        assert study.urdf == (folder / "robot.urdf").read_bytes()
        assert read_robot(study.bundle, "robot.yaml")[2] == study.urdf


def test_filters_lean_on_the_parts_beside_and_never_on_held_out_ones_for_the_fit(rewrite: Rewrite) -> None:
    """Three parts of one recording: fitted, fitted, held out."""
    fitted = "file: logs/id_1.parquet, rows: [0, 150], role: identification}\n  - {"
    rewrite("study.yaml", "file: logs/id_1.parquet,", fitted + "file: logs/id_1.parquet, rows: [150, 300],")
    root = rewrite("study.yaml", "file: logs/val_1.parquet,", "file: logs/id_1.parquet, rows: [300, 400],")
    with open_study(root) as study:
        first, second, held_out = (each.log.beside for each in read_recordings(study))
    assert first is not None
    assert second is not None
    assert held_out is not None
    lengths = [(len(each.before["i.torso_yaw"]), len(each.after["i.torso_yaw"])) for each in (first, second, held_out)]
    assert lengths == [(0, 150), (150, 0), (300, 0)]


FIRST = {"id_1": 0.0, "val_1": 60.0, "plain": 120.0, "other": 400.0}


def opened(path: Path, started: dict[str, float]):
    file = path if path.is_file() else path / "study.yaml"
    content = yaml.safe_load(file.read_text())
    for entry in content["logs"]:
        name = entry.get("name") or Path(entry["file"]).stem
        if name in started:
            entry["started"] = started[name]
    file.write_text(yaml.safe_dump(content))
    with open_study(path) as study:
        return study.support_settings.started, [
            each for each in study.notices if "session" in each.code or "run" in each.code
        ]


def test_a_study_that_says_when_each_log_began_and_ends_without_the_device_is_asked_for_nothing(worn: Path) -> None:
    started = FIRST | {"worn": 100.0}
    assert opened(worn, started) == (started, [])


def test_a_study_that_ends_with_the_device_is_asked_for_a_run_without_it(worn: Path) -> None:
    started, (notice,) = opened(worn, FIRST | {"worn": 300.0})
    assert len(started) == 5
    assert notice.code == "no_run_after"
    assert notice.remark is not None
    assert notice.remark.names == ("bend",)


@pytest.mark.parametrize("untold", ["id_1", "other"])
def test_one_log_without_a_start_leaves_all_unknown(worn: Path, untold: str) -> None:
    told = {name: each for name, each in (FIRST | {"worn": 300.0}).items() if name != untold}
    started, (notice,) = opened(worn, told)
    assert started == {}
    assert notice.code == "session_unknown"
    assert notice.remark is not None
    assert notice.remark.names == (untold,)
