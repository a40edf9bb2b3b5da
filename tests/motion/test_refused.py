"""What is wrong with a capture, a static trial, a table or a robot is told at its place, with what to do."""

from __future__ import annotations

import copy
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from tests.motion.captures import bow, bvh
from tests.motion.plans import table
from tests.motion.robots import sample_folder
from tests.motion.test_fit import bowing
from tests.motion.test_reading import AMC, ASF, body, c3d, trc

from exogauge.errors import BadInput, BadMotion, BadRobot, Fault
from exogauge.motion.files import open_motion
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.person import person_of
from exogauge.motion.plan.written import read_written
from exogauge.motion.robot_file import load_motion_robot


def fault_of(ask: Callable[[], object], kind: type[BadInput] = BadMotion) -> Fault:
    with pytest.raises(kind) as refused:
        ask()
    fault = refused.value.faults[0]
    assert fault.advice or fault.rule.startswith(("greater", "less"))
    return fault


def acclaim(folder: Path, asf: str = ASF, amc: str = AMC) -> Callable[[], object]:
    (folder / "a.asf").write_text(asf)
    (folder / "a.amc").write_text(amc)
    return lambda: open_motion(folder / "a.amc", skeleton=folder / "a.asf", up="y")


def test_a_skeleton_without_length_is_refused_at_its_row(tmp_path: Path) -> None:
    """A unit of no length was a division by zero; a bone of a negative one left nobody on his feet, in silence."""
    stated = next(line for line in ASF.splitlines() if line.strip().startswith("length"))
    for text in ("length 0", "length -2"):
        fault = fault_of(acclaim(tmp_path, asf=ASF.replace(stated, text, 1)))
        assert (fault.rule, fault.column, fault.row) == ("bad_length", "length", ASF.splitlines().index(stated) + 1)
    bone = next(line for line in ASF.splitlines()[ASF.splitlines().index(stated) + 1 :] if "length" in line)
    fault = fault_of(acclaim(tmp_path, asf=ASF.replace(bone, bone.replace("length ", "length -"), 1)))
    assert (fault.rule, fault.row) == ("bad_length", ASF.splitlines().index(bone) + 1)


def test_a_frame_that_names_a_bone_twice_or_not_is_refused_where_it_stands(tmp_path: Path) -> None:
    """The second one counted, in silence; a bone that lacks was told at the last row of the file."""
    lines = AMC.splitlines()
    second = lines.index("2")
    bone = lines[second + 2]
    doubled = [*lines[: second + 3], bone, *lines[second + 3 :]]
    fault = fault_of(acclaim(tmp_path, amc="\n".join(doubled) + "\n"))
    assert (fault.rule, fault.row, fault.column) == ("bone_twice", second + 4, bone.split()[0])
    lacking = [line for k, line in enumerate(lines) if k != lines.index("1") + 2]
    fault = fault_of(acclaim(tmp_path, amc="\n".join(lacking) + "\n"))
    assert (fault.rule, fault.row) == ("frame_cut", lines.index("1") + 1)


def test_numbers_that_no_motion_has_are_refused_at_their_place(tmp_path: Path) -> None:
    lines = bvh(bow()).decode().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    words = lines[first + 4].split()
    lines[first + 4] = " ".join([*words[:5], "1e308", *words[6:]])
    (tmp_path / "huge.bvh").write_text("\n".join(lines) + "\n")
    fault = fault_of(lambda: open_motion(tmp_path / "huge.bvh"))
    assert (fault.rule, fault.row, fault.value) == ("not_a_number", first + 5, "1e308")


def test_a_rate_of_no_camera_is_refused(tmp_path: Path) -> None:
    """It ended in an OverflowError."""
    data = c3d(tmp_path / "a.c3d", 1000.0 * body()).read_bytes()
    (tmp_path / "a.c3d").write_bytes(data.replace(struct.pack("<f", 100.0), struct.pack("<f", 1e30)))
    assert fault_of(lambda: open_motion(tmp_path / "a.c3d")).rule == "fast_clock"


def test_one_marker_in_another_unit_is_not_the_body(tmp_path: Path) -> None:
    """The whole file was refused for its unit: feet to head were 326 m."""
    points = body()
    points[:, 2] *= 1000.0
    motion = open_motion(trc(tmp_path / "a.trc", points))
    assert motion.told["far_away"] == "C7"
    assert motion.markers is not None
    assert np.isnan(motion.markers.position[:, 2]).all()


def test_who_lies_by_a_wrong_axis_is_told_and_not_retargeted(tmp_path: Path) -> None:
    """A plan was sought for minutes."""
    (tmp_path / "bow.bvh").write_bytes(bvh(bow()))
    motion = open_motion(tmp_path / "bow.bvh", up="z")
    assert motion.told["up"] == "stated: z, though feet to head lie along y"
    assert "though" not in open_motion(tmp_path / "bow.bvh", up="y").told["up"]
    person = person_of(open_motion(tmp_path / "bow.bvh"))
    lain = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    person.turn[:] = lain @ person.turn
    fault = fault_of(lambda: person.cut(0.0, 1.0))
    assert (fault.rule, fault.column) == ("not_upright", "pelvis")
    assert "--up" in (fault.advice or "")


def test_a_static_trial_in_which_nobody_stands_is_refused(tmp_path: Path) -> None:
    """Somebody who sat down in it: the trunk was 20 degrees off, in silence."""
    motion = bowing()
    assert motion.markers is not None
    on = [k for k, label in enumerate(motion.markers.labels) if motion.markers.segment.get(label) == "thorax"]
    lower = motion.markers.position.copy()
    lower[20:, on, 2] -= 0.4
    sits = replace(motion, markers=replace(motion.markers, position=lower))
    fault = fault_of(lambda: fit_human(motion, sits))
    assert (fault.rule, fault.column) == ("not_standing", "thorax")
    assert fault.row is not None
    other = open_motion(trc(tmp_path / "other.trc", body()))
    fault = fault_of(lambda: fit_human(motion, other))
    assert (fault.rule, fault.column) == ("other_markers", "pelvis")


SOLE = [[0.125, 0.055, -0.085], [-0.085, 0.055, -0.085], [-0.085, -0.055, -0.085], [0.125, -0.055, -0.085]]
ROBOTS: dict[str, tuple[dict[str, Any], str, str]] = {  # what is said, rule, column
    "corners on a line": ({"soles": [("l_foot", [[0.0, 0.0, -0.08], [0.1, 0.0, -0.08], [0.2, 0.0, -0.08]]),
                                     ("r_foot", SOLE)]}, "no_sole", "soles.0.outline"),
    "crossing": ({"soles": [("l_foot", [SOLE[k] for k in (0, 2, 1, 3)]), ("r_foot", SOLE)]}, "no_sole",
                 "soles.0.outline"),
    "a foot twice": ({"soles": [("l_foot", SOLE), ("l_foot", SOLE)]}, "one_foot", "soles.1.link"),
    "right first": ({"soles": [("r_foot", SOLE), ("l_foot", SOLE)]}, "right_first", "soles.0.link"),
    "another floor": ({"soles": [("l_foot", [[x, y, z + 0.05] for x, y, z in SOLE]), ("r_foot", SOLE)]}, "not_flat",
                      "soles.0"),
    "negative": ({"limits": {"acceleration": -1.0}}, "greater_than", "limits.acceleration"),
    "a share in per cent": ({"limits": {"torque_share": 90}}, "less_than_equal", "limits.torque_share"),
}  # fmt: skip


@pytest.mark.parametrize("what", ROBOTS)
def test_a_robot_that_cannot_stand_so_is_refused_at_its_key(tmp_path: Path, what: str) -> None:
    said, rule, column = copy.deepcopy(ROBOTS[what])
    if "soles" in said:
        said["soles"] = [{"link": link, "outline": outline} for link, outline in said["soles"]]
    file = sample_folder(tmp_path)
    file.write_text(yaml.safe_dump(yaml.safe_load(file.read_bytes()) | said))
    with pytest.raises(BadInput) as refused:
        load_motion_robot(file)
    assert [(fault.rule, fault.column) for fault in refused.value.faults] == [(rule, column)]
    assert isinstance(refused.value, BadRobot) or rule in ("greater_than", "less_than_equal")


def test_a_table_with_a_number_that_no_joint_has_is_refused_at_its_cell(robot, tmp_path: Path) -> None:
    """It was judged, with warnings of numpy."""
    t = 0.005 * np.arange(20)
    angle = np.zeros(20)
    angle[7] = 1e300
    file = table(tmp_path / "a.csv", {"t": t, "q.torso_pitch": angle})
    fault = fault_of(lambda: read_written(robot, file))
    assert (fault.rule, fault.row, fault.column) == ("not_a_number", 8, "q.torso_pitch")


def test_a_file_of_another_kind_is_refused_with_the_command_that_takes_it(robot, folder: Path, tmp_path: Path) -> None:
    """A URDF "must hold keys and values", a MOT needed "layout: {skip_lines: 6} in a mapping", a cut ended at inf s."""
    fault = fault_of(lambda: load_motion_robot(folder / "robot.urdf"), BadRobot)
    assert (fault.rule, fault.row) == ("a_urdf", 1)
    assert "exogauge motion robot" in fault.advice
    (tmp_path / "angles.mot").write_text("inDegrees=yes\nendheader\ntime\thip\n0\t0\n")
    (tmp_path / "b.bvh").write_bytes(bvh(bow()))
    for name in ("angles.mot", "b.bvh"):
        fault = fault_of(lambda name=name: read_written(robot, tmp_path / name))
        assert (fault.rule, fault.file) == ("a_capture", name)
        assert "exogauge motion retarget" in fault.advice
    person = person_of(open_motion(tmp_path / "b.bvh"))
    assert "from 30 s on" in fault_of(lambda: person.cut(30.0, np.inf)).detail
