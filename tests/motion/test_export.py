"""What is written is read back by those who play it: MuJoCo, rosbags, and readers of our own."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.typesys import Stores, get_typestore
from tests.motion.by_mujoco import spec_of

from exogauge.cli import main
from exogauge.motion.files import open_motion
from exogauge.motion.plan.asked import on_its_feet
from exogauge.motion.plan.export import FORMATS, exported
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.spline import Spline, through
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing
from exogauge.synthetic.urdf import robot_urdf

RATE = 50.0


def column(robot: MotionRobot, joint: str) -> int:
    return robot.base + robot.joints.index(joint)


@pytest.fixture(scope="module")
def motion(robot: MotionRobot) -> Spline:
    """A slow bow and turn, the pelvis sinking and yawing a little: nothing is broken."""
    s = np.sin(np.linspace(0.0, np.pi, 181))[:, None] ** 2
    aim = np.zeros(robot.model.nq)
    aim[[2, 3]] = -0.02, 0.05
    for joint, value in {"torso_pitch": 0.25, "torso_yaw": 0.3, "l_shoulder_pitch": -0.4}.items():
        aim[column(robot, joint)] = value
    place = standing(robot)
    return through(np.stack([on_its_feet(robot, q, place) for q in robot.home + s * aim]), 1.0 / 60.0)


@pytest.fixture(scope="module")
def judged(robot: MotionRobot, motion: Spline) -> Judged:
    found = judge(robot, motion, standing(robot), rate=RATE)
    assert [line for line in found.broken if "standing foot" not in line] == []
    return found


def one(robot: MotionRobot, motion: Spline, judged: Judged, form: str) -> bytes:
    (data,) = exported(robot, motion, judged, form).values()
    return data


def test_mujoco_stands_where_the_plan_stands_and_moves_as_it_moves(robot, motion, judged) -> None:
    file = np.load(io.BytesIO(one(robot, motion, judged, "mujoco")))
    model = spec_of(robot_urdf()).compile()
    data = mujoco.MjData(model)
    order = [model.joint(name).qposadr[0] for name in file["joint_names"]]
    to = np.concatenate([np.arange(7), order])
    qpos = np.empty_like(file["qpos"])
    qpos[:, to] = file["qpos"]
    feet = []
    for posture in qpos:
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        feet.append([data.body(sole.link).xpos.copy() for sole in robot.soles])
    assert np.abs(np.array(feet) - feet[0]).max() < 2e-3
    assert np.array(feet)[0] == pytest.approx(np.stack([at.translation for at in standing(robot)]), abs=1e-6)
    rate = np.empty(model.nv)
    qvel = np.empty_like(file["qvel"])
    qvel[:, np.concatenate([np.arange(6), np.array(order) - 1])] = file["qvel"]
    for t in range(10, len(qpos) - 10, 20):
        mujoco.mj_differentiatePos(model, rate, 2.0 / RATE, qpos[t - 1], qpos[t + 1])
        assert qvel[t] == pytest.approx(rate, abs=2e-3)


@pytest.mark.slow
def test_rosbags_reads_the_trajectory_back(robot, motion, judged, tmp_path: Path) -> None:
    path = tmp_path / "motion.mcap"
    path.write_bytes(one(robot, motion, judged, "ros2-mcap"))
    reader, store = McapReader(path), get_typestore(Stores.ROS2_HUMBLE)
    reader.open()
    (connection,) = reader.connections
    (_, _, raw), *more = reader.messages(reader.connections)
    reader.close()
    assert connection.topic == "/joint_trajectory"
    assert not more
    message = store.deserialize_cdr(bytes(raw), connection.msgtype)
    written = yaml.safe_load(one(robot, motion, judged, "ros2-yaml"))
    assert tuple(message.joint_names) == tuple(written["joint_names"]) == robot.joints
    assert len(message.points) == len(written["points"]) == len(judged.time)
    for k in (0, 40, len(judged.time) - 1):
        ours, theirs = written["points"][k], message.points[k]
        assert ours["positions"] == pytest.approx(judged.q[k, 6:], abs=1e-8)
        assert theirs.velocities == pytest.approx(judged.dq[k, 6:], abs=1e-8)
        assert ours["accelerations"] == pytest.approx(theirs.accelerations)
        stamp = theirs.time_from_start
        assert stamp.sec + 1e-9 * stamp.nanosec == pytest.approx(judged.time[k])
        assert ours["time_from_start"] == {"sec": stamp.sec, "nanosec": stamp.nanosec}
    middle = len(judged.time) // 2
    slope = (message.points[middle + 1].velocities - message.points[middle - 1].velocities) * RATE / 2
    assert message.points[middle].accelerations == pytest.approx(slope, abs=0.05)


def test_hrpsys_has_the_pressure_in_the_waist_and_the_waist_in_the_world(robot, motion, judged) -> None:
    files = exported(robot, motion, judged, "hrpsys")
    rows = {end: np.loadtxt(io.BytesIO(data)) for end, data in files.items()}
    assert set(rows) == {".pos", ".vel", ".zmp", ".waist", ".hip"}
    assert rows[".pos"][:, 1:] == pytest.approx(judged.q[:, 6:], abs=1e-7)
    assert rows[".waist"][:, 4:] == pytest.approx(rows[".hip"][:, 1:])
    assert np.gradient(rows[".pos"][:, 1:], 1.0 / RATE, axis=0)[2:-2] == pytest.approx(rows[".vel"][2:-2, 1:], abs=5e-3)
    for t in (0, 70, 100):
        roll, pitch, yaw = rows[".waist"][t, 4:]
        turn = mujoco_turn(yaw, "z") @ mujoco_turn(pitch, "y") @ mujoco_turn(roll, "x")
        world = rows[".waist"][t, 1:4] + turn @ rows[".zmp"][t, 1:]
        assert world == pytest.approx(judged.pressure[t], abs=1e-6)
        assert abs(world[2]) < 1e-3
    assert rows[".waist"][90, 3] - rows[".waist"][0, 3] < -0.005  # it sinks


@pytest.mark.slow
def test_every_format_says_when_a_foot_is_up(robot, motion, judged, tmp_path: Path) -> None:
    stands = np.ones_like(judged.stands)
    stands[40:60, 0] = False
    lifts = replace(judged, stands=stands, broken=())
    (left, right) = (sole.link for sole in robot.soles)
    told = f"stands.{left}: 0 from {judged.time[40]:g} to {judged.time[59]:g} s, else 1"
    columns = np.loadtxt(io.BytesIO(exported(robot, motion, lifts, "hrpsys")[".stands"]))[:, 1:]
    assert (columns == stands).all()
    rows = [line.split(";") for line in one(robot, motion, lifts, "mc_rtc").decode().splitlines()]
    assert rows[0][-2:] == [f"stands.{left}", f"stands.{right}"]
    assert (np.array([row[-2:] for row in rows[1:]], dtype=float) == stands).all()
    assert f"# {told}\n" in one(robot, motion, lifts, "ros2-yaml").decode()
    assert yaml.safe_load(one(robot, motion, lifts, "ros2-yaml"))["joint_names"] == list(robot.joints)
    head = one(robot, motion, lifts, "mot").decode().split("endheader")[0]
    assert told in head.splitlines()
    (tmp_path / "motion.mot").write_bytes(one(robot, motion, lifts, "mot"))
    assert open_motion(tmp_path / "motion.mot").angles is not None
    (tmp_path / "motion.mcap").write_bytes(one(robot, motion, lifts, "ros2-mcap"))
    reader, store = McapReader(tmp_path / "motion.mcap"), get_typestore(Stores.ROS2_HUMBLE)
    reader.open()
    feet = [(each.topic, at, store.deserialize_cdr(bytes(raw), each.msgtype).data)
            for each, at, raw in reader.messages(reader.connections) if each.topic.startswith("/stands")]  # fmt: skip
    reader.close()
    changes = [round(judged.time[t] * 1e9) for t in (40, 60)]
    assert [each[1:] for each in feet if each[0] == f"/stands/{left}"] == [
        (0, True), (changes[0], False), (changes[1], True)
    ]  # fmt: skip
    assert [each[1:] for each in feet if each[0] == f"/stands/{right}"] == [(0, True)]
    for form in FORMATS:
        assert b"stands" not in one(robot, motion, judged, form) if form not in ("mujoco", "hrpsys") else True


def mujoco_turn(angle: float, axis: str) -> np.ndarray:
    out, quaternion = np.empty(9), np.zeros(4)
    mujoco.mju_axisAngle2Quat(quaternion, np.eye(3)["xyz".index(axis)], angle)
    mujoco.mju_quat2Mat(out, quaternion)
    return out.reshape(3, 3)


def test_tables_have_their_units(robot, motion, judged, tmp_path: Path) -> None:
    (tmp_path / "motion.mot").write_bytes(one(robot, motion, judged, "mot"))
    again = open_motion(tmp_path / "motion.mot")
    assert again.angles is not None
    k = list(again.angles.names).index("torso_pitch")
    assert again.angles.value[:, k] == pytest.approx(judged.q[:, column(robot, "torso_pitch")], abs=1e-8)
    lines = one(robot, motion, judged, "mc_rtc").decode().splitlines()
    assert lines[0].split(";")[:3] == ["t", "qOut_0", "qOut_1"]
    assert [float(x) for x in lines[50].split(";")[1:]] == pytest.approx(judged.q[49, 6:], abs=1e-8)


def test_a_broken_motion_is_marked_in_every_format(robot: MotionRobot, motion: Spline, judged: Judged) -> None:
    fast = Spline(motion.control, motion.step / 12.0)
    broken = judge(robot, fast, standing(robot), rate=RATE)
    assert any("centre of pressure" in line for line in broken.broken)
    whole = judge(robot, motion, standing(robot), rate=RATE)
    object.__setattr__(whole, "broken", ())
    for form in FORMATS:
        good, bad = exported(robot, motion, whole, form), exported(robot, fast, broken, form)
        assert b"broken" not in b"".join(data for end, data in good.items() if end != ".npz")
        if form == "mujoco":
            assert len(np.load(io.BytesIO(bad[".npz"]))["broken"]) == len(broken.broken)
            assert len(np.load(io.BytesIO(good[".npz"]))["broken"]) == 0
        else:
            assert b"broken" in b"".join(bad.values()) or ".broken" in bad


@pytest.mark.slow
def test_a_file_becomes_another_at_any_rate_with_a_sheet(robot, motion, folder: Path, tmp_path: Path, capsys) -> None:
    still = Spline(np.tile(robot.home, (63, 1)), 1.0 / 60.0)
    seen = judge(robot, still, standing(robot))
    (tmp_path / "still.csv").write_bytes(one(robot, still, seen, "csv"))
    command = ["motion", "export", str(tmp_path / "still.csv"), "--robot", str(folder / "robot.yaml"), "--json"]
    assert main([*command, "--format", "hrpsys", "--rate", "500", "--out", str(tmp_path / "bow.pos")]) == 0
    assert json.loads(capsys.readouterr().out)["written"].startswith("bow.pos, bow.vel")
    assert len(np.loadtxt(tmp_path / "bow.zmp")) == 501
    told = json.loads((tmp_path / "bow.pos.json").read_text())
    assert told["rate_hz"] == 500.0
    assert told["broken"] == []
    assert told["joints"]["l_knee_pitch"]["range"] == [0.7, 0.7]
    for name in ("bow.pos", "bow.waist", "still.csv"):
        assert told["sha256"][name] == hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
    lines = (tmp_path / "still.csv").read_text().splitlines()  # one knee straighter than the other
    (tmp_path / "lifted.csv").write_text("\n".join(line.replace(",0.7,", ",0.6,", 1) for line in lines))
    command[2] = str(tmp_path / "lifted.csv")
    assert main([*command, "--format", "mot", "--out", str(tmp_path / "lifted.mot")]) == 1
    assert not (tmp_path / "lifted.mot").exists()
    assert main([*command, "--format", "mot", "--out", str(tmp_path / "lifted.mot"), "--despite"]) == 1
    assert b"broken" in (tmp_path / "lifted.mot").read_bytes()
    assert json.loads((tmp_path / "lifted.mot.json").read_text())["broken"]
    assert main([*command, "--format", "gif"]) == 2
    assert "hrpsys" in capsys.readouterr().err


def test_what_cannot_be_written_is_refused_before_a_motion_is_planned(folder: Path, tmp_path: Path, capsys) -> None:
    """A folder that is not there ended in a traceback once the plan was found, and the plan was lost; a folder as file
    wrote beside it. The capture is not even looked for."""
    robot = ["--robot", str(folder / "robot.yaml")]
    for step, given in (("retarget", ["no.bvh", *robot]), ("export", ["no.csv", *robot]), ("import", ["no.bvh"]),
                        ("fit", ["no.trc"]), ("excite", robot)):  # fmt: skip
        for out, said in ((tmp_path / "none" / "a.csv", "no such folder"), (tmp_path, "this is a folder")):
            assert main(["motion", step, *given, "--out", str(out)]) == 2
            assert said in capsys.readouterr().err
    assert main(["motion", "retarget", "no.bvh", *robot, "--format", "gif"]) == 2
    assert "no such format" in capsys.readouterr().err
