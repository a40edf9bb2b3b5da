"""The joint positions of one log of a study, the robot, and the device to think about: all that a what-if needs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Device
from exogauge.errors import BadLog, BadStudy, Fault
from exogauge.logs.bandwidth import suggest_cutoff
from exogauge.logs.channels import parse_channel
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.sandbox import LogRequest, parse_log
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.contract import LogEntry, RobotFile, StudyFile
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.open import log_names
from exogauge.studies.intake.read_log import read_entry
from exogauge.studies.intake.robot_file import motor_from_joint, read_robot
from exogauge.studies.intake.yaml_file import MAX_BYTES, load_yaml, place, suggestion
from exogauge.studies.series.write import unit_of

Array = NDArray[np.float64]

STRETCH = re.compile(r"(.+)_(\d{1,12})_(\d{1,12})")
FEWEST_FILTERED = 32  # samples; a shorter log tells nothing of its bandwidth and stays as it is


@final
@dataclass(frozen=True)
class RecordedMotion:
    """T samples of a log, and a device on the robot that moved.

    q: (T, J) [rad or m], low-passed at cutoff_hz (None: as logged). time: (T,) [s]. of_samples: of the log; every: n-th
    of them kept. device_file: as study.yaml names it.
    """

    tree: RigidTree
    device: Device
    device_file: str
    log: str
    q: Array
    time: Array
    of_samples: int
    every: int
    cutoff_hz: float | None


@final
@dataclass(frozen=True)
class LoggedRobot:
    """A log as it was recorded, the robot that moved (urdf: the bytes of its URDF), and what it wore, if anything."""

    robot: Robot
    urdf: bytes
    log: Log
    device: Device | None


@final
@dataclass(frozen=True)
class _Opened:
    """A study as far as a what-if opens it. names: of the logs."""

    bundle: Bundle
    data: bytes
    file: StudyFile
    names: tuple[str, ...]
    robot: Robot
    robot_file: RobotFile
    urdf: bytes


def read_logged(bundle: Bundle, log: str) -> LoggedRobot:
    """log: a name in study.yaml; the tables of other logs need not be there. Raises BadStudy, BadRobot, BadLog."""
    study = _open(bundle)
    entry = _entry(study, log)
    worn = (entry.device or study.file.device) if entry.role == "with_device" else None
    device = None if worn is None else _read_device(study, worn)
    return LoggedRobot(study.robot, study.urdf, _read_entry(study, entry, log), device)


def read_raw(bundle: Bundle, log: str) -> tuple[Log, dict[str, str]]:
    """A log as its file and mapping say, and the unit of each channel. Raises BadStudy, BadRobot, BadLog."""
    study = _open(bundle)
    found, sliding = _read_entry(study, _entry(study, log), log), study.robot.tree.sliding
    return found, {name: unit_of(parse_channel(name), sliding) for name in found.channels}


def read_motion(
    bundle: Bundle, log: str | Path, device: str | Path | None = None, most: int | None = None
) -> RecordedMotion:
    """log: a name in study.yaml, or a file on this machine in the contract's columns. device: a file of the study, or
    one on this machine; default: what the log wears, else the study's. most: keep at most so many samples, evenly.

    Raises BadStudy, BadRobot, BadLog.
    """
    study = _open(bundle)
    entry = _entry(study, log) if isinstance(log, str) else None
    device = device or _device_of(study, entry)
    worn = _read_device(study, device)
    read = _read_entry(study, entry, str(log)) if entry is not None else _read_outside(Path(log))
    missing = [f"q.{joint}" for joint in study.robot.tree.joints if f"q.{joint}" not in read.channels]
    if missing:
        advice = suggestion(missing[0], list(read.channels)) if len(read.channels) < 200 else ""
        raise BadLog([Fault("the log lacks a joint's position", "missing_column", advice, read.name, column=each)
                      for each in missing])  # fmt: skip
    q, cutoff_hz = _low_passed(read, [f"q.{joint}" for joint in study.robot.tree.joints])
    every = 1 if most is None else -(-read.samples // most)
    return RecordedMotion(
        tree=study.robot.tree,
        device=worn,
        device_file=str(device),
        log=read.name,
        q=np.ascontiguousarray(q[::every]),
        time=np.ascontiguousarray(read.time[::every]),
        of_samples=read.samples,
        every=every,
        cutoff_hz=cutoff_hz,
    )


def _open(bundle: Bundle) -> _Opened:
    name = bundle.study_file
    data = bundle.read(name, limit=MAX_BYTES)
    file = load_yaml(data, StudyFile, file=name)
    robot, robot_file, urdf = read_robot(bundle, file.robot, named_in=name, row=place(data, ("robot",)))
    return _Opened(bundle, data, file, log_names(file, name, data), robot, robot_file, urdf)


def _entry(study: _Opened, log: str) -> LogEntry:
    """Of a log, or of the stretch of one that was cut at gaps (`logs.segments`): its rows."""
    stretch = STRETCH.fullmatch(log)
    if log not in study.names and stretch and stretch[1] in study.names:
        whole = study.file.logs[study.names.index(stretch[1])]
        return whole.model_copy(update={"rows": (int(stretch[2]), int(stretch[3]))})
    if log not in study.names:
        advice, file = suggestion(log, study.names), study.bundle.study_file
        raise BadStudy(Fault("the study has no log of this name", "unknown_log", advice, file, None, "log", log[:200]))
    return study.file.logs[study.names.index(log)]


def _device_of(study: _Opened, entry: LogEntry | None) -> str:
    """What the log wears; else the study's device, or the first that one of its logs wears."""
    named = [None if entry is None else entry.device, study.file.device, *(each.device for each in study.file.logs)]
    found = next((each for each in named if each is not None), None)
    if found is None:
        advice = "Name one: `device: device.yaml` in study.yaml, or ask for one of its files."
        raise BadStudy(Fault("the study names no device", "no_device", advice, study.bundle.study_file))
    return found


def _read_device(study: _Opened, file: str | Path) -> Device:
    if isinstance(file, Path):
        return read_device(Bundle(file.parent, file.name), file.name, study.robot)
    return read_device(study.bundle, file, study.robot, study.bundle.study_file)


def _read_entry(study: _Opened, entry: LogEntry, name: str) -> Log:
    for each in (*entry.file, *([entry.mapping] if entry.mapping else [])):
        k = study.names.index(name if name in study.names else name.rsplit("_", 2)[0])
        study.bundle.path(
            each, named_in=study.bundle.study_file, column=f"logs.{k}", row=place(study.data, ("logs", k))
        )
    return read_entry(study.bundle, entry, name, study.robot_file, motor_from_joint(study.robot_file))


def _read_outside(path: Path) -> Log:
    return parse_log(LogRequest(path.stem, {path.name: path}))


def _low_passed(log: Log, channels: list[str]) -> tuple[Array, float | None]:
    """Laws that take rates would follow the encoders' noise; what depends on the posture alone hardly changes."""
    q = log.stack(channels)
    if log.samples < FEWEST_FILTERED:
        return q, None
    cutoff_hz = suggest_cutoff(q, log.rate_hz)
    return LowPass(cutoff_hz, log.rate_hz).apply(q), cutoff_hz
