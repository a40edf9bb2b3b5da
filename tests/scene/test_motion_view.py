"""A person beside the robot: what is drawn stands where it is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.motion.captures import bow, bvh
from tests.motion.robots import sample_folder

from exogauge.motion import compute
from exogauge.motion.contract import RetargetEntry
from exogauge.motion.figure import figure_of, read_figure
from exogauge.motion.files import open_motion
from exogauge.motion.played import Played, moments
from exogauge.motion.robot_file import load_motion_robot
from exogauge.scene.motion_view import _shrunk, draw_captured, draw_played
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.robot_file import read_robot


def track(scene: Any, name: str) -> np.ndarray:
    (found,) = [each for each in scene.header["tracks"] if each["name"] == name]
    return np.asarray(scene.array(found["values"]), dtype=np.float64).reshape(-1, found["width"])


def test_what_lies_inside_a_square_is_a_smaller_square() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    inner = _shrunk(square, 0.1)
    assert sorted(map(tuple, inner.round(9))) == [(0.1, 0.1), (0.1, 0.9), (0.9, 0.1), (0.9, 0.9)]
    assert len(_shrunk(square, 0.6)) == 0


def test_moments_of_the_capture_come_slower_and_again() -> None:
    wanted = RetargetEntry(begin=1.0, end=3.0, slow=2.0, repeat=2)
    whole = 2 * 4.0 + 2.0  # two times 2 s made twice as long, and the way between
    at = moments(np.array([-1.0, 0.0, 2.0, 4.0, 5.0, 6.0, 8.0, 11.0]), whole, wanted)
    assert at == pytest.approx([1.0, 1.0, 2.0, 3.0, 3.0, 1.0, 2.0, 3.0])


def test_a_captured_person_is_drawn_where_its_bones_are(tmp_path: Path, unpack: Callable[[bytes], Any]) -> None:
    (tmp_path / "bow.bvh").write_bytes(bvh(bow()))
    figure = figure_of(open_motion(tmp_path / "bow.bvh"))
    lines = track(unpack(draw_captured(figure)), "/person/bones")
    lines = lines.reshape(len(lines), -1, 2, 3)
    assert lines.shape[1] == 14 + 5  # bones below another, and the ends of five
    assert lines[..., 2].min() == pytest.approx(0.02, abs=0.01)
    assert lines[..., 2].max() == pytest.approx(0.95 + 0.2 + 0.4 + 0.2, abs=0.01)


def test_the_floor_shows_what_stands_then(tmp_path: Path, unpack: Callable[[bytes], Any]) -> None:
    """Left foot, both, right foot: of each the polygon that it makes, and only then."""
    robot = sample_folder(tmp_path)
    described, _, urdf = read_robot(Bundle(robot.parent, robot.name), robot.name)
    moving = load_motion_robot(robot)
    stands = np.array([[1, 0], [1, 1], [1, 1], [0, 1]], dtype=bool)
    T, none = len(stands), np.zeros(0)
    foot = np.array([[0.1, 0.05, 0.0], [-0.1, 0.05, 0.0], [-0.1, -0.05, 0.0], [0.1, -0.05, 0.0]])
    outline = np.concatenate([foot + np.array([0.0, y, 0.0]) for y in (0.1, -0.1)])
    played = Played(
        np.arange(T) / 10.0, np.tile([0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 1.0], (T, 1)), np.zeros((T, len(moving.joints))),
        np.zeros((T, 3)), np.full(T, 0.02), outline, np.repeat([0.0, 1.0], 4), stands, np.array([0.015]),
        np.full((T, 2, 3), np.nan), np.full(T, 0.03), np.zeros((T, len(moving.joints))), none, none,
        np.zeros((0, 7)), np.zeros((0, len(moving.joints))),
    )  # fmt: skip
    played.write(tmp_path / "played.npz")
    read = Played.read(tmp_path / "played.npz")
    scene = unpack(draw_played(described, urdf, lambda name: None, read, list(moving.joints), None))
    nodes = [name for name in scene.header["layers"]["balance"] if "outline" in name]
    assert len(nodes) == 3
    shown = np.column_stack([track(scene, name)[:, 0] for name in nodes])
    assert (shown.sum(axis=1) == 1).all(), "one polygon at a time"
    assert shown[0].argmax() != shown[-1].argmax() != shown[1].argmax()
    with np.load(tmp_path / "played.npz") as file:
        older = {name: file[name] for name in file.files if name not in ("foot", "stands", "ghost_base", "ghost_q")}
    np.savez(tmp_path / "older.npz", **older)
    scene = unpack(draw_played(described, urdf, lambda name: None, Played.read(tmp_path / "older.npz"),
                               list(moving.joints), None))  # fmt: skip
    assert len([name for name in scene.header["layers"]["balance"] if "outline" in name]) == 1


@pytest.mark.slow
def test_person_and_robot_bow_together_and_the_pressure_stays_inside(
    tmp_path: Path, unpack: Callable[[bytes], Any]
) -> None:
    robot = sample_folder(tmp_path / "plan" / "robot")
    (tmp_path / "plan" / "motion").mkdir()
    (tmp_path / "plan" / "motion" / "bow.bvh").write_bytes(bvh(bow()))
    (tmp_path / "plan" / "motion" / "motion.yaml").write_text("version: 1\nfile: bow.bvh\n")
    (tmp_path / "plan" / "plan.yaml").write_text("version: 1\nrobot: x\nretarget: {}\n")
    out = tmp_path / "out"
    out.mkdir()
    compute.retarget(tmp_path / "plan", out, lambda share, words: None, {})
    played = Played.read(out / compute.PLAYED)
    described, _, urdf = read_robot(Bundle(robot.parent, robot.name), robot.name)
    joints = list(load_motion_robot(robot).joints)
    figure = read_figure(out / compute.FIGURE)
    scene = unpack(draw_played(described, urdf, lambda name: None, played, joints, figure))
    assert set(scene.header["layers"]) >= {"robot", "person", "balance", "floor", "ghost"}
    assert scene.header["hidden"] == ["ghost"]  # until somebody asks for it
    (root,) = [each for each in scene.header["messages"] if each.get("name") == "/ghost" and "visible" in each]
    assert root["visible"] is False
    assert played.ghost_base[:, :3] == pytest.approx(played.base[:, :3], abs=0.2)
    assert played.ghost_q[:, joints.index("torso_pitch")].max() == pytest.approx(np.radians(20.0), abs=0.01)
    told = json.loads((out / compute.PLAN).read_text())["frame_by_frame"]
    assert 0.0 <= told["outside"] <= 1.0
    assert told["margins"]["feet_m"] < 1e-3
    bones = track(scene, "/person/bones")
    middle, first = bones[len(bones) // 2].reshape(-1, 3), bones[0].reshape(-1, 3)
    head = first[:, 2].argmax()
    assert middle[head, 0] - first[head, 0] == pytest.approx(
        0.6 * np.sin(np.radians(20.0)), abs=0.01
    )  # both face ahead
    pressure = track(scene, "/balance/pressure")
    low, high = played.outline.min(axis=0), played.outline.max(axis=0)
    assert (pressure[:, :2] > low[:2]).all()
    assert (pressure[:, :2] < high[:2]).all()
    pitch = played.q[:, joints.index("torso_pitch")]
    assert pitch.max() == pytest.approx(np.radians(20.0), abs=2e-3)
    assert played.moment[pitch.argmax()] == pytest.approx(1.0, abs=0.05)
