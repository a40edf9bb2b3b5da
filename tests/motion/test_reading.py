"""Files made here, whose truth is known, and files that are wrong."""

from __future__ import annotations

import json
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from tests.motion.captures import BONES, bow, bvh

from exogauge.cli import main
from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.person import person_of
from exogauge.motion.presets import PRESETS

LABELS = ("LFHD", "RFHD", "C7", "LASI", "RASI", "LKNE", "LHEE", "RHEE")
STANDING = np.array([
    [0.1, 0.1, 1.7], [0.1, -0.1, 1.7], [-0.1, 0, 1.5], [0.1, 0.1, 1.0], [0.1, -0.1, 1.0], [0, 0.1, 0.5],
    [-0.1, 0.1, 0.1], [-0.1, -0.1, 0.1],
])  # fmt: skip
TURNS = {  # of a body that stands along z, into the axes of a file
    "x": np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "y": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    "z": np.eye(3),
    "-y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
}


def body(frames: int = 12) -> np.ndarray:
    """(T, M, 3) [m], z up: a body that walks slowly along x."""
    return STANDING + np.linspace(0.0, 0.2, frames)[:, None, None] * np.array([1.0, 0.0, 0.0])


def trc(path: Path, points: np.ndarray, unit: str = "m", labels: tuple[str, ...] = LABELS, rate: float = 100.0) -> Path:
    head = ["PathFileType\t4\t(X/Y/Z)\tmade.trc", "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
            f"{rate}\t{rate}\t{len(points)}\t{len(labels)}\t{unit}",
            "Frame#\tTime\t" + "\t\t\t".join(labels) + "\t\t", "\t\t" + "\t".join("XYZ" * len(labels)), ""]  # fmt: skip
    rows = [
        "\t".join([str(t + 1), f"{t / rate:.6f}", *("" if np.isnan(x) else repr(float(x)) for x in row.ravel())])
        for t, row in enumerate(points)
    ]
    path.write_text("\n".join([*head, *rows]) + "\n")
    return path


def c3d(path: Path, points: np.ndarray, labels: tuple[str, ...] = LABELS) -> Path:
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    file["data"]["points"] = np.concatenate([np.moveaxis(points, 2, 0), np.ones((1, *points.shape[:2]))]).transpose(
        0, 2, 1
    )
    file.write(str(path))
    return path


BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine2
  {
    OFFSET 0 30 0
    CHANNELS 3 Yrotation Xrotation Zrotation
    JOINT Head
    {
      OFFSET 0 30 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 20 0
      }
    }
  }
  JOINT LeftFoot
  {
    OFFSET 10 -95 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 0 15
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.01
0 100 0 0 0 0 0 0 0 0 0 0 0 0 0
0 100 0 0 90 0 0 90 0 0 0 0 0 0 0
"""
ASF = """:units
  length 1.0
  angle deg
:root
  order TX TY TZ RX RY RZ
:bonedata
  begin
    name thorax
    direction 0 1 0
    length 20
    axis 0 0 0 XYZ
    dof rx
  end
  begin
    name head
    direction 0 1 0
    length 10
    axis 0 0 0 XYZ
  end
  begin
    name lfoot
    direction 0 -1 0
    length 36
    axis 0 90 0 XYZ
    dof rz
  end
:hierarchy
  begin
    root thorax lfoot
    thorax head
  end
"""
AMC = ":DEGREES\n1\nroot 0 40 0 0 0 0\nthorax 0\nlfoot 0\n2\nroot 0 40 0 0 0 0\nthorax 90\nlfoot 0\n"


@pytest.mark.parametrize("unit", ["m", "mm", "cm"])
@pytest.mark.parametrize("up", list(TURNS))
def test_every_axis_and_unit_comes_back_upright_in_metres(tmp_path, up, unit) -> None:
    scale = {"m": 1.0, "mm": 1000.0, "cm": 100.0}[unit]
    motion = open_motion(trc(tmp_path / "a.trc", body() @ TURNS[up].T * scale, unit))
    assert motion.told["up"].startswith(f"guessed: {up},")
    got, want = motion.markers.position, body()
    assert got[..., 2] == pytest.approx(want[..., 2])
    between = [np.linalg.norm(x[:, :, None] - x[:, None], axis=3) for x in (got, want)]
    assert between[0] == pytest.approx(between[1])
    left = [np.cross(x[0, 0] - x[0, 2], x[0, 1] - x[0, 2])[2] for x in (got, want)]
    assert left[0] == pytest.approx(left[1])  # not mirrored


def test_c3d_and_trc_of_one_motion_agree(tmp_path) -> None:
    there, gone = body(), body()
    gone[3:5, 2] = np.nan
    first = open_motion(trc(tmp_path / "a.trc", gone, "m")).markers
    second = open_motion(c3d(tmp_path / "a.c3d", 1000 * gone)).markers
    assert first.labels == second.labels == LABELS
    assert np.array_equal(np.isnan(first.position), np.isnan(gone))
    assert np.array_equal(np.isnan(second.position), np.isnan(gone))
    assert np.nanmax(np.abs(first.position - there)) < 1e-9
    assert np.nanmax(np.abs(second.position - there)) < 1e-6
    assert first.segment["LKNE"] == "l_thigh"


def test_bones_of_a_bvh_turn_in_the_order_of_their_channels(tmp_path) -> None:
    (tmp_path / "a.bvh").write_text(BVH)
    motion = open_motion(tmp_path / "a.bvh", up="y")
    assert motion.told["unit"].startswith("guessed: cm")
    tree = motion.tree
    head, spine = tree.names.index("Head"), tree.names.index("Spine2")
    first = tree.rotation[0, 0].T @ (tree.end[0, head] - tree.position[0, 0])
    assert first == pytest.approx([0, 0.8, 0])
    # in frame 2 the root turns by 90° about its x, and the spine once more: what stood up hangs down behind it
    bent = tree.end[1, head] - tree.position[1, spine]
    assert bent[2] == pytest.approx(-0.5)
    assert np.linalg.norm(tree.position[1, spine] - tree.position[1, 0]) == pytest.approx(0.3)
    assert tree.position[0, 0, 2] == pytest.approx(1.0)


@pytest.mark.parametrize("way", ["whole", "added", "as described"])
def test_a_limb_that_moves_in_its_parent_is_where_the_file_says(tmp_path, way: str) -> None:
    """Position channels of the foot, as programs write them: the place in the parent, or what is added to OFFSET."""
    six = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
    head, _, rest = BVH.partition("JOINT LeftFoot")
    text = head + "JOINT LeftFoot" + rest.replace("CHANNELS 3 Zrotation Xrotation Yrotation", six, 1)
    there = {"whole": ("10 -95 0", "10 -95 3"), "added": ("0 0 0", "0 0 3"), "as described": ("10 -95 0", "10 -95 0")}
    first, second = text.rsplit("\n", 3)[1:3]
    numbers = [" ".join([*row.split()[:12], place, *row.split()[12:]]) for row, place in
               zip((first, second), there[way], strict=True)]  # fmt: skip
    (tmp_path / "a.bvh").write_text(text.rsplit("\n", 3)[0] + "\n" + "\n".join(numbers) + "\n")
    motion = open_motion(tmp_path / "a.bvh", up="y")
    tree, foot = motion.tree, motion.tree.names.index("LeftFoot")
    in_root = np.einsum("tba,tb->ta", tree.rotation[:, 0], tree.position[:, foot] - tree.position[:, 0])
    moved = 0.0 if way == "as described" else 0.03
    assert in_root == pytest.approx(np.array([[0.1, -0.95, 0.0], [0.1, -0.95, moved]]), abs=1e-9)
    assert ("limb_positions" in motion.told) == bool(moved)
    if moved:
        assert "LeftFoot is up to 3 off" in motion.told["limb_positions"]


def test_bones_of_an_amc_turn_about_their_own_axes(tmp_path) -> None:
    (tmp_path / "a.asf").write_text(ASF)
    (tmp_path / "a.amc").write_text(AMC)
    tree = open_motion(tmp_path / "a.amc", skeleton=tmp_path / "a.asf", up="y").tree
    head = tree.names.index("head")
    assert tree.end[0, head, 2] == pytest.approx(0.0254 * 70)
    assert tree.end[1, head, 2] == pytest.approx(0.0254 * 40)
    assert np.linalg.norm(tree.end[1, head] - tree.position[1, 0]) == pytest.approx(0.0254 * 30)


def test_turns_of_an_amc_are_in_the_unit_of_its_own_head(tmp_path) -> None:
    """It was read in that of the ASF: radians as degrees."""
    (tmp_path / "a.asf").write_text(ASF)
    (tmp_path / "a.amc").write_text(AMC.replace(":DEGREES", ":RADIANS").replace("thorax 90", f"thorax {np.pi / 2}"))
    tree = open_motion(tmp_path / "a.amc", skeleton=tmp_path / "a.asf", up="y").tree
    assert tree.end[1, tree.names.index("head"), 2] == pytest.approx(0.0254 * 40)


def _broken(folder: Path) -> dict[str, tuple[Path, str]]:
    """Files that are wrong, each with the rule it breaks."""

    def text(name: str, content: str) -> Path:
        (folder / name).write_text(content)
        return folder / name

    (folder / "a.asf").write_text(ASF)
    whole = trc(folder / "whole.trc", body()).read_text()
    swapped = body()
    swapped[:] = np.nan
    people = tuple(f"{who}:{label}" for who in ("Ann", "Ben") for label in LABELS)
    return {
        "empty": (text("empty.trc", ""), "empty_file"),
        "text as c3d": (text("text.c3d", "hello"), "not_c3d"),
        "zeros as c3d": (text("zeros.c3d", "\0" * 4096), "not_c3d"),
        "no trc": (text("no.trc", "a\nb\nc\nd\ne\nf\ng"), "not_trc"),
        "cut": (text("cut.trc", "\n".join(whole.split("\n")[:-4]) + "\n"), "frame_count"),
        "short row": (text("short.trc", whole.rstrip().rsplit("\t", 2)[0] + "\n"), "row_length"),
        "a word": (text("word.trc", whole.replace("1.7", "abc", 1)), "not_a_number"),
        "blanks for tabs": (text("blank.trc", whole.replace("\t0.0", "  0.0")), "row_length"),
        "time stands": (text("time.trc", whole.replace("0.010000", "0.000000", 1)), "uneven_time"),
        "all gaps": (trc(folder / "gaps.trc", swapped), "all_gaps"),
        "nobody": (trc(folder / "names.trc", body(), labels=tuple(f"M{k}" for k in range(8))), "no_up_axis"),
        "no unit": (trc(folder / "unit.trc", 7000 * body(), unit="furlong"), "no_unit"),
        "two people": (c3d(folder / "two.c3d", np.concatenate([body(), body()], axis=1), people), "two_people"),
        "one frame": (trc(folder / "one.trc", body(1)), "one_frame"),
        "foreign": (text("a.xyz", "1 2 3"), "unknown_format"),
        "amc alone": (text("a.amc", AMC), "no_skeleton"),
        "bvh cut": (text("cut.bvh", BVH.rsplit("\n", 2)[0]), "frame_count"),
        "bvh short row": (text("row.bvh", BVH.replace("0 100 0 0 90 0 0 90 0", "0 100 0 0 90")), "row_length"),
        "bvh NaN": (text("nan.bvh", BVH.replace("0 100 0 0 90", "0 nan 0 0 90")), "not_a_number"),
        "degrees": (
            text("deg.mot", "inDegrees=no\nendheader\ntime\thip\n0\t0\n0.01\t90\n"), "degrees_for_radians",
        ),
        "no angle unit": (text("none.mot", "version=1\nendheader\ntime\thip\n0\t0\n0.01\t1\n"), "no_angle_unit"),
    }  # fmt: skip


def test_what_is_wrong_is_refused_with_its_place_and_advice(tmp_path) -> None:
    for what, (path, rule) in _broken(tmp_path).items():
        with pytest.raises(BadMotion) as refused:
            open_motion(path)
        fault = refused.value.faults[0]
        assert (what, fault.rule) == (what, rule)
        assert fault.file == path.name
        assert fault.advice


def test_bones_of_another_person_are_refused_at_their_row(tmp_path) -> None:
    (tmp_path / "a.asf").write_text(ASF)
    for amc, row, rule in (
        (AMC.replace("lfoot 0\n2", "rfoot 0\n2"), 5, "other_bones"),
        (AMC.replace("thorax 90", "thorax 90 1"), 8, "other_bones"),
        (AMC.rsplit("lfoot", 1)[0], 8, "frame_cut"),
    ):
        (tmp_path / "a.amc").write_text(amc)
        with pytest.raises(BadMotion) as refused:
            open_motion(tmp_path / "a.amc", skeleton=tmp_path / "a.asf", up="y")
        assert (refused.value.faults[0].row, refused.value.faults[0].rule) == (row, rule)


def test_a_c3d_file_that_counts_fewer_frames_than_it_holds_is_refused(tmp_path) -> None:
    """A header's 16 bits wrap. Its parameters may know better."""
    path = c3d(tmp_path / "long.c3d", 1000 * body(200))
    data = bytearray(path.read_bytes())
    data[8:10] = (20).to_bytes(2, "little")
    path.write_bytes(data)
    assert open_motion(path).markers.position == pytest.approx(body(200), abs=1e-6)
    place = data.index((200).to_bytes(2, "little"), data.index(b"FRAMES"))
    data[place : place + 2] = (20).to_bytes(2, "little")
    path.write_bytes(data)
    with pytest.raises(BadMotion) as refused:
        open_motion(path)
    assert (refused.value.faults[0].rule, refused.value.faults[0].value) == ("frame_count", "20")


def test_one_of_two_people_is_taken_when_named(tmp_path) -> None:
    people = tuple(f"{who}:{label}" for who in ("Ann", "Ben") for label in LABELS)
    path = c3d(tmp_path / "two.c3d", 1000 * np.concatenate([body(), body() + np.array([0, 2, 0])], axis=1), people)
    assert open_motion(path, subject="Ben").markers.position == pytest.approx(body() + np.array([0, 2, 0]), abs=1e-6)


def test_a_label_that_is_there_twice_is_told_and_stands_for_no_part(tmp_path) -> None:
    motion = open_motion(trc(tmp_path / "a.trc", body(), labels=(*LABELS[:5], "LHEE", *LABELS[6:])))
    assert motion.told["duplicates"] == "LHEE"
    assert motion.markers.labels[5:7] == ("LHEE #1", "LHEE #2")
    assert set(motion.markers.segment) == set(motion.markers.labels) - {"LHEE #1", "LHEE #2"}


def test_damaged_files_never_end_in_a_traceback(tmp_path) -> None:
    rng, faults = np.random.default_rng(7), []
    (tmp_path / "whole.asf").write_text(ASF)
    (tmp_path / "whole.bvh").write_text(BVH)
    (tmp_path / "whole.amc").write_text(AMC)
    trc(tmp_path / "whole.trc", body())
    (tmp_path / "whole.mot").write_text("inDegrees=yes\nnRows=2\nendheader\ntime\thip\n0\t0\n0.01\t9\n")
    c3d(tmp_path / "whole.c3d", 1000 * body())
    for kind in ("bvh", "amc", "trc", "mot", "asf", "c3d"):
        data = (tmp_path / f"whole.{kind}").read_bytes()
        for _ in range(60):
            spoilt = bytearray(data)
            for at in rng.integers(0, len(data), 3 if kind != "c3d" else 60):
                spoilt[at] = rng.integers(9, 127)
            cut = spoilt[: rng.integers(0, len(data))] if rng.random() < 0.5 else spoilt
            path = tmp_path / f"spoilt.{kind}"
            path.write_bytes(bytes(cut))
            try:
                if kind == "asf":
                    open_motion(tmp_path / "whole.amc", skeleton=path)
                else:
                    open_motion(path, skeleton=tmp_path / "whole.asf")
            except BadMotion as refused:
                faults += refused.faults
    assert len(faults) > 100
    assert all(fault.rule and fault.advice for fault in faults)


def test_presets_name_both_sides_and_no_part_that_there_is_not() -> None:
    for preset in PRESETS.values():
        parts = set(preset.values())
        assert {part for part in parts if part.startswith("l_")} == {
            "l_" + part[2:] for part in parts if part.startswith("r_")
        }
        assert {"pelvis", "thorax", "l_thigh", "l_shank", "l_foot"} <= parts


def test_the_command_takes_what_bones_are_called_elsewhere(tmp_path, capsys) -> None:
    path = tmp_path / "a.bvh"
    path.write_bytes(bvh(bow()).replace(b"LeftUpLeg", b"Schenkel"))
    assert main(["motion", "import", str(path), "--json"]) == 0
    assert "Schenkel" in json.loads(capsys.readouterr().out)["unknown"]
    assert main(["motion", "import", str(path), "--json", "--name", "Schenkel=LeftUpLeg"]) == 0
    assert json.loads(capsys.readouterr().out)["renamed"] == "Schenkel = LeftUpLeg"
    assert main(["motion", "import", str(path), "--name", "Schenkel"]) == 2


def test_the_command_says_what_a_file_is_and_hands_it_out(tmp_path, capsys) -> None:
    path = trc(tmp_path / "a.trc", body() @ TURNS["y"].T * 1000, "mm")
    assert main(["motion", "import", str(path), "--out", str(tmp_path / "a.npz")]) == 0
    said = capsys.readouterr().out
    assert ["frames", "12"] in [line.split() for line in said.splitlines()]
    assert "guessed: y" in said
    with np.load(tmp_path / "a.npz") as arrays:
        assert list(arrays["names"]) == list(LABELS)
        assert arrays["position"][..., 2] == pytest.approx(body()[..., 2])


OURS = [name for name, *_ in BONES]
PARTS = ("UpperArm", "Forearm", "Hand"), ("Thigh", "Calf", "Foot")
BIPED = [f"Bip01 {part}" for part in ("Pelvis", "Spine2", "Head")]
BIPED += [f"Bip01 {side} {part}" for parts in PARTS for side in "LR" for part in parts]
XSENS = ["Hips", "Chest4", "Head", *(f"{side}{joint}" for joints in (("Shoulder", "Elbow", "Wrist"),
         ("Hip", "Knee", "Ankle")) for side in ("Left", "Right") for joint in joints)]  # fmt: skip

SIDES = (("L", "Left"), ("R", "Right"))
MOTIVE = ["Hip", "Chest", "Head", *(s + part for limb in (("UArm", "FArm", "Hand"), ("Thigh", "Shin", "Foot"))
          for s, _ in SIDES for part in limb)]  # fmt: skip
ROKOKO = ["Hips", "Spine4", "Head", *(side + part for limb in (("Arm", "ForeArm", "Hand"), ("Thigh", "Shin", "Foot"))
          for _, side in SIDES for part in limb)]  # fmt: skip
DAZ = ["hip", "chest", "head", *(s.lower() + part for limb in (("Shldr", "ForeArm", "Hand"), ("Thigh", "Shin", "Foot"))
       for s, _ in SIDES for part in limb)]  # fmt: skip


def named(names: list[str]) -> bytes:
    """The bow of a person whose bones are called so."""
    text = bvh(bow(30.0)).decode()
    for own, other in zip(OURS, names, strict=True):
        text = text.replace(f"ROOT {own}\n", f"ROOT {other}\n").replace(f"JOINT {own}\n", f"JOINT {other}\n")
    return text.encode()


@pytest.mark.parametrize(
    ("preset", "names"),
    [
        ("MotionBuilder and Mixamo", [f"mixamorig:{name}" for name in OURS]),
        ("MotionBuilder and Mixamo", [{"Spine2": "Spine1"}.get(name, name) for name in OURS]),
        ("3ds Max Biped", BIPED),
        ("3ds Max Biped", [name.replace(" ", "_") for name in BIPED]),
        ("3ds Max Biped", [name.replace("Bip01", "Bip001").replace("Spine2", "Spine1") for name in BIPED]),
        ("Xsens MVN", XSENS),
        ("Motive", MOTIVE),
        ("Motive", [f"Skeleton_001_{name}" for name in MOTIVE]),
        ("Rokoko", ROKOKO),
        ("Daz and Poser", DAZ),
    ],
)
def test_a_skeleton_is_known_by_the_names_that_programs_give(tmp_path: Path, preset: str, names: list[str]) -> None:
    (tmp_path / "other.bvh").write_bytes(named(names))
    motion = open_motion(tmp_path / "other.bvh")
    assert (motion.told["preset"], motion.told["unit"][:11], motion.told["up"][:10]) == (
        preset, "guessed: cm", "guessed: y",
    )  # fmt: skip
    trunk = person_of(motion).trunk
    assert np.degrees(np.arctan2(trunk[:, 0, 2], trunk[:, 2, 2])) == pytest.approx(bow(30.0), abs=1e-4)


def test_what_is_not_right_in_a_skeleton_is_told_as_what_it_is(tmp_path: Path) -> None:
    good, file = bvh(bow(30.0)).decode(), tmp_path / "bow.bvh"

    def refused(text: str) -> tuple[str, str | None]:
        file.write_text(text)
        with pytest.raises(BadMotion) as found:
            open_motion(file)
        return found.value.faults[0].rule, found.value.faults[0].value

    assert refused(good.replace("JOINT LeftArm", "JOINT RightArm")) == ("same_name", "RightArm")
    assert refused(good.replace("Frame Time: 0.016666666667", "Frame Time: 0")) == ("no_rate", "0")
    rule, value = refused(named([f"bone{k}" for k in range(len(OURS))]).decode())
    assert (rule, (value or "")[:12]) == ("no_up_axis", "bone0, bone1")
    radians = bvh(np.radians(bow(30.0)))
    assert refused(radians.decode()) == ("radians_for_degrees", "0.524")
    for angle, deep in (("rad", 30.0), ("deg", np.radians(30.0))):
        trunk = person_of(open_motion(file, angle=angle)).trunk
        assert np.degrees(np.arctan2(trunk[:, 0, 2], trunk[:, 2, 2])).max() == pytest.approx(deep, abs=1e-4)


def test_the_thorax_carries_the_arms_however_many_vertebrae_there_are(tmp_path: Path) -> None:
    """Of Perception Neuron's four the third was taken, and a bend in the fourth was no bend at all."""
    file, whole = tmp_path / "bow.bvh", bvh(bow(30.0)).decode()
    fourth = "JOINT Spine2\n{\nOFFSET 0 5 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nJOINT Spine3\n{\nOFFSET 0 15 0\n"
    head, motion = whole.split("MOTION")
    head = head.replace("JOINT Spine2\n    {\n      OFFSET 0.0 20.0 0.0\n".replace("    ", "  "), fourth)
    head, legs = head[: head.index("  JOINT LeftUpLeg")] + "}\n", head[head.index("  JOINT LeftUpLeg") :]
    rows = motion.splitlines()
    rows[3:] = [" ".join(each.split()[:6] + ["0"] * 3 + each.split()[6:]) for each in rows[3:]]
    file.write_text(head + legs + "MOTION" + "\n".join(rows))
    tree = open_motion(file).tree
    assert [name for name, part in tree.segment.items() if part == "thorax"] == ["Spine3"]
    trunk = person_of(open_motion(file)).trunk
    assert np.degrees(np.arctan2(trunk[:, 0, 2], trunk[:, 2, 2])) == pytest.approx(bow(30.0), abs=1e-4)


@pytest.mark.parametrize(("unit", "size"), [("m", 0.01), ("mm", 10.0), ("in", 1 / 2.54), ("cmu", 0.45 / 2.54)])
def test_a_skeleton_in_any_unit_is_as_tall(tmp_path: Path, unit: str, size: float) -> None:
    """Conversions of CMU's captures keep the unit of their ASF files: they were refused, whatever unit was said."""
    (tmp_path / "bow.bvh").write_bytes(bvh(bow(30.0), size=size))
    motion = open_motion(tmp_path / "bow.bvh")
    assert motion.told["unit"].startswith(f"guessed: {unit},")
    assert person_of(motion).hip_height == pytest.approx(0.85, abs=1e-4)


def test_a_table_of_angles_says_its_unit_as_it_likes_or_is_told(tmp_path: Path) -> None:
    file = tmp_path / "a.mot"
    rows = "time\thip\n" + "".join(f"{12.5 + k / 59.94:.6f}\t{30 * k}\n" for k in range(4))
    for head in ("inDegrees=yes", "indegrees = YES", "INDEGREES=Yes\r\nnRows=4\r"):
        file.write_text(f"{head}\nendheader\n{rows}", newline="")
        motion = open_motion(file)
        assert np.degrees(motion.angles.value[:, 0]) == pytest.approx([0.0, 30.0, 60.0, 90.0])
        assert (motion.time[0], motion.rate) == (0.0, pytest.approx(59.94, rel=1e-4))
    file.write_text(f"version=1\nendheader\n{rows}")
    assert open_motion(file, angle="deg").angles.value[3, 0] == pytest.approx(np.pi / 2)
    for wrong, rule in (("12.5\t1\n", "one_frame"), ("2\t0\n1\t0\n0\t0\n", "uneven_time")):
        file.write_text(f"inDegrees=yes\nendheader\ntime\thip\n{wrong}")
        with pytest.raises(BadMotion) as refused:
            open_motion(file)
        assert refused.value.faults[0].rule == rule


def test_markers_of_one_person_are_known_behind_any_prefix_and_beside_things(tmp_path: Path) -> None:
    """A chair's markers counted as a second person; Motive may part subjects by an underscore."""
    beside = np.concatenate([body(), body()[:, :2] + 0.5], axis=1)
    for prefix, others in (("Ann:", ("Chair:1", "Chair:2")), ("Skeleton_001_", ("Unlabeled 1", "Unlabeled 2"))):
        file = trc(tmp_path / "a.trc", beside, labels=(*(prefix + label for label in LABELS), *others))
        motion = open_motion(file)
        assert motion.told["prefix"] == prefix[:-1]
        assert set(motion.markers.segment) == set(LABELS)
        assert motion.told.get("left_out", motion.told.get("unknown")) == ", ".join(others)
    two = np.concatenate([body(), body() + np.array([0, 2, 0])], axis=1)
    file = trc(tmp_path / "two.trc", two, labels=tuple(f"{who}_{label}" for who in ("Ann", "Ben") for label in LABELS))
    with pytest.raises(BadMotion, match="Ann, Ben"):
        open_motion(file)
    assert open_motion(file, subject="Ben").markers.position == pytest.approx(body() + np.array([0, 2, 0]))


def test_a_point_beyond_any_room_was_not_seen(tmp_path: Path) -> None:
    """Some programs write 9999999 where they lost a marker."""
    lost = 1000 * body()
    lost[3:5, 2] = 9999999.0
    motion = open_motion(trc(tmp_path / "a.trc", lost, "mm"))
    assert np.isnan(motion.markers.position[3:5, 2]).all()
    assert np.isfinite(motion.markers.position).sum() == body().size - 6
    assert motion.told["far_away"] == "C7"


def test_a_file_is_written_as_it_is_called(tmp_path: Path, capsys) -> None:
    """numpy wrote a.txt.npz, and nobody said so."""
    out = tmp_path / "a.txt"
    assert main(["motion", "import", str(trc(tmp_path / "a.trc", body())), "--out", str(out)]) == 0
    with np.load(out) as arrays:
        assert arrays["position"].shape == (12, len(LABELS), 3)
    assert not out.with_suffix(".txt.npz").exists()
    capsys.readouterr()


def test_the_command_says_plainly_what_of_its_options_is_wrong(tmp_path: Path, capsys) -> None:
    file = str(trc(tmp_path / "a.trc", body()))
    assert main(["motion", "retarget", file, "--robot", "robot.yaml", "--from", "5", "--to", "4"]) == 2
    assert capsys.readouterr().err.strip().endswith("the end, 4 s, must come after the begin, 5 s")
    for place, what in ((tmp_path / "lost.urdf", "there is no such file"), (tmp_path, "is a folder")):
        assert main(["motion", "robot", str(place)]) == 2
        assert what in capsys.readouterr().err
