"""A whole study folder: robot, logs, study file, and beside them the truth that no evaluating code opens."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml
from numpy.typing import NDArray

from exogauge.errors import BadInput, Fault
from exogauge.synthetic import motion
from exogauge.synthetic.hidden import parse_hidden
from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES, NAME
from exogauge.synthetic.sensors import encoder, noisy
from exogauge.synthetic.simulation import LOG_RATE_HZ, Recording, simulate
from exogauge.synthetic.true_robot import TrueRobot, a_priori_robot, draw_robot, truth_record
from exogauge.synthetic.urdf import robot_file, robot_urdf

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]

_MOTIONS = {"excitation": motion.excitation, "bend": motion.bend, "twist": motion.twist}


@final
@dataclass(frozen=True)
class LogPlan:
    """One log to make. motion: a key of `_MOTIONS`; role, name: as in study.yaml."""

    name: str
    role: str
    motion: str
    duration_s: float


LOGS = (
    LogPlan("id_1", "identification", "excitation", 50.0),
    LogPlan("id_2", "identification", "excitation", 50.0),
    LogPlan("id_3", "identification", "excitation", 50.0),
    LogPlan("id_4", "identification", "excitation", 50.0),
    LogPlan("val_1", "validation", "excitation", 25.0),
    LogPlan("val_2", "validation", "excitation", 25.0),
    LogPlan("bend_plain", "validation", "bend", 25.0),
    LogPlan("twist_plain", "validation", "twist", 25.0),
)


def write_study(
    out: Path,
    seed: int,
    hidden: Sequence[str] = (),
    suit: str = "none",
    progress: Progress | None = None,
    logs: Sequence[LogPlan] = LOGS,
) -> None:
    """Write a synthetic study of `hrp4_like` into `out`; the same seed gives the same numbers.

    hidden: `EFFECT@PLACE` put into the true robot and not into the a-priori one. suit: "none".
    progress: called with the share done (0 to 1) and what is being done. logs: which ones, all by default.
    """
    if suit != "none":
        detail, advice = f"a sample with suit {suit!r} cannot be made", "This version knows suit `none`"
        raise BadInput(Fault(detail, "unknown_suit", advice, column="suit", value=suit))
    if seed < 0:
        raise BadInput(Fault("the seed must be 0 or more", "seed_negative", column="seed", value=str(seed)))
    effects = parse_hidden(hidden, _stream(seed, "hidden"))
    robot = draw_robot(_stream(seed, "robot"), effects)
    (out / "logs").mkdir(parents=True, exist_ok=True)
    _write_logs(out, robot, seed, logs, progress or (lambda share, what: None))
    (out / "robot.urdf").write_text(robot_urdf(), encoding="utf-8")
    _write_yaml(out / "robot.yaml", robot_file())
    (out / "README.txt").write_text(_readme(seed, logs), encoding="utf-8")
    truth = truth_record(robot, effects)
    (out / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    _write_yaml(out / "study.yaml", _study_file(seed, logs))  # last: a folder with it is whole


def _stream(seed: int, purpose: str) -> np.random.Generator:
    """Random numbers of their own for each purpose: leaving out a log or hiding an effect changes nothing else."""
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


def _write_logs(out: Path, robot: TrueRobot, seed: int, logs: Sequence[LogPlan], progress: Progress) -> None:
    planner, model = mujoco_model(a_priori_robot()), mujoco_model(robot)
    whole, done = sum(log.duration_s for log in logs), 0.0
    for log in logs:
        rng = _stream(seed, log.name)
        plan = _MOTIONS[log.motion](rng, log.duration_s, planner)
        before = done

        def tick(seconds: float, name: str = log.name, before: float = before) -> None:
            progress(min((before + seconds) / whole, 1.0), f"simulating {name}")

        recording = simulate(model, robot, plan, tick)
        _write_log(out / "logs" / f"{log.name}.parquet", recording, rng, seed)
        done += log.duration_s
    progress(1.0, "simulated")


def _write_log(path: Path, recording: Recording, rng: np.random.Generator, seed: int) -> None:
    """Contract columns; angles and time as float64, what carries sensor noise as float32."""
    columns = {"t": pa.array(recording.time)}
    columns |= {f"q.{name}": pa.array(a) for name, a in zip(JOINT_NAMES, encoder(recording.q).T, strict=True)}

    def add(names: Sequence[str], values: Array, kind: str) -> None:
        logged = noisy(values, kind, rng).astype(np.float32)
        columns.update({name: pa.array(column) for name, column in zip(names, logged.T, strict=True)})

    add([f"i.{name}" for name in JOINT_NAMES], recording.current, "i")
    add([f"acc.{axis}" for axis in "xyz"], recording.acc, "acc")
    add([f"gyro.{axis}" for axis in "xyz"], recording.gyro, "gyro")
    for foot, wrench in zip(FEET, np.moveaxis(recording.wrench, 1, 0), strict=True):
        add([f"ft.{foot}.f{axis}" for axis in "xyz"], wrench[:, :3], "force")
        add([f"ft.{foot}.m{axis}" for axis in "xyz"], wrench[:, 3:], "moment")
    label = {"exogauge": "SYNTHETIC: simulated with MuJoCo, measured on no robot", "seed": str(seed)}
    pq.write_table(pa.table(columns).replace_schema_metadata(label), path, compression="zstd")


def _study_file(seed: int, logs: Sequence[LogPlan]) -> dict[str, object]:
    entries = []
    for log in logs:
        entry = {"file": f"logs/{log.name}.parquet", "role": log.role}
        entries.append(entry if log.motion == "excitation" else {**entry, "motion": log.motion})
    return {"version": 1, "name": f"SYNTHETIC {NAME}, seed {seed}", "robot": "robot.yaml", "logs": entries}


def _write_yaml(path: Path, content: object) -> None:
    head = "# SYNTHETIC: written by `exogauge sample`, measured on no robot\n"
    path.write_text(head + yaml.safe_dump(content, sort_keys=False, width=120), encoding="utf-8")


def _readme(seed: int, logs: Sequence[LogPlan]) -> str:
    lines = [f"  logs/{log.name}.parquet  {log.duration_s:.0f} s, {log.motion}, {log.role}" for log in logs]
    return "\n".join(
        [
            "SYNTHETIC DATA. Nothing in this folder was measured on a robot.",
            "",
            f"Made by `exogauge sample --seed {seed}` with MuJoCo: `{NAME}`, a humanoid of our own drawn from what is",
            "published of HRP-4 (1.51 m, 39 kg, 34 joints), stands on both feet under a position controller.",
            f"Logs at {LOG_RATE_HZ:.0f} Hz from a simulation at 1 kHz, raw: no filter anywhere.",
            *lines,
            "robot.urdf and robot.yaml hold the a-priori robot. The robot that made the logs differs from it by",
            "what the standard deviations in robot.yaml say; it is written in truth.json, for scoring only.",
            "",
        ]
    )  # fmt: skip
