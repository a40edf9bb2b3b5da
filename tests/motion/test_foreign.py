"""What other makers' programs write: spellings that are taken, and what is noticed where a file is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.motion.captures import bow, bvh
from tests.motion.tables import motive, nexus, qualisys
from tests.motion.test_reading import AMC, ASF, BVH, LABELS, OURS, body, c3d, named, trc

from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.fit.places import place_of
from exogauge.motion.person import person_of


def refused(path: Path, skeleton: Path | None = None, up: str | None = None) -> tuple[str, int | None]:
    with pytest.raises(BadMotion) as found:
        open_motion(path, skeleton=skeleton, up=up)
    assert found.value.faults[0].advice
    return found.value.faults[0].rule, found.value.faults[0].row


def flexion(path: Path, angle: str | None = None) -> np.ndarray:
    trunk = person_of(open_motion(path, angle=angle)).trunk
    return np.degrees(np.arctan2(trunk[:, 0, 2], trunk[:, 2, 2]))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("\n{", " {"), ("JOINT", "Joint"), ("OFFSET", "Offset"), ("CHANNELS", "Channels"), ("ROOT", "root"),
        ("Frames: ", "Frames:"), ("Frames: ", "Frames:\t"), ("\n", "\r\n"), ("  ", "\t"), ("MOTION\n", "\nMOTION\n\n"),
        ("Frame Time", "\nFrame Time"), ("\n", "\r\r\n"),
    ],
)  # fmt: skip
def test_a_bvh_is_spelled_as_its_program_likes(tmp_path: Path, old: str, new: str) -> None:
    """A brace behind a name was part of the name, and small letters were no skeleton."""
    text = bvh(bow(30.0)).decode().replace("\n  {", "\n{")
    (tmp_path / "a.bvh").write_text(text.replace(old, new), newline="")
    assert flexion(tmp_path / "a.bvh") == pytest.approx(bow(30.0), abs=1e-4)


def test_a_bvh_without_a_frame_is_refused_where_it_counts_them(tmp_path: Path) -> None:
    head, _ = BVH.split("Frames: 2\n")
    (tmp_path / "a.bvh").write_text(f"{head}\nFrames: 0\nFrame Time: 0.01\n")
    assert refused(tmp_path / "a.bvh") == ("frame_count", head.count("\n") + 2)
    (tmp_path / "b.bvh").write_text(f"{head}Frames: 2\n\n")
    assert refused(tmp_path / "b.bvh") == ("not_bvh", None)


def test_channels_that_are_not_counted_are_told_at_their_bone(tmp_path: Path) -> None:
    (tmp_path / "a.bvh").write_text(BVH.replace("CHANNELS 3 Yrotation Xrotation Zrotation", "CHANNELS"))
    assert refused(tmp_path / "a.bvh") == ("channel_count", 9)


def test_a_point_of_a_c3d_that_is_there_by_a_part_is_refused_and_a_nan_is_a_gap(tmp_path: Path) -> None:
    """A marker with one coordinate spoiled was taken as seen, and moved by nothing."""
    for part, spoiled in (("x", [0]), ("z", [2]), ("all", [0, 1, 2])):
        points = 1000.0 * body()
        points[3, 2, spoiled] = np.nan
        file = c3d(tmp_path / f"{part}.c3d", points)
        data, marked = file.read_bytes(), np.array([np.nan], "<f4").tobytes()
        (tmp_path / f"{part}.c3d").write_bytes(data.replace(marked, b"\x01\x00\xa0\x7f"))  # NaN, of the signalling kind
        if part == "all":
            seen = open_motion(tmp_path / "all.c3d").markers.position
            assert np.isnan(seen[3, 2]).all()
            assert np.isfinite(seen).sum() == seen.size - 3
        else:
            assert refused(tmp_path / f"{part}.c3d") == ("half_a_point", 4)


@pytest.mark.parametrize("name", ["a.trc", "b.tsv", "c.csv", "d.csv"])
def test_a_line_that_ends_twice_is_one(tmp_path: Path, name: str) -> None:
    """As it is written where a program ends a line as Windows does, into a file that does so too."""
    made = {"a.trc": lambda: trc(tmp_path / "made.trc", body()).read_text(), "b.tsv": lambda: qualisys(body(), LABELS),
            "c.csv": lambda: motive(body(), LABELS), "d.csv": lambda: nexus(body(), LABELS)}  # fmt: skip
    text, found = made[name](), []
    for end in ("\n", "\r\r\n"):
        (tmp_path / name).write_bytes(text.replace("\n", end).encode())
        found.append(open_motion(tmp_path / name).markers.position)
    assert found[0].shape == body().shape
    assert (found[0] == found[1]).all()


def test_a_channel_that_is_neither_place_nor_turn_is_refused(tmp_path: Path) -> None:
    """A scale was read as an angle."""
    (tmp_path / "a.bvh").write_text(BVH.replace("CHANNELS 3 Yrotation", "CHANNELS 3 Yscale"))
    assert refused(tmp_path / "a.bvh") == ("bad_channel", 9)


def test_a_bvh_may_count_to_the_number_of_its_last_frame(tmp_path: Path) -> None:
    """As Rokoko writes: it was refused as joined of two, and every new export was the same. A frame fewer is cut."""
    text = bvh(bow(30.0)).decode()
    whole = len(bow(30.0))
    (tmp_path / "a.bvh").write_text(text.replace(f"Frames: {whole}", f"Frames: {whole - 1}"))
    assert flexion(tmp_path / "a.bvh") == pytest.approx(bow(30.0), abs=1e-4)
    assert "one more than Frames says" in open_motion(tmp_path / "a.bvh").told["frames"]
    assert "frames" not in open_motion(_written(tmp_path / "b.bvh", text)).told
    for other in (whole - 2, whole + 1):
        assert refused(_written(tmp_path / "c.bvh", text.replace(f"Frames: {whole}", f"Frames: {other}")))[0] == (
            "frame_count"
        )


def _written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def _in_radians(text: str, yaw: np.ndarray, ahead: np.ndarray) -> str:
    """A BVH of `captures` whose angles become radians; yaw: (T,) [deg] of the hips; ahead: (T,) [cm] of their way."""
    head, rows = text.split("Frame Time: ")
    step, *frames = rows.strip().split("\n")
    numbers = np.array([frame.split() for frame in frames], dtype=float)
    numbers[:, 5], numbers[:, 2] = yaw, ahead
    numbers[:, 3:] = np.radians(numbers[:, 3:])
    return f"{head}Frame Time: {step}\n" + "\n".join(" ".join(f"{x:.6f}" for x in row) for row in numbers) + "\n"


def test_a_bvh_in_radians_whose_angles_exceed_half_a_turn_asks(tmp_path: Path) -> None:
    """Angles from 0 to a whole turn, and a way in which somebody turns round more than once, were taken for degrees."""
    text, count = bvh(bow(30.0)).decode(), len(bow(30.0))
    nowhere = np.zeros(count)
    wrapped = np.mod(np.linspace(-20.0, 20.0, count), 360.0)
    around, way = np.linspace(0.0, 600.0, count), np.linspace(0.0, 500.0, count)
    for yaw, ahead in ((wrapped, nowhere), (around, way)):
        path = _written(tmp_path / "a.bvh", _in_radians(text, yaw, ahead))
        assert refused(path)[0] == "radians_for_degrees"
        assert flexion(path, "rad") == pytest.approx(bow(30.0), abs=1e-2)
    _written(tmp_path / "a.bvh", bvh(bow(12.0)).decode())  # in degrees, on the spot
    assert flexion(tmp_path / "a.bvh") == pytest.approx(bow(12.0), abs=1e-4)


def test_letters_with_accents_are_those_of_windows_where_they_are_no_utf_8(tmp_path: Path) -> None:
    """They became one sign for all, which no --name could say."""
    whole = trc(tmp_path / "whole.trc", body(), labels=("Schädel", *LABELS[1:])).read_text()
    for name, encoding in (("a.trc", "cp1252"), ("b.trc", "utf-8"), ("c.trc", "utf-8-sig"), ("d.trc", "utf-16")):
        (tmp_path / name).write_bytes(whole.encode(encoding))
        motion = open_motion(tmp_path / name, names={"Schädel": "HeadTop"})
        assert motion.markers is not None
        assert motion.markers.labels[0] == "HeadTop"


def both(pattern: str, limbs: tuple[str, ...], sides: tuple[str, str]) -> list[str]:
    """Names of arms and legs in the order of `captures.BONES`."""
    arms, legs = limbs[:3], limbs[3:]
    return [pattern.format(s=side, limb=limb) for part in (arms, legs) for side in sides for limb in part]


@pytest.mark.parametrize(
    ("preset", "names"),
    [
        ("SMPL", ["Pelvis", "Spine3", "Head", *both("{s}_{limb}", (
            "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle"), ("L", "R"))]),
        ("Unreal", ["pelvis", "spine_03", "head", *both("{limb}_{s}", ("upperarm", "lowerarm", "hand", "thigh", "calf",
                                                                       "foot"), ("l", "r"))]),
        ("Xsens MVN's segments", ["Pelvis", "T8", "Head", *both("{s}{limb}", (
            "UpperArm", "ForeArm", "Hand", "UpperLeg", "LowerLeg", "Foot"), ("Left", "Right"))]),
        ("VRM and Bandai Namco", ["Hips", "Chest", "Head", *both("{limb}_{s}", (
            "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot"), ("L", "R"))]),
        ("SMPL", ["pelvis", "spine3", "head", *both("{s}_{limb}", (
            "shoulder", "elbow", "wrist", "hip", "knee", "ankle"), ("left", "right"))]),
        ("Unity", ["Hips", "Chest", "Head", *both("{s}{limb}", (
            "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot"), ("Left", "Right"))]),
        ("VRoid", ["J_Bip_C_Hips", "J_Bip_C_UpperChest", "J_Bip_C_Head", *both("J_Bip_{s}_{limb}", (
            "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot"), ("L", "R"))]),
        ("Kinect", ["SpineBase", "SpineShoulder", "Head", *both("{limb}{s}", (
            "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle"), ("Left", "Right"))]),
        ("Rigify", ["spine", "spine.003", "spine.006", *both("{limb}.{s}", (
            "upper_arm", "forearm", "hand", "thigh", "shin", "foot"), ("L", "R"))]),
    ],
)  # fmt: skip
def test_skeletons_of_more_programs_are_known(tmp_path: Path, preset: str, names: list[str]) -> None:
    assert len(names) == len(OURS)
    (tmp_path / "other.bvh").write_bytes(named(names))
    assert open_motion(tmp_path / "other.bvh").told["preset"] == preset
    assert flexion(tmp_path / "other.bvh") == pytest.approx(bow(30.0), abs=1e-4)


def lying(text: str) -> str:
    """The same motion of bones whose x lies along them: with all angles zero the whole body lies along x (LAFAN1)."""
    head, motion = text.split("MOTION")
    lines, turned = head.splitlines(), np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])  # of every bone alike: y to x
    for k, line in enumerate(lines):
        if "OFFSET" in line:
            at = np.array(line.split()[1:], dtype=float)
            lines[k] = "OFFSET " + " ".join(f"{x:.6f}" for x in turned @ at)
    rows = motion.strip().splitlines()
    for k, row in enumerate(rows[2:], start=2):
        x = [float(each) for each in row.split()]
        assert x[3:6] == [0.0, 0.0, 0.0]
        x[3:6] = [90.0, 0.0, 0.0]  # about z, the root alone: x of the bones back to y
        for j in range(6, len(x), 3):
            assert x[j] == x[j + 2] == 0.0
            x[j + 1], x[j + 2] = 0.0, -x[j + 1]  # what turned about x turns about -y
        rows[k] = " ".join(f"{each:.6f}" for each in x)
    return "\n".join(lines) + "\nMOTION\n" + "\n".join(rows) + "\n"


def test_a_skeleton_whose_rest_posture_lies_is_read_by_how_the_motion_stands(tmp_path: Path) -> None:
    """LAFAN1's was refused."""
    (tmp_path / "a.bvh").write_text(lying(bvh(bow(30.0)).decode()))
    assert flexion(tmp_path / "a.bvh") == pytest.approx(bow(30.0), abs=1e-3)


@pytest.mark.parametrize("wrong", ["names", "axis"])
def test_left_and_right_exchanged_are_told_and_refused(tmp_path: Path, wrong: str) -> None:
    """Such a skeleton bent backwards, and nothing was said."""
    text = bvh(bow(30.0)).decode()
    if wrong == "names":
        text = text.replace("Left", "?").replace("Right", "Left").replace("?", "Right")
    else:
        lines = text.splitlines()
        for k, line in enumerate(lines):
            if "OFFSET" in line:
                x, *rest = line.split()[1:]
                lines[k] = " ".join(["OFFSET", str(-float(x)), *rest])
        text = "\n".join(lines)
    (tmp_path / "a.bvh").write_text(text)
    motion = open_motion(tmp_path / "a.bvh")
    assert "exchanged" in motion.told["sides_doubt"]
    with pytest.raises(BadMotion) as found:
        person_of(motion)
    assert found.value.faults[0].rule == "mirrored"
    whole = bvh(bow(30.0)).decode()
    heel = "JOINT {}Heel\n{{\nOFFSET 0 -6 -7\nCHANNELS 0\n}}\nJOINT {}Toe\n{{\nOFFSET 0 -8 15\nCHANNELS 0\n}}\n"
    for side in ("Left", "Right"):
        before, foot, after = whole.partition(f"JOINT {side}Foot")
        begin, end = after.index("End Site"), after.index("}", after.index("End Site")) + 2
        whole = before + foot + after[:begin] + heel.format(side, side) + after[end:]
    for right in (bvh(bow(30.0)).decode(), whole):  # a heel may come before the toes
        (tmp_path / "a.bvh").write_text(right)
        assert "sides_doubt" not in open_motion(tmp_path / "a.bvh").told


def test_a_file_that_says_another_axis_than_the_body_stands_along_asks(tmp_path: Path) -> None:
    """Y_SCREEN of a file with z up: the person lay on the floor, and nothing was said."""
    path = c3d(tmp_path / "a.c3d", 1000 * body())
    data = path.read_bytes()
    assert open_motion(path).told["up"].startswith("guessed: z")
    for said in ("+Y", "-Z"):
        import ezc3d

        file = ezc3d.c3d(str(path))
        file.add_parameter("POINT", "Y_SCREEN", [said])
        file.write(str(tmp_path / "said.c3d"))
        assert refused(tmp_path / "said.c3d")[0] == "other_up"
        motion = open_motion(tmp_path / "said.c3d", up="z")
        assert motion.markers is not None
        assert motion.markers.position == pytest.approx(body(), abs=1e-6)
    assert data == path.read_bytes()


def test_a_c3d_whose_header_leaves_counts_out_is_read_by_its_parameters(tmp_path: Path) -> None:
    """Without the number of parameter blocks no label was read."""
    path = c3d(tmp_path / "a.c3d", 1000 * body())
    data = bytearray(path.read_bytes())
    data[512 * (data[0] - 1) + 2] = 0
    data[20:24] = bytes(4)  # frame rate; POINT:RATE has it
    path.write_bytes(data)
    motion = open_motion(path)
    assert motion.markers is not None
    assert (motion.markers.labels, motion.rate) == (LABELS, pytest.approx(100.0))


def test_a_trc_is_spelled_as_its_program_likes(tmp_path: Path) -> None:
    gone = body()
    gone[3:5, -1] = np.nan
    path = trc(tmp_path / "a.trc", gone)
    lines = path.read_text().split("\n")
    for text in (
        "\n".join(line.rstrip("\t") for line in lines),  # empty fields taken off the ends of lines
        "\n".join(lines[:4] + lines[6:]),  # neither X1 Y1 Z1 nor an empty line
        "\n".join(line + "\t" for line in lines[:-1]) + "\n", "\r".join(lines), "\r\n".join(lines),
    ):  # fmt: skip
        path.write_text(text, newline="")
        markers = open_motion(path).markers
        assert markers is not None
        assert markers.position == pytest.approx(gone, nan_ok=True)
    path.write_text("\n".join(lines), encoding="utf-16")
    assert open_motion(path).markers is not None


def test_a_unit_of_markers_that_nobody_knows_is_doubted(tmp_path: Path) -> None:
    """Metres that are said to be millimetres: a person of two millimetres, and nothing was said."""
    nobody = tuple(f"m{k}" for k in range(len(LABELS)))
    for scale, doubt in ((1.0, True), (1000.0, False), (1e6, True)):
        motion = open_motion(c3d(tmp_path / "a.c3d", scale * body(), nobody), up="z")
        assert ("unit_doubt" in motion.told) == doubt


def test_times_to_the_millisecond_are_even(tmp_path: Path) -> None:
    """Of 250 Hz they were refused; a frame that is lost is so all the same."""
    path = trc(tmp_path / "a.trc", body(40), rate=256.0)
    lines = path.read_text().split("\n")
    for k in range(6, len(lines) - 1):
        frame, time, rest = lines[k].split("\t", 2)
        lines[k] = "\t".join([frame, f"{float(time):.3f}", rest])
    path.write_text("\n".join(lines))
    assert open_motion(path).rate == pytest.approx(256.0, rel=0.01)
    path.write_text("\n".join([*lines[:2], lines[2].replace("\t40\t", "\t39\t"), *lines[3:20], *lines[21:]]))
    assert refused(path)[0] == "uneven_time"


def test_a_time_that_does_not_run_is_told_at_its_row_of_the_file(tmp_path: Path) -> None:
    """It was counted in frames: rows of the header were left out."""
    path = trc(tmp_path / "a.trc", body(40))
    lines = path.read_text().split("\n")
    rows = [lines[:6], lines[6:26], [line.replace("\t0.", "\t5.", 1) for line in lines[26:27]], lines[27:]]
    path.write_text("\n".join(line for part in rows for line in part))
    with pytest.raises(BadMotion) as found:
        open_motion(path)
    fault = found.value.faults[0]
    assert (fault.rule, fault.row, fault.value) == ("uneven_time", 27, "5.2")
    (tmp_path / "a.mot").write_text("inDegrees=yes\n\nendheader\ntime\thip\n0\t1\n0.01\t2\n0.05\t3\n0.06\t40\n")
    with pytest.raises(BadMotion) as found:
        open_motion(tmp_path / "a.mot")
    assert found.value.faults[0].rule == "uneven_time"
    assert (tmp_path / "a.mot").read_text().split("\n")[(found.value.faults[0].row or 0) - 1].startswith("0.0")


def test_frames_that_are_all_the_same_are_told(tmp_path: Path) -> None:
    """A table of one frame written many times: a body of it fits to nothing."""
    there = body(20)
    assert open_motion(trc(tmp_path / "a.trc", np.repeat(there[:1], 20, axis=0))).told["still"]
    assert "still" not in open_motion(trc(tmp_path / "b.trc", there)).told
    for rows, still in (("0\t4\n0.1\t4\n", True), ("0\t4\n0.1\t5\n", False)):
        (tmp_path / "a.mot").write_text(f"inDegrees=yes\nendheader\ntime\thip\n{rows}")
        assert ("still" in open_motion(tmp_path / "a.mot").told) == still


def test_a_unit_that_nothing_tells_is_asked_for_without_a_height(tmp_path: Path) -> None:
    trunk = ("C7", "LASI", "RASI")
    path = trc(tmp_path / "a.trc", body()[:, [2, 3, 4]], labels=trunk, unit="furlong")
    with pytest.raises(BadMotion) as found:
        open_motion(path, up="z")
    fault = found.value.faults[0]
    assert (fault.rule, fault.value) == ("no_unit", None)
    assert "feet and head" in str(fault)


def test_a_header_of_a_trc_may_leave_a_cell_empty(tmp_path: Path) -> None:
    """What followed moved up: the unit was the number of markers."""
    path = trc(tmp_path / "a.trc", 1000 * body(), "mm")
    lines = path.read_text().split("\n")
    path.write_text("\n".join([*lines[:2], lines[2].replace("100.0\t100.0", "100.0\t"), *lines[3:]]))
    assert open_motion(path).told["unit"] == "read: 0.001 m"


def test_a_frame_of_milliseconds_is_noticed(tmp_path: Path) -> None:
    """Two seconds became half an hour."""
    (tmp_path / "a.bvh").write_text(bvh(bow()).decode().replace("Frame Time: 0.016666666667", "Frame Time: 16.67"))
    assert refused(tmp_path / "a.bvh") == ("slow_clock", None)


def test_milliseconds_in_a_trc_are_noticed(tmp_path: Path) -> None:
    """The motion was a thousand times slower, and nothing was said."""
    path = trc(tmp_path / "a.trc", body())
    lines = path.read_text().split("\n")
    for k in range(6, len(lines) - 1):
        frame, time, rest = lines[k].split("\t", 2)
        lines[k] = "\t".join([frame, str(1000 * float(time)), rest])
    path.write_text("\n".join(lines))
    assert refused(path) == ("two_rates", 3)


IOR = ("L_HEAD", "R_HEAD", "CV7", "L_IAS", "R_IAS", "L_FLE", "L_FCC", "R_FCC")
GAIT = ("Top.Head", "Sternum", "R.Acromium", "L.ASIS", "R.ASIS", "L.Knee.Lat", "L.Heel", "R.Heel")
CORTEX = ("Front.Head", "Rear.Head", "R.Shoulder", "L.ASIS", "R.ASIS", "L.Knee", "L.Heel", "R.Heel")
SEEN = ("LHip", "RHip", "Hip", "LShoulder", "RShoulder", "Neck", "Head", "Nose", "LElbow", "LWrist", "LKnee", "RKnee",
        "LAnkle", "RAnkle", "LHeel", "RHeel", "LBigToe", "RBigToe", "LSmallToe", "RSmallToe")  # fmt: skip
AT = np.array([
    [0, 0.09, 0.9], [0, -0.09, 0.9], [0, 0, 0.9], [0, 0.18, 1.4], [0, -0.18, 1.4], [0, 0, 1.45], [0, 0, 1.7],
    [0.1, 0, 1.6], [0, 0.2, 1.1], [0, 0.2, 0.85], [0, 0.09, 0.48], [0, -0.09, 0.48], [0, 0.09, 0.08], [0, -0.09, 0.08],
    [-0.06, 0.09, 0.03], [-0.06, -0.09, 0.03], [0.18, 0.08, 0.02], [0.18, -0.08, 0.02], [0.12, 0.14, 0.02],
    [0.12, -0.14, 0.02],
])  # fmt: skip
INFERRED = ("L_shoulder_study", "r_shoulder_study", "C7_study", "L.ASIS_study", "r.ASIS_study", "L_knee_study",
            "L_calc_study", "r_calc_study")  # fmt: skip


def test_joints_seen_in_videos_are_known_and_their_sides(tmp_path: Path) -> None:
    """Pose2Sim's TRC of HALPE_26: a hip was a marker on the thigh, and everything but the heels unknown."""
    there = np.repeat(AT[None], 12, axis=0)
    motion = open_motion(trc(tmp_path / "a.trc", there, labels=SEEN))
    assert motion.markers is not None
    assert motion.told["preset"] == "OpenPose and Pose2Sim"
    assert motion.told["up"].startswith("guessed: z")
    assert not {"unknown", "sides_doubt"} & motion.told.keys()
    assert {motion.markers.segment[name] for name in ("LHip", "RHip", "Hip")} == {"pelvis"}
    assert motion.markers.segment["RKnee"] == "r_thigh"
    assert "sides_doubt" in open_motion(trc(tmp_path / "b.trc", there * [1, -1, 1], labels=SEEN)).told
    with pytest.raises(BadMotion) as refused:
        fit_human(motion)
    fault = refused.value.faults[0]
    assert fault.rule == "too_few_markers"
    assert "how it tilts" in str(fault.advice)


def test_markers_that_pose2sim_augments_are_what_counts_beside_its_joints(tmp_path: Path) -> None:
    heights = {"_shoulder": 1.4, ".ASIS": 1.0, ".PSIS": 1.0, "_knee": 0.5, "_mknee": 0.5, "_ankle": 0.1, "_mankle": 0.1,
               "_calc": 0.03, "_toe": 0.03, "_5meta": 0.03, "_lelbow": 1.1, "_melbow": 1.1, "_lwrist": 0.9}  # fmt: skip
    augmented = tuple(f"{side}{part}_study" for side in "rL" for part in heights)
    places = np.array([[0.0, aside, high] for aside in (-0.1, 0.1) for high in heights.values()])
    there = np.repeat(np.concatenate([AT, places])[None], 12, axis=0)
    motion = open_motion(trc(tmp_path / "a.trc", there, labels=(*SEEN, *augmented)))
    assert motion.markers is not None
    assert motion.told["preset"] == "OpenCap and OpenSim"
    assert set(augmented) <= set(motion.markers.segment)


def test_what_opencap_infers_sits_where_its_markers_do() -> None:
    for inferred, marker in (("r.ASIS_study", "r.ASIS"), ("L_mknee_study", "L_mknee"), ("RHJC_study", "R_HJC"),
                             ("r_lelbow_study", "R_elbow_lat"), ("r_melbow_study", "R_elbow_med")):  # fmt: skip
        assert place_of(inferred) == place_of(marker) is not None


@pytest.mark.parametrize(
    ("preset", "labels"),
    [
        ("Visual3D and IOR", IOR), ("OpenSim's gait models", GAIT), ("OpenSim's gait models", CORTEX),
        ("OpenCap and OpenSim", INFERRED),
    ],
)  # fmt: skip
def test_markers_of_more_sets_are_known(tmp_path: Path, preset: str, labels: tuple[str, ...]) -> None:
    """L_ and R_ of IOR's names were two people."""
    motion = open_motion(trc(tmp_path / "a.trc", body(), labels=labels))
    assert motion.told["preset"] == preset
    assert motion.markers is not None
    assert set(motion.markers.segment) == set(labels)


def test_a_mot_in_radians_that_says_degrees_asks(tmp_path: Path) -> None:
    rows = "".join(f"{k / 100}\t{0.1 * k}\t0.9\n" for k in range(8))
    path = tmp_path / "a.mot"
    path.write_text(f"inDegrees=yes\nendheader\n\ntime\thip_flexion_r\tpelvis_ty\n{rows}")
    assert refused(path) == ("radians_for_degrees", None)
    stated = open_motion(path, angle="rad").angles
    assert stated is not None
    assert stated.value[7] == pytest.approx([0.7, 0.9])


def test_a_table_of_states_holds_coordinates_beside_speeds(tmp_path: Path) -> None:
    """Speeds were coordinates, and a pelvis moved by radians."""
    names = ["/jointset/ground_pelvis/pelvis_ty", "/jointset/hip_r/hip_flexion_r"]
    head = "\t".join(f"{name}/{what}" for name in names for what in ("value", "speed"))
    rows = "".join(f"{k / 100}\t0.9\t0\t{10 * k}\t1000\n" for k in range(8))
    (tmp_path / "a.sto").write_text(f"inDegrees=yes\nendheader\ntime\t{head}\t/forceset/soleus/activation\n"
                                    + rows.replace("\n", "\t0.1\n"))  # fmt: skip
    motion = open_motion(tmp_path / "a.sto")
    assert motion.angles is not None
    assert motion.angles.names == ("pelvis_ty", "hip_flexion_r")
    assert motion.angles.value[7] == pytest.approx([0.9, np.radians(70.0)])
    assert "speed" in motion.told["left_out"]


@pytest.mark.parametrize(
    ("head", "column", "rule"),
    [
        ("Speeds", "hip_flexion_r", "no_coordinates"), ("Accelerations", "hip_flexion_r", "no_coordinates"),
        ("PositionErrors", "hip_flexion_r", "no_coordinates"), ("Static Optimization", "soleus_r", "no_coordinates"),
        ("NormalizedFiberLength", "soleus_r", "no_coordinates"), ("MomentArm_hip_flexion_r", "soleus_r",
                                                                  "no_coordinates"),
        ("Model Marker Errors from IK", "total_squared_error", "no_coordinates"),
        ("Model Marker Locations from IK", "RASI_tx", "no_coordinates"),
        ("Inverse Dynamics Generalized Forces", "hip_flexion_r_moment", "no_coordinates"),
        ("trial 3", "hip_flexion_r_moment", "forces"), ("walk", "pelvis_Ox", "no_coordinates"),
        ("DataType=Quaternion", "pelvis_imu", "no_coordinates"), ("DataType=Vec3", "RASI", "no_coordinates"),
    ],
)  # fmt: skip
def test_a_table_of_opensim_that_holds_no_coordinates_is_refused(
    tmp_path: Path, head: str, column: str, rule: str
) -> None:
    """Speeds, errors, muscles and places have the form of coordinates, some their names, and were taken for angles."""
    rows = "".join(f"{k / 100}\t{9.0 * k}\n" for k in range(8))
    if head.startswith("DataType"):
        rows = "".join(f"{k / 100}\t1,0,0\n" for k in range(8))
    text = f"{head}\nversion=1\nnRows=8\nnColumns=2\ninDegrees=yes\n\nendheader\ntime\t{column}\n{rows}"
    assert refused(_written(tmp_path / "a.sto", text))[0] == rule
    for title in ("Coordinates", "speed walk 2", "controls_07"):
        fine = text.replace(head, title, 1).replace(f"\t{column}", "\thip_flexion_r").replace("1,0,0", "9")
        assert open_motion(_written(tmp_path / "b.sto", fine)).angles is not None


@pytest.mark.parametrize(
    ("line", "rule", "key"),
    [("nColumns=3", "column_count", "nColumns"), ("datacolumns 3", "column_count", "datacolumns"),
     ("nRows=7", "frame_count", "nRows")],
)  # fmt: skip
def test_counts_of_a_header_that_differ_from_the_table_are_refused_at_their_row(
    tmp_path: Path, line: str, rule: str, key: str
) -> None:
    """A table that had lost a column was taken: nobody compared nColumns."""
    rows = "".join(f"{k / 100}\t{9.0 * k}\n" for k in range(8))
    text = f"Coordinates\nversion=1\n{line}\ninDegrees=yes\n\nendheader\ntime\thip_flexion_r\n{rows}"
    with pytest.raises(BadMotion) as found:
        open_motion(_written(tmp_path / "a.mot", text))
    [fault] = found.value.faults
    assert (fault.rule, fault.row, fault.column) == (rule, 3, key)
    fine = text.replace("columns 3", "columns 2").replace("Columns=3", "Columns=2").replace("Rows=7", "Rows=8")
    assert open_motion(_written(tmp_path / "b.mot", fine)).angles is not None


@pytest.mark.parametrize(
    ("asf", "amc", "rule"),
    [
        (ASF.replace("order TX", "axis ZYX\n  order TX"), AMC, "bad_axis"),
        (ASF.replace("order TX", "orientation 0 90 0\n  order TX"), AMC, "bad_axis"),
        (ASF.replace("dof rx", "dof tx"), AMC, "limb_moves"),
        (ASF.replace("length 1.0", "length"), AMC, "not_a_number"),
        (ASF, AMC.replace("thorax 90", "thorax 1.57"), "radians_for_degrees"),
        (ASF.replace("length 1.0", "length 0.1"), AMC, "no_body"),
    ],
)
def test_what_an_amc_says_wrong_is_noticed(tmp_path: Path, asf: str, amc: str, rule: str) -> None:
    (tmp_path / "a.asf").write_text(asf)
    (tmp_path / "a.amc").write_text(amc)
    assert refused(tmp_path / "a.amc", tmp_path / "a.asf", "y")[0] == rule


def test_an_amc_that_was_cut_out_of_a_longer_one_begins_where_it_does(tmp_path: Path) -> None:
    (tmp_path / "a.asf").write_text(ASF)
    (tmp_path / "a.amc").write_text(AMC.replace("\n1\n", "\n100\n").replace("\n2\n", "\n101\n"))
    assert len(open_motion(tmp_path / "a.amc", skeleton=tmp_path / "a.asf", up="y").time) == 2


@pytest.mark.parametrize(
    ("name", "advice"), [("a.mvn", "MVNX"), ("a.csv", "C3D"), ("a.fbx", "BVH"), ("a.gz", "Unpack")]
)
def test_what_is_not_read_is_refused_with_what_its_program_can_export(tmp_path: Path, name: str, advice: str) -> None:
    (tmp_path / name).write_bytes(b"anything")
    with pytest.raises(BadMotion) as found:
        open_motion(tmp_path / name)
    assert found.value.faults[0].rule == "unknown_format"
    assert advice in (found.value.faults[0].advice or "")


@pytest.mark.parametrize("name", ["a.c3d", "a.trc", "a.csv", "a.bvh", "a.mot", "a.mvnx"])
def test_what_was_fetched_in_place_of_a_capture_is_told(tmp_path: Path, name: str) -> None:
    for text, what in (("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "Git LFS"),
                       ("\n<!DOCTYPE html><html></html>", "web page")):  # fmt: skip
        (tmp_path / name).write_text(text)
        with pytest.raises(BadMotion, match=what) as refused:
            open_motion(tmp_path / name)
        assert refused.value.faults[0].rule == "stands_in"


def test_a_skeleton_that_is_not_there_is_told(tmp_path: Path) -> None:
    """A traceback."""
    (tmp_path / "a.amc").write_text(AMC)
    for skeleton, what in ((tmp_path / "lost.asf", "no such file"), (tmp_path, "is a folder")):
        with pytest.raises(BadMotion, match=what) as refused:
            open_motion(tmp_path / "a.amc", skeleton=skeleton)
        assert refused.value.faults[0].file == skeleton.name


def test_a_folder_is_answered_with_what_it_holds(tmp_path: Path) -> None:
    """It was said not to be there."""
    with pytest.raises(BadMotion, match=r"Name a file; it holds no \.c3d"):
        open_motion(tmp_path)
    (tmp_path / "a.amc").write_text(AMC)
    with pytest.raises(BadMotion, match=r"Name a file in it: a\.amc") as refused:
        open_motion(tmp_path)
    assert (refused.value.faults[0].rule, refused.value.faults[0].file) == ("a_folder", tmp_path.name)


def test_two_people_with_the_same_labels_are_told(tmp_path: Path) -> None:
    """«Which way is up is neither said nor seen» was all that was said."""
    both = np.concatenate([body(), body() + np.array([0.0, 2.0, 0.0])], axis=1)
    with pytest.raises(BadMotion, match="two people") as refused:
        open_motion(trc(tmp_path / "a.trc", both, labels=LABELS * 2))
    assert refused.value.faults[0].rule == "two_people"


def test_a_person_who_is_not_in_the_file_is_told(tmp_path: Path) -> None:
    """Whoever was there was read in their place."""
    for labels, there in ((LABELS, "no prefixes"), (tuple(f"Ann:{label}" for label in LABELS), "There is Ann")):
        with pytest.raises(BadMotion, match=there) as refused:
            open_motion(trc(tmp_path / "a.trc", body(), labels=labels), subject="Ben")
        assert refused.value.faults[0].rule == "no_subject"


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        ("CHANNELS 3 Yrotation Xrotation", "CHANNELS 3 Xrotation Xrotation", "bad_channel"),
        ("    OFFSET 0 30 0\n    CHANNELS 3 Y", "    CHANNELS 3 Y", "bad_offset"),
        ("    }\n  }\n  JOINT LeftFoot", "    }\n  JOINT LeftFoot", "not_bvh"),
        ("}\nMOTION", "MOTION", "not_bvh"),
    ],
)  # fmt: skip
def test_a_bvh_that_would_be_another_body_is_refused(tmp_path: Path, old: str, new: str, rule: str) -> None:
    """Each was read in silence: a turn lost, a bone without length, a foot on the head."""
    assert BVH.count(old) == 1
    (tmp_path / "a.bvh").write_text(BVH.replace(old, new))
    with pytest.raises(BadMotion) as refused:
        open_motion(tmp_path / "a.bvh", up="y", unit="cm")
    assert refused.value.faults[0].rule == rule


def test_a_coordinate_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    rows = "\n".join(f"{t / 10:.1f}\t{10.0 * t}\t{5.0 * t}" for t in range(9))
    (tmp_path / "a.mot").write_text(f"Coordinates\ninDegrees=yes\nendheader\ntime\tknee\tknee\n{rows}\n")
    with pytest.raises(BadMotion, match="two columns have one name"):
        open_motion(tmp_path / "a.mot")
