"""A judged motion as files that robots and simulators play, one function per format."""

from __future__ import annotations

import hashlib
import io
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import yaml
from numpy.typing import NDArray

from exogauge.errors import BadMotion, Fault
from exogauge.motion.plan.judge import Judged
from exogauge.motion.plan.outcome import motion_table, ups
from exogauge.motion.plan.spline import Trajectory
from exogauge.motion.plan.written import STANDS
from exogauge.robots.moving.robot import MotionRobot
from exogauge.studies.csv_table import csv_table

Array = NDArray[np.float64]
Files = dict[str, bytes]  # ending of the name -> content
TOPIC, FEET = "/joint_trajectory", "/stands"
BROKEN = "broken"  # what a file that breaks a bound carries


def exported(robot: MotionRobot, motion: Trajectory, judged: Judged, form: str) -> Files:
    """The files of a format, at the times that were judged. form: a key of `FORMATS`."""
    return FORMATS[form][0](robot, motion, judged)


def sheet(robot: MotionRobot, judged: Judged, form: str, files: Files, sources: dict[str, bytes]) -> dict[str, Any]:
    """What is in the files: units and frames, ranges, top speeds, margins, what is broken; SHA-256 of each and of what
    they were made from."""
    base, limits = robot.base, robot.limits
    joints = {}
    for j, name in enumerate(robot.joints):
        q, v, tau = judged.q[:, base + j], judged.dq[:, base + j], judged.torque[:, j]
        joints[name] = {
            "range": [round(float(q.min()), 6), round(float(q.max()), 6)],
            "top_speed": round(float(np.abs(v).max()), 6),
            "top_torque": round(float(np.abs(tau).max()), 4),
            "left_to_bound": round(float(min((q - limits.lower[j]).min(), (limits.upper[j] - q).min())), 6),
        }
    time = judged.time
    return {
        "robot": robot.name, "format": form, "holds": FORMATS[form][1], "samples": len(time),
        "rate_hz": round((len(time) - 1) / float(time[-1]), 6), "seconds": round(float(time[-1]), 6),
        "unit": "rad, rad/s, N·m of revolute joints; m, m/s, N of prismatic ones",
        "margin_m": {"pressure_inside_soles": None if judged.least_inside is None else round(judged.least_inside, 5),
                     "nearest_pair": round(float(judged.apart.min()), 5)},
        "feet_up_s": ups(robot, judged), "feet_m": float(judged.feet_m), "feet_rad": float(judged.feet_rad),
        BROKEN: list(judged.broken), "joints": joints,
        "sha256": {name: hashlib.sha256(data).hexdigest() for name, data in (files | sources).items()},
    }  # fmt: skip


def _contract(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    if not judged.broken:
        return {".csv": motion_table(robot, judged)}
    lines = motion_table(robot, judged).decode().splitlines()
    return {".csv": "".join(f"{line},{BROKEN if k == 0 else 1}\n" for k, line in enumerate(lines)).encode()}


def _hrpsys(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    if not np.isfinite(judged.pressure).all():
        when = float(judged.time[~np.isfinite(judged.pressure[:, 0])][0])
        detail = "the feet carry too little for a centre of pressure, which hrpsys asks for"
        advice = "Export it as mc_rtc or csv, or plan it anew"
        raise BadMotion(Fault(detail, "no_pressure", advice, robot.name, value=f"{when:.3f} s"))
    place, turn = _base(robot, judged)
    rpy = np.unwrap(np.stack([pin.rpy.matrixToRpy(R) for R in turn]), axis=0)
    pressure = np.einsum("tji,tj->ti", turn, judged.pressure - place)
    rows = {
        ".pos": judged.q[:, robot.base :], ".vel": judged.dq[:, robot.base :], ".zmp": pressure,
        ".waist": np.concatenate([place, rpy], axis=1), ".hip": rpy,
    }  # fmt: skip
    if not judged.stands.all():
        rows[".stands"] = judged.stands.astype(np.float64)
    files = {ending: _blanks(judged.time, values) for ending, values in rows.items()}
    return files | ({f".{BROKEN}": "\n".join([*judged.broken, ""]).encode()} if judged.broken else {})


def _mc_rtc(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    lifts = not judged.stands.all()
    names = ["t", *(f"qOut_{k}" for k in range(len(robot.joints)))]
    names += [f"{STANDS}{sole.link}" for sole in robot.soles if lifts] + ([BROKEN] if judged.broken else [])
    marks = np.ones((len(judged.time), int(bool(judged.broken))))
    stands = judged.stands.astype(np.float64) if lifts else marks[:, :0]
    rows = np.column_stack([judged.time, judged.q[:, robot.base :], stands, marks])
    return {".csv": csv_table(names, np.round(rows, 8).tolist()).replace(b",", b";")}


def _points(robot: MotionRobot, motion: Trajectory, judged: Judged) -> list[tuple[int, list[list[float]]]]:
    """Nanoseconds, then positions, velocities, accelerations of each sample."""
    _, _, a = motion.at(judged.time)
    rows = (each[:, robot.base :] for each in (judged.q, judged.dq, a))
    stamps = np.round(judged.time * 1e9).astype(np.int64).tolist()
    return list(zip(stamps, np.round(np.stack(list(rows), axis=1), 8).tolist(), strict=True))


def _ros_yaml(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    head = {"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}, "joint_names": list(robot.joints)}
    told = [*(f"{BROKEN}: {line}" for line in judged.broken), *_lifts(robot, judged)]
    lines = [*(f"# {line}\n" for line in told), yaml.safe_dump(head, sort_keys=False), "points:\n"]
    for stamp, (q, v, a) in _points(robot, motion, judged):
        lines += [f"- positions: {q}\n  velocities: {v}\n  accelerations: {a}\n  effort: []\n",
                  f"  time_from_start: {{sec: {stamp // 10**9}, nanosec: {stamp % 10**9}}}\n"]  # fmt: skip
    return {".yaml": "".join(lines).encode()}


def _ros_mcap(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](0, 0)
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            *(np.array(each) for each in rows), np.zeros(0),
            types["builtin_interfaces/msg/Duration"](at // 10**9, at % 10**9),
        ) for at, rows in _points(robot, motion, judged)
    ]  # fmt: skip
    frame = BROKEN if judged.broken else ""
    kind = "trajectory_msgs/msg/JointTrajectory"
    message = types[kind](types["std_msgs/msg/Header"](stamp, frame), list(robot.joints), points)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "motion"
        with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            topic = writer.add_connection(TOPIC, kind, typestore=store)
            writer.write(topic, 0, store.serialize_cdr(message, kind))
            for f, sole in enumerate(robot.soles if not judged.stands.all() else ()):
                says, stands = "std_msgs/msg/Bool", judged.stands[:, f]
                topic = writer.add_connection(f"{FEET}/{sole.link}", says, typestore=store)
                for t in [0, *(1 + np.flatnonzero(np.diff(stands)))]:
                    raw = store.serialize_cdr(types[says](bool(stands[t])), says)
                    writer.write(topic, round(judged.time[t] * 1e9), raw)
        (file,) = bag.glob("*.mcap")
        return {".mcap": file.read_bytes()}


def _mujoco(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    q, v = judged.q[:, robot.base :], judged.dq[:, robot.base :]
    if robot.floating:
        place, turn = _base(robot, judged)
        quaternion = np.stack([pin.Quaternion(R).coeffs()[[3, 0, 1, 2]] for R in turn])
        flips = np.sign(np.einsum("ti,ti->t", quaternion[1:], quaternion[:-1]))
        quaternion[1:] *= np.cumprod(np.where(flips < 0.0, -1.0, 1.0))[:, None]
        rates = np.empty((len(q), 6))
        for t in range(len(q)):
            pin.forwardKinematics(robot.model, robot.data, judged.q[t], judged.dq[t])
            own = robot.data.v[robot.base]
            rates[t] = np.concatenate([turn[t] @ own.linear, own.angular])
        q, v = np.concatenate([place, quaternion, q], axis=1), np.concatenate([rates, v], axis=1)
    sink = io.BytesIO()
    np.savez(sink, time=judged.time, qpos=q, qvel=v, joint_names=np.array(robot.joints),
             feet=np.array([sole.link for sole in robot.soles], dtype=str), stands=judged.stands,
             broken=np.array(judged.broken, dtype=str))  # fmt: skip
    return {".npz": sink.getvalue()}


def _mot(robot: MotionRobot, motion: Trajectory, judged: Judged) -> Files:
    slides = np.array(["P" in joint.shortname() for joint in list(robot.model.joints)[1 + robot.base :]])
    values = np.where(slides, judged.q[:, robot.base :], np.degrees(judged.q[:, robot.base :]))
    size = [f"nRows={len(values)}", f"nColumns={1 + len(robot.joints)}"]
    head = [robot.name, "version=1", *size, "inDegrees=yes", *(f"{BROKEN}: {line}" for line in judged.broken)]
    head += _lifts(robot, judged)
    rows = ("\t".join([f"{t:.8f}", *(f"{x:.10g}" for x in row)]) for t, row in zip(judged.time, values, strict=True))
    return {".mot": ("\n".join([*head, "endheader", "\t".join(["time", *robot.joints]), *rows]) + "\n").encode()}


def _lifts(robot: MotionRobot, judged: Judged) -> list[str]:
    """A line for each foot that lifts, where a format has no column for it."""
    return [f"{STANDS}{link}: 0 " + ", ".join(f"from {a:g} to {b:g} s" for a, b in spans) + ", else 1"
            for link, spans in ups(robot, judged).items()]  # fmt: skip


def _blanks(time: Array, values: Array) -> bytes:
    rows: Sequence[Sequence[float]] = np.column_stack([time, values]).tolist()
    return "".join(" ".join(f"{x:.8f}" for x in row) + "\n" for row in rows).encode()


def _base(robot: MotionRobot, judged: Judged) -> tuple[Array, Array]:
    """(T, 3) [m] and (T, 3, 3), world from the URDF's root link."""
    out = []
    for q in judged.q:
        pin.forwardKinematics(robot.model, robot.data, q)
        out.append((robot.data.oMi[robot.base].translation.copy(), robot.data.oMi[robot.base].rotation.copy()))
    place, turn = (np.stack(each) for each in zip(*out, strict=True))
    return place, turn


Write = Callable[[MotionRobot, Trajectory, Judged], Files]
FORMATS: dict[str, tuple[Write, str]] = {
    "csv": (_contract, "t [s], q.<joint> [rad, m]; where a foot lifts, stands.<link> of every foot, 0 while it is up"),
    "hrpsys": (_hrpsys, "each line: time [s], then .pos [rad], .vel [rad/s] of the joints in the order of `joints`; "
               ".zmp [m] in the root link's axes from its origin; .waist [m, rad] x y z roll pitch yaw of the root "
               "link in the world (z up, floor at 0); .hip roll pitch yaw [rad], which hrpsys reads before .waist; "
               "where a foot lifts, .stands of every foot in the order of the soles, 0 while it is up, which hrpsys "
               "does not read"),
    "mc_rtc": (_mc_rtc, "t [s]; qOut_<k> [rad, m] of the joints in the order of `joints`; the base is not in it; "
               "where a foot lifts, stands.<link> of every foot, 0 while it is up"),
    "ros2-yaml": (_ros_yaml, "trajectory_msgs/JointTrajectory [rad, rad/s, rad/s²; m …]; of a foot that lifts, a "
                  "comment with its times"),
    "ros2-mcap": (_ros_mcap, f"one trajectory_msgs/msg/JointTrajectory on {TOPIC} [rad, rad/s, rad/s²; m …]; where a "
                  f"foot lifts, std_msgs/msg/Bool on {FEET}/<link> of every foot, at 0 and at each change"),
    "mujoco": (_mujoco, "qpos: x y z [m] and quaternion w x y z of the root link in the world, then joints in the "
               "order of joint_names [rad, m]; qvel: its linear velocity in the world, angular in its own axes, "
               "then joints; stands: which of `feet` do, sample by sample"),
    "mot": (_mot, "time [s], joints [degrees, m]; of a foot that lifts, a line of the head with its times"),
}  # fmt: skip
