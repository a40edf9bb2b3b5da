"""A column of a foreign log that holds no numbers: what to do is said by what stands in it."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.errors import BadLog
from exogauge.logs.findings import JointLimits
from exogauge.logs.mapping import read_mapped
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import TextLayout
from exogauge.logs.whole_turns import in_one_course
from exogauge.studies.import_log.column_words import JointFacts, Wearer
from exogauge.studies.import_log.log_preview import preview
from exogauge.studies.intake.mapping_file import parse_mapping

JOINTS = ("pan", "lift", "elbow", "wrist")


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("[rad]", "take the line of units out"),
        ("(N·m)", "take the line of units out"),
        ("deg/s", "take the line of units out"),
        ('"[0.1, -0.2]"', "each value of the list into a column of its own"),
        ("\"array('d', [0.1, 0.2])\"", "each value of the list into a column of its own"),
        ("2026-03-01 12:00:00.5", "in seconds"),
        ("12:00:01.250", "in seconds"),
        ("idle", "ignore it (`ignore`), or correct the cell"),
    ],
)
def test_text_in_a_column_is_told_by_what_it_looks_like(tmp_path: Path, cell: str, said: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time,a\n" + "".join(f"{k / 100},{cell}\n" for k in range(5)))
    (found,) = (each for each in preview(path, path.name, Wearer())["columns"] if each["name"] == "a")
    assert said in found["advice"]


@pytest.mark.parametrize(
    ("ending", "across"), [("npz", False), ("npz", True), ("h5", False), ("h5", True), ("parquet", False)]
)
def test_arrays_of_all_joints_are_drafted_and_read_as_they_were_written(
    tmp_path: Path, ending: str, across: bool
) -> None:
    """They were left to be named by hand; a list of names or a lone value beside them kept an archive shut."""
    rng, path = np.random.default_rng(4), tmp_path / f"log.{ending}"
    t = np.arange(300) / 100.0
    q, tau = rng.uniform(-1.0, 1.0, (300, 4)), rng.uniform(-30.0, 30.0, (300, 4))
    acc = np.tile([0.0, 0.6, 9.79], (300, 1))
    turned = {name: each.T if across else each for name, each in (("qpos", q), ("torque", tau), ("imu_acc", acc))}
    lone = {"dt": 0.01, "joint_names": np.array(JOINTS, dtype="S")}
    if ending == "npz":
        np.savez(path, t=t, **turned, **lone)
    elif ending == "parquet":
        lists = {name: list(each) for name, each in turned.items()}
        names = {"dt": np.full(300, 0.01), "joint_names": [list(JOINTS)] * 300}
        pq.write_table(pa.table({"t": t} | lists | names), path)
    else:
        with h5py.File(path, "w") as target:
            for name, values in ({"t": t} | turned | lone).items():
                target[name] = values
    worn = Wearer(tuple(JointFacts(name, -3.0, 3.0, 3.0) for name in JOINTS))
    look = preview(path, path.name, worn)
    said = look["proposal"]
    said["files"][0]["ignore"] = ["dt", "joint_names"]
    rules = parse_mapping(yaml.safe_dump(said).encode(), "mapping.yaml")
    log = read_mapped({path.name: path}, rules, joints=JOINTS, motor_from_joint=np.eye(4), name="log")
    for k, joint in enumerate(JOINTS):
        np.testing.assert_array_equal(log.channels[f"q.{joint}"], q[:, k])
        np.testing.assert_array_equal(log.channels[f"tau.{joint}"], tau[:, k])
    np.testing.assert_array_equal(log.channels["acc.z"], acc[:, 2])
    advice = {each["name"]: each["advice"] for each in look["columns"]}
    assert "q.pan, q.lift, q.elbow, q.wrist [rad]" in advice["qpos"]
    assert "`ignore`" in advice["joint_names"]
    assert not look["mapping"]["files"][0].get("arrays"), "nothing of it is sure"


def test_an_array_of_another_width_is_left_open(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", t=np.arange(50) / 100.0, qpos=np.zeros((50, 5)))
    worn = Wearer(tuple(JointFacts(name) for name in JOINTS))
    look = preview(tmp_path / "log.npz", "log.npz", worn)
    assert "arrays" not in look["proposal"]["files"][0]
    assert "`arrays`" in next(each["advice"] for each in look["columns"] if each["name"] == "qpos")


def test_an_array_of_what_was_commanded_is_told_as_such(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", t=np.arange(50) / 100.0, qpos_des=np.zeros((50, 4)))
    worn = Wearer(tuple(JointFacts(name) for name in JOINTS))
    look = preview(tmp_path / "log.npz", "log.npz", worn)
    assert "commanded" in next(each["advice"] for each in look["columns"] if each["name"] == "qpos_des")


def test_angles_told_from_0_to_360_degrees_are_drafted_and_read_as_one_course(tmp_path: Path) -> None:
    t, path = np.arange(2000) / 100.0, tmp_path / "log.csv"
    q = np.stack([np.sin((0.5 + 0.2 * k) * t) for k in range(4)], axis=1) * [2.0, 1.5, 0.3, 2.9] + [0.0, 0.2, -0.6, 0.0]
    table = np.column_stack([t, np.degrees(q) % 360.0])
    names = ",".join(["t", *(f"actuator{k + 1}.position" for k in range(4))])
    np.savetxt(path, table, delimiter=",", header=names, comments="", fmt="%.6f")
    limits = ((-np.inf, np.inf), (-2.2, 2.2), (-2.1, 2.1), (-np.inf, np.inf))
    worn = Wearer(tuple(JointFacts(name, *each, 3.0) for name, each in zip(JOINTS, limits, strict=True)))
    look = preview(path, path.name, worn)
    found = {each["name"]: each for each in look["columns"]}
    for k, joint in enumerate(JOINTS):
        suggestion = found[f"actuator{k + 1}.position"]["suggestion"]
        assert (suggestion["channel"], suggestion["unit"], suggestion["sign"]) == (f"q.{joint}", "deg", 1)
    rules = parse_mapping(yaml.safe_dump(look["proposal"]).encode(), "mapping.yaml")
    log = read_mapped({path.name: path}, rules, joints=JOINTS, motor_from_joint=np.eye(4), name="log")
    (read,) = in_one_course([log], {name: JointLimits(*each) for name, each in zip(JOINTS, limits, strict=True)})
    for k, joint in enumerate(JOINTS):
        np.testing.assert_allclose(read.channels[f"q.{joint}"], q[:, k], atol=1e-7)


@pytest.mark.parametrize(
    ("encoding", "names"),
    [
        ("cp932", ("時間[s]", "関節1_角度[rad]", "関節1_電流[A]")),
        ("gb18030", ("时间[s]", "关节1_角度[rad]", "关节1_电流[A]")),
        ("big5", ("時間[s]", "關節1_角度[rad]", "關節1_電流[A]")),
        ("cp949", ("시간[s]", "관절1_각도[rad]", "관절1_전류[A]")),
        ("cp1252", ("Zeit [s]", "Gelenk1 Winkel [°]", "Gelenk1 Strom [A]")),
    ],
)
def test_a_table_of_another_encoding_is_drafted_and_read_as_if_it_were_utf_8(tmp_path, encoding, names) -> None:
    rows = "".join(f"{k / 100:.2f},{np.sin(k / 20):.6f},{np.cos(k / 20):.6f}\n" for k in range(400))
    text = f"{','.join(names)}\n{rows}"
    found = list[dict[str, np.ndarray]]()
    for number, each in enumerate((encoding, "utf-8")):
        path = tmp_path / f"log{number}.csv"
        path.write_bytes(text.encode(each))
        draft = preview(path, path.name, Wearer())["proposal"]
        assert draft["files"][0].get("layout", {}).get("encoding") == (encoding if each == encoding else None)
        rules = parse_mapping(yaml.safe_dump(draft).encode(), "mapping.yaml")
        read = read_mapped({path.name: path}, rules, joints=("1",), motor_from_joint=np.eye(1), name="log")
        found.append(read.channels)
    assert {"q.1", "i.1"} <= set(found[0])
    for channel, values in found[1].items():
        np.testing.assert_array_equal(found[0][channel], values)


def test_a_table_whose_names_say_nothing_in_any_encoding_is_refused_with_the_encodings(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(b"\xa1\xa2,\xa3\xa4\n1,2\n3,4\n")
    with pytest.raises(BadLog) as refused:
        preview(path, path.name, Wearer())
    assert refused.value.faults[0].rule == "not_utf8"
    assert "cp932" in refused.value.faults[0].advice


def test_one_wrong_byte_in_a_row_does_not_make_it_another_encoding(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes("Zeit [s],Winkel [°]\n0,0\n1,2\n".encode() + b"2,\xff3\n3,4\n")
    with pytest.raises(BadLog) as refused:
        preview(path, path.name, Wearer())
    assert (refused.value.faults[0].rule, refused.value.faults[0].row) == ("not_utf8", 3)


def test_a_cell_that_is_no_number_is_told_as_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes("時間[s],角度[rad]\n0,0\n1,異常\n".encode("cp932"))
    table = open_table(path, path.name, TextLayout(encoding="cp932"))
    with pytest.raises(BadLog) as refused:
        table.read(table.names)
    (fault,) = refused.value.faults
    assert (fault.row, fault.column, fault.value) == (2, "角度[rad]", "異常")
