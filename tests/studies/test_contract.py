"""Every broken rule of study.yaml and robot.yaml is told with file, line, place, value and advice."""

from __future__ import annotations

import pytest

from exogauge.errors import BadInput, BadStudy, Fault, TooLarge
from exogauge.studies.intake.contract import DeviceFile, RobotFile, StudyFile
from exogauge.studies.intake.yaml_file import MAX_BYTES, load_yaml

STUDY = """version: 1
name: Lumbar wear
robot: robot.yaml
logs:
  - {file: logs/id_1.parquet, role: identification}
  - {file: [a.csv, b.csv], mapping: m.yaml, rows: [0, 24750], role: validation}
settings: {cutoff_hz: 1e1, effects: [viscous]}
"""
ROBOT = """version: 1
urdf: robot.urdf
base: floating
base_link: BODY
imu: {parent: BODY, xyz: [0, 0, 0.1]}
ft_sensors:
  - {name: l_foot, frame: l_sole, role: contact, sees: world_on_robot}
joints:
  - {name: knee, actuation: current, gear_ratio: 100, prior: {k_T: 5}, prior_std: {k_T: 1}}
  - {name: ankle, actuation: torque}
transmission:
  joints: [knee, ankle]
  matrix: [[45, 0], [32, 32]]
noise: {q: 1e-5}
"""


def faults(data: str, model: type[StudyFile] | type[RobotFile]) -> tuple[Fault, ...]:
    with pytest.raises(BadInput) as caught:
        load_yaml(data.encode(), model, file="page.yaml")
    return caught.value.faults


def test_the_written_contract_is_accepted() -> None:
    study = load_yaml(STUDY.encode(), StudyFile, file="study.yaml")
    assert study.logs[0].file == ("logs/id_1.parquet",)
    assert study.logs[1].rows == (0, 24750)
    assert study.settings.cutoff_hz == 10.0
    robot = load_yaml(ROBOT.encode(), RobotFile, file="robot.yaml")
    assert robot.noise.q == 1e-5
    assert robot.joints[0].prior.k_T == 5.0


@pytest.mark.parametrize(("written", "meant"), [("0042", "0042"), ("42", "42"), ("12:30", "12:30"), ("'007'", "007")])
def test_a_serial_number_stays_as_it_is_written(written: str, meant: str) -> None:
    data = f"version: 1\nname: wear\nrecord: {{serial: {written}}}\nbands:\n- name: left\n  via_points:\n" + "".join(
        f"  - {{link: {link}, xyz: [0, 0, 0]}}\n" for link in ("waist", "chest")
    )
    assert load_yaml(data.encode(), DeviceFile, file="device.yaml").record.serial == meant


@pytest.mark.parametrize(
    ("old", "new", "row", "column", "words"),
    [
        ("role: validation", "role: validatoin", 6, "logs.1.role", "Did you mean 'validation'"),
        ("robot:", "robots:", 3, "robots", "Did you mean 'robot'"),
        ("role: identification}", "role: identification, rwos: [0, 9]}", 5, "logs.0.rwos", "Did you mean 'rows'"),
        ("cutoff_hz", "cutof_hz", 7, "settings.cutof_hz", "Did you mean 'cutoff_hz'"),
        ("1e1", "ten", 7, "settings.cutoff_hz", "number"),
        ("1e1", "-3", 7, "settings.cutoff_hz", "greater than 0"),
        ("1e1", ".nan", 7, "settings.cutoff_hz", "finite"),
        ("version: 1", "version: 2", 1, "version", "1"),
        ("[0, 24750]", "[5, 5]", 6, "logs.1", "start < stop"),
        ("mapping: m.yaml, ", "", 6, "logs.1", "needs a `mapping`"),
        ("logs/id_1.parquet", "../id_1.parquet", 5, "logs.0.file.0", "leaves the study's folder"),
        ("logs/id_1.parquet", "/etc/passwd", 5, "logs.0.file.0", "leaves the study's folder"),
        ("logs/id_1.parquet", "C:/id_1.parquet", 5, "logs.0.file.0", "leaves the study's folder"),
        ("robot.yaml", "sub\\robot.yaml", 3, "robot", "joined by '/'"),
        ("name: Lumbar wear", "name: Lumbar\nname: wear", 3, "name", "twice"),
        ("name: Lumbar wear", "name: 5", 2, "name", "string"),
        ("role: identification}", "role: identification", 6, None, "not readable as YAML"),
    ],
)
def test_a_broken_study_names_its_line(old: str, new: str, row: int, column: str | None, words: str) -> None:
    assert old in STUDY
    found = faults(STUDY.replace(old, new, 1), StudyFile)
    assert any((f.file, f.row, f.column) == ("page.yaml", row, column) and words in str(f) for f in found), found


@pytest.mark.parametrize(
    ("old", "new", "row", "column", "words"),
    [
        ("k_T: 5}", "kT: 5}", 9, "joints.0.prior.kT", "Did you mean 'k_T'"),
        ("prior: {k_T: 5}, ", "", 9, "joints.0", "needs prior.k_T"),
        ("prior: {k_T: 5}", "prior: {k_T: 5, tau_c: -1}", 9, "joints.0.prior.tau_c", "greater than or equal to 0"),
        ("prior_std: {k_T: 1}", "prior_std: {k_T: 0}", 9, "joints.0.prior_std.k_T", "greater than 0"),
        ("gear_ratio: 100", "gear_ratio: 0", 9, "joints.0", "cannot be 0"),
        ("actuation: torque}", "actuation: torque, prior: {k_T: 2}}", 10, "joints.1", "known"),
        (
            "actuation: torque}",
            "actuation: none, prior: {k_T: 1}}",
            10,
            "joints.1",
            "no current of this joint is logged",
        ),
        ("sees: world_on_robot", "sees: world_on_robots", 7, "ft_sensors.0.sees", "Did you mean 'world_on_robot'"),
        ("[[45, 0], [32, 32]]", "[[45, 0], [32]]", 11, "transmission", "2 x 2"),
        ("[[45, 0], [32, 32]]", "[[0, 45], [32, 32]]", 11, "transmission", "cannot be 0"),
        ("base_link: BODY\n", "", 1, None, "needs base_link"),
        ("imu: {parent: BODY, xyz: [0, 0, 0.1]}\n", "", 1, None, "needs imu"),
        ("{parent: BODY,", "{frame: imu, parent: BODY,", 5, "imu", "either"),
        ("[0, 0, 0.1]", "[0, 0]", 5, "imu.xyz.2", "missing"),
    ],
)
def test_a_broken_robot_names_its_line(old: str, new: str, row: int, column: str | None, words: str) -> None:
    assert old in ROBOT
    found = faults(ROBOT.replace(old, new, 1), RobotFile)
    assert any((f.row, f.column) == (row, column) and words in str(f) for f in found), found


def test_a_urdf_is_called_one_and_told_what_names_it() -> None:
    """«Mapping values are not allowed in this context», at its row 310."""
    found = faults('<?xml version="1.0"?>\n<robot name="arm"/>', StudyFile)
    assert [(each.rule, each.row) for each in found] == [("a_urdf", 1)]
    assert "`exogauge robot` drafts one" in found[0].advice


def test_every_fault_is_told_at_once() -> None:
    found = faults(STUDY.replace("robot:", "robots:").replace("1e1", "ten"), StudyFile)
    assert {f.column for f in found} == {"robot", "robots", "settings.cutoff_hz"}


@pytest.mark.parametrize(
    "data",
    [
        b"a: &a [x,x,x,x,x,x,x,x,x]\n"
        + b"".join(b"%c: &%c [%s]\n" % (98 + i, 98 + i, b",".join([b"*%c" % (97 + i)] * 9)) for i in range(9)),
        b"a: &a [*a]",
        b"[" * 100_000,
        b"x" * (MAX_BYTES + 1),
    ],
    ids=["alias bomb", "alias loop", "depth", "size"],
)
def test_a_bomb_is_refused_before_it_unfolds(data: bytes) -> None:
    with pytest.raises(TooLarge):
        load_yaml(data, StudyFile, file="study.yaml")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xff\xfe",
        b"- 1",
        b"!!python/object:os.system {}",
        b"2001-13-45: 1",
        b"a: \0",
        b"a: " + b"9" * 400,
        b"a: !!timestamp x",
    ],
)
def test_what_is_no_study_is_refused(data: bytes) -> None:
    with pytest.raises(BadStudy):
        load_yaml(data, StudyFile, file="study.yaml")


def test_an_alias_in_good_faith_works() -> None:
    shared = ROBOT.replace("prior: {k_T: 5}", "prior: &p {k_T: 5}").replace("torque}", "current, prior: *p}")
    assert load_yaml(shared.encode(), RobotFile, file="robot.yaml").joints[1].prior.k_T == 5.0


def test_a_device_is_checked_in_shape() -> None:
    band = "{name: A, via_points: [{link: chest, xyz: [0, 0, 1]}, {link: waist, xyz: [0, 0, 0]}]}"
    device = f"version: 1\nname: Suit\nbands: [{band}]\n"
    assert load_yaml(device.encode(), DeviceFile, file="device.yaml").bands[0].via_points[1].link == "waist"
    with pytest.raises(BadStudy, match="at least 2 items"):
        load_yaml(device.replace(", {link: waist, xyz: [0, 0, 0]}", "").encode(), DeviceFile, file="device.yaml")
