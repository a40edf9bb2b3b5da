"""One motion in the tables of other programs, and tables that are wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.motion.tables import SEGMENTS, excel, motive, mvnx, nexus, optitrack, plain, qualisys
from tests.motion.test_reading import LABELS, body
from tests.motion.test_recorded import unpacked

from exogauge.errors import BadMotion, Fault
from exogauge.motion.contacts import with_contacts
from exogauge.motion.files import open_motion
from exogauge.motion.human import Markers
from exogauge.motion.person import person_of

WRITERS = {
    "a.tsv": qualisys,
    "b.tsv": lambda points, labels: qualisys(points, labels, gap="NULL", head=False),
    "c.tsv": lambda points, labels: qualisys(points, labels, gap="0.000"),
    "d.csv": motive,
    "e.csv": lambda points, labels: motive(points, labels, unit="Meters", beside=False),
    "f.csv": nexus,
    "g.txt": lambda points, labels: nexus(points, labels, separator="\t", beside=False),
    "h.csv": lambda points, labels: nexus(points, labels, separator=";"),
    "i.csv": plain,
    "j.csv": lambda points, labels: plain(points, labels, name="{label}.{small} [mm]", unit=1e-3, clock="Time (ms)"),
    "k.csv": lambda points, labels: plain(points, labels, name='"Ann:{label}:{axis}"', clock='"t"', gap="NaN"),
    "l.tsv": lambda points, labels: plain(points, labels, name="{axis}_{label}", clock="Frame#", separator="\t",
                                          above="# rate: 100 Hz\n# unit: m"),
    "m.csv": lambda points, labels: plain(points, labels, name="{label} ({axis})", clock="timestamp", separator=";",
                                          unit=1e-3, below=";".join(["s", *["mm"] * 3 * len(labels)]), gap="NA"),
    "n.txt": lambda points, labels: plain(points, labels, name="{label}_{axis}_cm", unit=0.01, clock="# time"),
    "o.csv": lambda points, labels: plain(points, labels, clock="", above="rate,100\nunits,mm", unit=1e-3),
    "p.csv": optitrack,
    "q.csv": lambda points, labels: optitrack(points, labels, beside=False),
    "r.csv": lambda points, labels: excel(plain(points, labels), blank=3),
    "s.csv": lambda points, labels: excel(plain(points, labels, unit=1e-3, below=",".join(["s", *["mm"] * 24]))
                                          if len(labels) == 8 else plain(points, labels, unit=1e-3)),
    "t.csv": lambda points, labels: excel(nexus(points, labels)),
    "u.tsv": lambda points, labels: qualisys(points, labels).replace(".", ","),
}  # fmt: skip


def _file(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    return folder / name


def _refused(path: Path) -> Fault:
    with pytest.raises(BadMotion) as found:
        open_motion(path)
    fault = found.value.faults[0]
    assert fault.file == path.name
    assert fault.advice
    return fault


@pytest.fixture(scope="module")
def squat(tmp_path_factory: pytest.TempPathFactory) -> Markers:
    markers = open_motion(unpacked(tmp_path_factory.mktemp("captured"), "mocap_c3d/squat.c3d")).markers
    assert markers is not None
    return markers


@pytest.mark.parametrize("name", list(WRITERS))
def test_a_motion_comes_back_from_every_table(tmp_path: Path, name: str) -> None:
    there = body(40)
    there[5:9, 2] = np.nan
    there[-2:, -1] = np.nan
    motion = open_motion(_file(tmp_path, name, WRITERS[name](there, LABELS)))
    assert motion.markers is not None
    assert motion.markers.labels == LABELS
    assert motion.rate == pytest.approx(120.0 if name in ("d.csv", "e.csv", "p.csv", "q.csv") else 100.0, rel=1e-3)
    assert motion.markers.position == pytest.approx(there, abs=1e-6, nan_ok=True)


@pytest.mark.parametrize("name", list(WRITERS))
def test_what_was_recorded_is_the_same_in_every_table(squat: Markers, tmp_path: Path, name: str) -> None:
    """The markers of a C3D file, its gaps, feet and sides."""
    kept = [k for k, label in enumerate(squat.labels) if label in squat.segment]
    labels, points = tuple(squat.labels[k] for k in kept), squat.position[:600, kept]
    motion = with_contacts(open_motion(_file(tmp_path, name, WRITERS[name](points, labels))))
    assert motion.markers is not None
    assert motion.markers.segment == {label: squat.segment[label] for label in labels}
    order = [motion.markers.labels.index(label) for label in labels]
    np.testing.assert_allclose(motion.markers.position[:, order], points, rtol=0.0, atol=1e-6)
    assert motion.contacts is not None


def test_rigid_bodies_and_what_has_no_label_are_told_and_are_no_markers(tmp_path: Path) -> None:
    there = body(6)
    told = open_motion(_file(tmp_path, "a.csv", motive(there, LABELS))).told
    assert told["left_out"] == "Rigid Body Cart, Rigid Body Marker Cart:Marker1, trajectories without a name: 1"
    assert told["unit"] == "read: 0.001 m"
    assert told["up"] == "guessed: y, from the feet to the head"
    told = open_motion(_file(tmp_path, "b.csv", nexus(there, LABELS))).told
    assert told["left_out"] == "Devices, Model Outputs, trajectories without a name: 1"
    assert told["prefix"] == "Ann"


def test_what_an_old_optitrack_file_and_a_table_with_commas_are_is_told(tmp_path: Path) -> None:
    there = body(6)
    told = open_motion(_file(tmp_path, "a.csv", optitrack(there, LABELS))).told
    assert told["format"] == "Motive CSV 1.1"
    assert told["left_out"] == "rigid bodies: 2"
    assert told["unit"].startswith("guessed: m,")
    assert "decimals" not in told
    assert open_motion(_file(tmp_path, "b.csv", excel(plain(there, LABELS)))).told["decimals"] == "commas"


def _wrong() -> dict[str, tuple[str, str, tuple[str, int | None, str | None, str | None]]]:
    """By what is wrong: file's name, text, then rule, row, column, value."""
    there = body(12)
    tsv, opti, vicon = qualisys(there, LABELS), motive(there, LABELS), nexus(there, LABELS)
    cut = {name: text[: text.rindex("\n", 0, len(text) - 30)] for name, text in (("tsv", tsv), ("opti", opti))}
    names = "\t".join(LABELS)
    flat, lines = plain(there, LABELS), vicon.split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith("Trajectories"))
    second = lines[at + 6].split(",")
    people = tuple(f"{who}_{label}" for who in ("Ann", "Ben") for label in LABELS)
    two = np.concatenate([there, there + np.array([0.0, 2.0, 0.0])], axis=1)
    without = [cell if k != 4 else "" for k, cell in enumerate(second)]
    old = optitrack(there, LABELS)
    tracker = ("Objects\n100\n,,Global Angle Cart:Cart,,,,,\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ\n"
               ",,rad,rad,rad,mm,mm,mm\n1,0,0.1,0.2,0.3,100,200,300\n")  # fmt: skip
    return {
        "cut": ("a.tsv", cut["tsv"] + "\n", ("frame_count", 1, "NO_OF_FRAMES", "12")),
        "cut in motive": ("a.csv", cut["opti"] + "\n", ("frame_count", 1, "Total Exported Frames", "12")),
        "cut in a row": ("a.csv", "\n".join(lines[: at + 8])[:-60], ("row_length", at + 8, None, None)),
        "names lost": ("a.tsv", tsv.replace(f"\t{names}\n", f"\t{names[5:]}\n"),
                       ("marker_count", 11, "NO_OF_MARKERS", "8")),
        "count wrong": ("a.tsv", tsv.replace("NO_OF_MARKERS\t8", "NO_OF_MARKERS\t9"),
                        ("marker_count", 11, "NO_OF_MARKERS", "9")),
        "6D": ("a.tsv", tsv.replace("DATA_INCLUDED\t3D", "DATA_INCLUDED\t6D"),
               ("no_markers", 9, "DATA_INCLUDED", "6D")),
        "no header": ("a.tsv", tsv[tsv.index("\n1\t") + 1 :], ("unknown_format", 1, None, None)),
        "commas beside points": ("a.tsv", tsv.replace("0.01000", "0,01000"), ("not_a_number", 15, "Time", "0,01000")),
        "commas and thousands": ("a.csv", excel(plain(there, LABELS, unit=1e-3)).replace("1700,0", "1.700,0"),
                                 ("not_a_number", 2, "time", "0,000000")),
        "commas for both": ("a.csv", "\n".join([*lines[: at + 5], lines[at + 5].replace(".", ","), *lines[at + 6 :]]),
                            ("row_length", at + 6, None, None)),
        "a word": ("a.csv", opti.replace(f"{1700.0:.6f}", "seen", 1), ("not_a_number", 8, "Ann:LFHD y", "seen")),
        "infinite": ("a.csv", opti.replace(f"{1700.0:.6f}", "inf", 1), ("not_a_number", 8, "Ann:LFHD y", "inf")),
        "half a point": ("a.csv", "\n".join([*lines[: at + 6], ",".join(without), *lines[at + 7 :]]),
                         ("half_a_point", at + 7, "Ann:LFHD z", None)),
        "a frame lost": ("a.csv", "\n".join([*lines[: at + 8], *lines[at + 9 :]]),
                         ("frame_lost", at + 9, "Frame", "35")),
        "no unit": ("a.csv", motive(7.0 * there, LABELS).replace("Length Units,Millimeters", "Length Units,Furlongs"),
                    ("no_unit", None, "unit", None)),
        "mm as m": ("a.csv", opti.replace("Units,Millimeters", "Units,Meters"), ("no_body", None, "unit", "read: 1 m")),
        "m as mm": ("a.tsv", qualisys(0.001 * there, LABELS), ("no_body", None, "unit", "read: 0.001 m")),
        "two units": ("a.csv", vicon.replace("mm,mm,mm", "m,m,m", 1), ("no_unit", at + 5, None, "m, mm")),
        "two people": ("a.tsv", qualisys(two, people), ("two_people", None, "subject", None)),
        "no label": ("a.csv", nexus(there, tuple(f"*{k}" for k in range(8))), ("no_markers", None, None, "9")),
        "bodies alone": ("a.csv", opti.replace(",Marker", ",Bone"), ("no_markers", 3, None, None)),
        "no trajectories": ("a.csv", "\n".join(lines[: at - 1]), ("no_markers", None, None, "Devices")),
        "two rates": ("a.csv", opti.replace("Export Frame Rate,120", "Export Frame Rate,60"),
                      ("two_rates", 1, "Export Frame Rate", "60")),
        "no rate": ("a.tsv", qualisys(there, LABELS, head=False).replace("FREQUENCY\t100\n", "FREQUENCY\tEXT\n"),
                    ("no_rate", 4, "FREQUENCY", "0")),
        "all gaps": ("a.csv", nexus(there * np.nan, LABELS, beside=False), ("all_gaps", None, None, None)),
        "empty": ("a.csv", "", ("empty_file", None, None, None)),
        "an axis lost": ("a.csv", flat.replace("RASI_Y,", "RASI_height,", 1),
                         ("axis_missing", 1, "RASI_X", "RASI_X, RASI_Z")),
        "two axes lost": ("a.csv", flat.replace("C7_Y,C7_Z,", "a,b,", 1), ("axis_missing", 1, "C7_X", "C7_X")),
        "a label twice": ("a.csv", flat.replace("RASI_X,RASI_Y,RASI_Z", "LASI_X,LASI_Y,LASI_Z", 1),
                          ("label_twice", 1, "LASI_X", "LASI_X")),
        "no time": ("a.csv", plain(there, LABELS, clock=""), ("no_rate", 1, "time", "0")),
        "frames without a rate": ("a.csv", plain(there, LABELS, clock="frame"), ("no_rate", 1, "frame", "0")),
        "a rate of nothing": ("a.csv", plain(there, LABELS, clock="frame", above="# rate: 0"),
                              ("no_rate", 1, "rate", "0")),
        "text in a plain table": ("a.csv", flat.replace(f"{1.7:.6f}", "seen", 1),
                                  ("not_a_number", 2, "LFHD_Z", "seen")),
        "text in its time": ("a.csv", flat.replace(f"{0.02:.6f}", "10:11:12", 1),
                             ("not_a_number", 4, "time", "10:11:12")),
        "half a point of it": ("a.csv", flat.replace(f"{1.7:.6f}", "", 1), ("half_a_point", 2, "LFHD_Z", None)),
        "all gaps of it": ("a.csv", plain(there * np.nan, LABELS), ("all_gaps", None, None, None)),
        "a row cut": ("a.csv", flat[: flat.rindex(",")], ("row_length", 13, None, None)),
        "no rows": ("a.csv", flat.splitlines()[0] + "\n", ("one_frame", None, None, "0")),
        "one row": ("a.csv", plain(there[:1], LABELS), ("one_frame", None, None, "1")),
        "milliseconds as seconds": ("a.csv", plain(there, LABELS, clock="time_ms").replace("time_ms", "time", 1),
                                    ("slow_clock", None, "time", None)),
        "a row of it lost": ("a.csv", plain(there, LABELS, clock="Frame", above="# rate: 100").replace("\n6,", "\n7,"),
                             ("frame_lost", 8, "Frame", "7")),
        "two units of it": ("a.csv", plain(there, LABELS, name="{label}_{axis} [m]").replace("[m]", "[mm]", 1),
                            ("no_unit", 1, "unit", "m, mm")),
        "degrees": ("a.csv", plain(there, LABELS, below=",".join(["s", *["deg"] * 24])), ("no_unit", 2, "unit", "deg")),
        "mm as m in it": ("a.csv", plain(there, LABELS, name="{label}_{axis} [m]", unit=1e-3),
                          ("no_body", None, "unit", "read: 1 m")),
        "two people in it": ("a.csv", plain(two, people), ("two_people", None, "subject", None)),
        "left-handed": ("a.csv", old.replace("righthanded", "lefthanded"), ("left_handed", 3, None, None)),
        "version 1": ("a.csv", old.replace("info,version,1.1\n", ""), ("other_version", 8, "version", None)),
        "version 1.3": ("a.csv", old.replace("version,1.1", "version,1.3"), ("other_version", 4, "version", "1.3")),
        "a frame of it cut": ("a.csv", old[: old.rindex("frame,11,") + 200], ("row_length", 31, None, None)),
        "frames of it lost": ("a.csv", old[: old.rindex("frame,11,")], ("frame_count", 5, "framecount", "12")),
        "a name twice in it": ("a.csv", old.replace(",7,RHEE", ",7,LHEE", 1), ("label_twice", 9, None, "LHEE")),
        "no count in it": ("a.csv", old.replace("frame,3,0.02500000,2", "frame,3,0.02500000,x"),
                           ("not_a_number", 15, "count of rigid bodies", "x")),
        "objects of Tracker": ("a.csv", tracker, ("no_markers", None, None, "Objects")),
        "another table": ("a.csv", "t,q.hip\n0,0\n0.1,0\n", ("unknown_format", 1, None, "t,q.hip")),
    }  # fmt: skip


@pytest.mark.parametrize("what", list(_wrong()))
def test_a_table_that_is_wrong_is_refused_at_its_row(tmp_path: Path, what: str) -> None:
    name, text, (rule, row, column, value) = _wrong()[what]
    fault = _refused(_file(tmp_path, name, text))
    assert (fault.rule, fault.row, fault.column) == (rule, row, column)
    assert value is None or fault.value == value


def test_a_table_of_a_robot_is_refused_with_what_takes_it(tmp_path: Path) -> None:
    for joints in ("q.hip", "q.hip_X,q.hip_Y", "q.hip_X,q.hip_Y,q.hip_Z"):
        row = ",0" * (1 + joints.count(","))
        told = _refused(_file(tmp_path, "a.csv", f"t,{joints}\n0{row}\n0.1{row}\n"))
        assert "motion check" in str(told.advice)
    assert "Qualisys" in str(_refused(_file(tmp_path, "a.csv", "time,x\n0,0\n0.1,0\n")).advice)


def test_a_plain_table_may_hold_more_than_markers_in_any_order(tmp_path: Path) -> None:
    """Columns of x, y, z apart from each other; turns, speeds and events beside them are told, and are no markers."""
    there = body(9)
    columns = {"frame": np.arange(9), "event": np.zeros(9), "LFHD_vx": np.ones(9)}
    columns |= {f"Cart.rot.{axis}": np.full(9, 0.5) for axis in "xyzw"}
    for axis in (2, 0, 1):
        columns |= {f"{label}.{'xyz'[axis]}": there[:, k, axis] for k, label in enumerate(LABELS)}
    columns["time"] = np.arange(9) / 50.0
    rows = [",".join(f"{x:.9g}" for x in row) for row in np.stack(list(columns.values()), axis=1)]
    motion = open_motion(_file(tmp_path, "a.csv", "\n".join([",".join(columns), *rows])))
    assert motion.markers is not None
    assert motion.markers.labels == LABELS
    assert motion.markers.position == pytest.approx(there, abs=1e-6)
    assert motion.rate == pytest.approx(50.0)
    assert motion.told["left_out"] == "event, LFHD_vx, Cart.rot.x, Cart.rot.y, Cart.rot.z, Cart.rot.w"


def test_the_unit_of_a_plain_table_may_be_stated(tmp_path: Path) -> None:
    there = body(9)
    path = _file(tmp_path, "a.csv", plain(there, LABELS, unit=1e-3))
    for unit, said in (("mm", "stated: mm"), (None, "guessed: mm")):
        motion = open_motion(path, unit=unit)
        assert motion.told["unit"].startswith(said)
        assert motion.markers is not None
        assert motion.markers.position == pytest.approx(there, abs=1e-6)


def _bow(frames: int = 61) -> np.ndarray:
    return np.asarray(np.radians(30.0) * np.sin(np.pi * np.linspace(0.0, 1.0, frames)) ** 2)


@pytest.mark.parametrize("at_rest", [True, False])
def test_segments_of_an_mvnx_are_a_person_that_bends(tmp_path: Path, at_rest: bool) -> None:
    """Whichever way the person faces; with and without the calibration's poses."""
    motion = with_contacts(open_motion(_file(tmp_path, "a.mvnx", mvnx(_bow(), at_rest=at_rest))))
    assert motion.tree is not None
    assert motion.tree.names[0] == "Pelvis"
    assert set(motion.tree.names) == {name for name, _, _ in SEGMENTS}
    assert motion.told["preset"] == "Xsens MVN's segments"
    assert motion.told["up"] == "read: z"
    assert motion.rate == pytest.approx(60.0)
    assert motion.contacts is not None
    assert motion.contacts.left.all()
    assert motion.contacts.right.all()
    person = person_of(motion)
    flexion = np.arctan2(person.trunk[:, 0, 2], person.trunk[:, 2, 2])
    assert flexion == pytest.approx(_bow(), abs=1e-5)
    ahead = person.turn[:, :, 0]
    assert np.arctan2(ahead[:, 1], ahead[:, 0]) == pytest.approx(0.7, abs=1e-5)
    assert person.hip_height == pytest.approx(0.85)


def test_a_segment_of_an_mvnx_ends_at_its_joint_and_what_was_not_measured_is_told(tmp_path: Path) -> None:
    """Landmarks on the skin may lie farther than the joint; the legs of an upper body follow the pelvis."""
    motion = open_motion(_file(tmp_path, "a.mvnx", mvnx(_bow(), body="UpperBody")))
    assert motion.told["measured"].startswith("UpperBody")
    tree = motion.tree
    assert tree is not None
    for name, below in (("LeftUpperArm", "LeftForeArm"), ("RightLowerLeg", "RightFoot"), ("Pelvis", "L5")):
        at = tree.names.index(name), tree.names.index(below)
        assert tree.end[:, at[0]] == pytest.approx(tree.position[:, at[1]], abs=1e-5)
    assert "measured" not in open_motion(_file(tmp_path, "a.mvnx", mvnx(_bow()))).told


def test_an_mvnx_that_is_wrong_is_refused_with_its_place(tmp_path: Path) -> None:
    whole = mvnx(_bow(8))
    subject = whole[whole.index("<subject") : whole.index("</mvnx>")]
    wrong: dict[str, tuple[str, str, str | None]] = {
        "cut": (whole[: len(whole) // 2], "not_mvnx", None),
        "no XML": ("mvnx", "not_mvnx", None),
        "no frames": (whole[: whole.index("<frame ")] + "</frames></subject></mvnx>", "not_mvnx", None),
        "two people": (whole.replace("</mvnx>", subject + "</mvnx>"), "two_people", None),
        "a segment lost": (whole.replace("<segment label=\"LeftToe\"", "<sensor label=\"LeftToe\"").replace(
            "</segment></segments>", "</sensor></segments>"), "row_length", "orientation of frame 0"),
        "Euler angles": (whole.replace("<orientation>1.000000", "<orientation>9.000000"), "bad_quaternion", None),
        "NaN": (whole.replace("<position>0.000000", "<position>nan"), "not_a_number", "position of frame 0, number 1"),
        "decimal commas": (whole.replace("<position>0.0", "<position>0,0"), "not_a_number",
                           "position of frame 0, number 1"),
        "a joint lost": (whole.replace("<connector2>LeftToe/", "<connector2>Toe/"), "loose_bone", "joints"),
        "a circle": (whole.replace("<connector1>Pelvis/jL5", "<connector1>Head/jL5"), "loose_bone", "joints"),
        "no rate": (whole.replace('frameRate="60"', ""), "no_rate", "frameRate"),
        "two rates": (whole.replace('frameRate="60"', 'frameRate="240"'), "two_rates", "frameRate"),
        "millimetres": (mvnx(_bow(8), metres=0.001), "no_body", "unit"),
        "a frame lost": (whole.replace('index="3"', 'index="4"'), "frame_lost", "index of frame 4"),
    }  # fmt: skip
    for what, (text, rule, column) in wrong.items():
        fault = _refused(_file(tmp_path, "a.mvnx", text))
        assert (what, fault.rule) == (what, rule)
        assert column is None or fault.column == column


@pytest.mark.slow
def test_damaged_tables_never_end_in_a_traceback(tmp_path: Path) -> None:
    rng, faults = np.random.default_rng(7), list[Fault]()
    writers: dict[str, Callable[[], str]] = {name: lambda name=name: WRITERS[name](body(), LABELS) for name in WRITERS}  # type: ignore[misc]
    for name, text in {**{name: make() for name, make in writers.items()}, "a.mvnx": mvnx(_bow(6))}.items():
        data = text.encode()
        for _ in range(40):
            spoilt = bytearray(data)
            for at in rng.integers(0, len(data), 3):
                spoilt[at] = rng.integers(9, 127)
            cut = spoilt[: rng.integers(0, len(data))] if rng.random() < 0.5 else spoilt
            path = tmp_path / name
            path.write_bytes(bytes(cut))
            try:
                open_motion(path)
            except BadMotion as refused:
                faults += refused.faults
    assert len(faults) > 100
    assert all(fault.rule and fault.advice for fault in faults)
