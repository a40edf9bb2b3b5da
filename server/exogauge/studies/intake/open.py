"""From a folder, a zip or a study.yaml to a robot, settings and recordings that fit together; and
when the logs were recorded: whether that tells what drifts meanwhile from the device.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self, final

from pydantic import ValidationError

from exogauge.devices.device import Device
from exogauge.effects.catalogue import all_effects
from exogauge.errors import BadLog, BadStudy, Fault
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.doctor import dead_moments
from exogauge.logs.model import Log
from exogauge.logs.segments import segments, with_beside
from exogauge.logs.whole_turns import in_one_course
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot, drifts_in_doubt
from exogauge.robots.urdf_check import (
    idle_joints,
    impossible_density,
    limits_in_degrees,
    masses_alike,
    raised_inertias,
)
from exogauge.studies.intake.bundle import Bundle, open_bundle
from exogauge.studies.intake.contract import STEPS, LogEntry, RobotFile, Role, SettingsEntry, StudyFile
from exogauge.studies.intake.expected import expectation
from exogauge.studies.intake.read_log import read_entries
from exogauge.studies.intake.robot_file import motor_from_joint, read_robot
from exogauge.studies.intake.worn_devices import read_devices, read_known_loads
from exogauge.studies.intake.yaml_file import MAX_BYTES, dotted, load_yaml, place, suggestion
from exogauge.studies.words.notices import Notice, notice
from exogauge.support.settings import SupportSettings, WornLog

NOTHING_HELD_OUT = "no log was held out (role validation or without_device), so nothing could be claimed"
MOTION_LIMITS = {"motion_doubtful": "doubtful", "motion_different": "different"}  # key in settings -> of the support's


@final
@dataclass(frozen=True)
class Step:
    """One step of a study: done, skipped for a reason, or failed for one."""

    step: str
    skipped: str | None = None
    failed: str | None = None


@final
@dataclass(frozen=True)
class LogMotion:
    """What a log shows: the name of its motion, None where study.yaml gives none, and what the log is for."""

    motion: str | None
    role: Role


@final
@dataclass(frozen=True)
class Study:
    """An opened study; a context manager, because a zip's unpacked copy goes when it ends.

    log_names: of `file.logs`, one each, unique: names of logs, channels' tables and series files.
    urdf: bytes of the robot's URDF. settings, support_settings: those of study.yaml with the caller's on top.
    devices: by file, in the order in which they are named. log_devices: the device file of each log, None where it
    wears none. notices: what looks like a slip in them, and inertias of the URDF that no body has.
    """

    bundle: Bundle
    file: StudyFile
    robot_file: RobotFile
    robot: Robot
    urdf: bytes
    settings: Settings
    log_names: tuple[str, ...]
    steps: tuple[Step, ...]
    support_settings: SupportSettings
    devices: Mapping[str, Device]
    log_devices: tuple[str | None, ...]
    notices: tuple[Notice, ...]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.bundle.close()

    @property
    def name(self) -> str:
        return self.file.name

    @property
    def motions(self) -> dict[str, LogMotion]:
        """By log name, in the order of study.yaml."""
        return {
            name: LogMotion(entry.motion, entry.role)
            for name, entry in zip(self.log_names, self.file.logs, strict=True)
        }


def open_study(path: Path, settings: Mapping[str, Any] | None = None) -> Study:
    """path: study.yaml, the folder that holds it, or a zip of the folder. settings: override those of study.yaml."""
    bundle = open_bundle(path)
    try:
        return _open(bundle, settings or {})
    except BaseException:
        bundle.close()
        raise


def _open(bundle: Bundle, overrides: Mapping[str, Any]) -> Study:
    name = bundle.study_file
    data = bundle.read(name, limit=MAX_BYTES)
    file = load_yaml(data, StudyFile, file=name)
    settings, support_settings = choose_settings(file.settings, overrides, name, data)
    for k, entry in enumerate(file.logs):
        for each in (*entry.file, *([entry.mapping] if entry.mapping else [])):
            bundle.path(each, named_in=name, column=f"logs.{k}", row=place(data, ("logs", k)))
    for k, plan in enumerate(file.plans):
        bundle.path(plan, named_in=name, column=f"plans.{k}", row=place(data, ("plans", k)))
    robot, robot_file, urdf = read_robot(bundle, file.robot, named_in=name, row=place(data, ("robot",)))
    names = log_names(file, name, data)
    robot = replace(robot, loads=tuple(read_known_loads(file, robot.tree, names, data, name)))
    worn = read_devices(bundle, file, robot, data)
    steps = _steps(file, worn.of_log, name, data)
    session = read_session(file, names, robot)
    return Study(
        bundle=bundle,
        file=file,
        robot_file=robot_file,
        robot=robot,
        urdf=urdf,
        settings=replace(settings, started=session.started),
        log_names=names,
        steps=steps,
        support_settings=replace(support_settings, started=session.started),
        devices=worn.devices,
        log_devices=worn.of_log,
        notices=(
            *map(notice, raised_inertias(urdf, robot_file.urdf)),
            *map(notice, impossible_density(urdf, robot_file.urdf, settings.criteria.doctor)),
            *map(notice, masses_alike(urdf, robot_file.urdf)),
            *map(notice, limits_in_degrees(urdf, robot_file.urdf, settings.criteria.doctor)),
            *map(notice, idle_joints(robot.tree, robot_file.urdf)),
            *worn.notices,
            *map(notice, session.remarks),
        ),
    )


def choose_settings(
    entry: SettingsEntry, overrides: Mapping[str, Any], file: str, data: bytes
) -> tuple[Settings, SupportSettings]:
    """Defaults, then study.yaml, then the caller's: those of the identification, and those of the support."""
    try:
        above = SettingsEntry.model_validate(dict(overrides))
    except ValidationError as invalid:
        known = list(SettingsEntry.model_fields)
        raise BadStudy(
            [
                Fault(
                    f"setting: {item['msg']}",
                    item["type"],
                    suggestion(str(item["loc"][0]), known) if item["type"] == "extra_forbidden" else "",
                    column=dotted(item["loc"]),
                    value=repr(item["input"])[:80],
                )
                for item in invalid.errors()
            ]
        ) from None
    chosen = {**entry.model_dump(exclude_none=True), **above.model_dump(exclude_none=True)}
    limits = {word: chosen.pop(key) for key, word in MOTION_LIMITS.items() if key in chosen}
    support = replace(SupportSettings(), **limits)
    if support.doubtful > support.different:
        detail = (
            f"motions count as different from {support.different:g} on, as doubtful only from {support.doubtful:g} on"
        )
        advice, row = "Give motion_doubtful below motion_different.", place(data, ("settings",))
        raise BadStudy(Fault(detail, "limits_crossed", advice, file, row, "settings"))
    if "effects" in chosen:
        known = sorted(all_effects())
        for k, effect in enumerate(chosen["effects"]):
            if effect not in known:
                row = place(data, ("settings", "effects", k))
                advice = suggestion(effect, known)
                raise BadStudy(
                    Fault("no such effect", "unknown_effect", advice, file, row, f"settings.effects.{k}", effect)
                )
        chosen["effects"] = tuple(chosen["effects"])
    return replace(Settings(), **chosen), support


def log_names(file: StudyFile, name: str, data: bytes) -> tuple[str, ...]:
    """The name given, else the (first) file's stem, with its rows where a file is used more than once."""
    stems = [_stem(entry) for entry in file.logs]
    names = []
    for entry, stem in zip(file.logs, stems, strict=True):
        rows = f"_{entry.rows[0]}_{entry.rows[1]}" if entry.rows and stems.count(stem) > 1 else ""
        names.append(entry.name or stem + rows)
    for k, each in enumerate(names):
        if each in names[:k]:
            row = place(data, ("logs", k))
            raise BadStudy(
                Fault(
                    f"two logs would be named {each!r}", "duplicate_log", "Give one a `name`.", name, row, f"logs.{k}"
                )
            )
    return tuple(names)


def _stem(entry: LogEntry) -> str:
    base = entry.file[0].rsplit("/", 1)[-1]
    for ending in (".gz", ".csv", ".parquet", ".txt", ".tsv", ".log"):
        base = base.removesuffix(ending)
    plain = "".join(sign if (sign.isalnum() and sign.isascii()) or sign in "_.+-" else "_" for sign in base)
    return plain.lstrip(".+-")[:80] or "log"


def _steps(file: StudyFile, log_devices: Sequence[str | None], name: str, data: bytes) -> tuple[Step, ...]:
    """identify always, as all else stands on it; stiffness asks for support; the rest is skipped and says why."""
    if not any(entry.role == "identification" for entry in file.logs):
        row = place(data, ("logs",))
        advice = "Give at least one log `role: identification`."
        raise BadStudy(Fault("no log to identify from", "no_identification_log", advice, name, row, "logs"))
    asked = {"identify", *(file.steps or STEPS)}
    if "stiffness" in asked:
        asked.add("support")
    no_support = None if any(log_devices) else "no log was recorded with the device on (role with_device)"
    held_out = any(entry.role in ("validation", "without_device") for entry in file.logs)
    no_claim = None if held_out else NOTHING_HELD_OUT
    why = {"support": no_support, "stiffness": no_support, "discrepancy": no_claim}
    return tuple(Step(step, why.get(step)) for step in STEPS if step in asked)


def read_recordings(study: Study) -> list[Recording]:
    """The logs that identification uses: fitted, or held out (validation, and motions without the device).

    Where they are parts of one recording, filters lean on the parts beside them: those of held-out logs on every
    part, those of fitted ones on fitted ones alone, so that nothing that is held out reaches a row of the fit.
    """
    entries = study.file.logs
    chosen = [k for k, entry in enumerate(entries) if entry.role != "with_device"]
    read = [(k, log, entries[k].role != "identification") for k, log in _read(study, chosen)]
    return [
        Recording(
            with_beside(
                log, [part for j, part, out in read if _one_recording(entries[j], entries[k]) and (held_out or not out)]
            ),
            held_out,
        )
        for k, log, held_out in read
    ]


def _one_recording(one: LogEntry, other: LogEntry) -> bool:
    return (one.file, one.mapping) == (other.file, other.mapping)


def read_worn(study: Study) -> list[WornLog]:
    """The logs with a device on; a motion without a name takes the log's own."""
    worn = [(k, file) for k, file in enumerate(study.log_devices) if file is not None]
    files = dict(worn)
    return [
        WornLog(log, study.file.logs[k].motion or log.recording, study.devices[files[k]])
        for k, log in _read(study, list(files))
    ]


def _read(study: Study, chosen: Sequence[int]) -> list[tuple[int, Log]]:
    """The chosen logs of study.yaml, cut at gaps in time and where a sensor is dead, each with its place there;
    whatever column is missing from any of them is told at once."""
    entries = {study.log_names[k]: study.file.logs[k] for k in chosen}
    logs = read_entries(study.bundle, entries, study.robot_file, motor_from_joint(study.robot_file))
    faults = [fault for log in logs for fault in missing_columns(log, study.robot, entries[log.name].file[0])]
    if faults:
        raise BadLog(faults)
    found, no_stretch, expected = list[tuple[int, Log]](), list[Fault](), expectation(study.robot)
    for k, log in zip(chosen, in_one_course(logs, expected.joints), strict=True):
        entry = study.file.logs[k]
        try:
            parts = segments(log, entry.rows[0] if entry.rows else 0, dead_moments(log, expected))
            found += [(k, part) for part in parts]
        except BadLog as bad:
            no_stretch += [replace(fault, file=entry.file[0]) for fault in bad.faults]
    if no_stretch:
        raise BadLog(no_stretch)
    return found


def needed_channels(robot: Robot) -> tuple[str, ...]:
    """Every channel that the robot's equations of motion need."""
    names = [f"q.{joint.name}" for joint in robot.joints]
    effort = {"current": "i", "torque": "tau"}
    names += [f"{effort[joint.actuation]}.{joint.name}" for joint in robot.joints if joint.actuation != "none"]
    if robot.floating:
        names += [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    for sensor in robot.sensors:
        names += [f"ft.{sensor.name}.{axis}" for axis in ("fx", "fy", "fz", "mx", "my", "mz")]
    return tuple(names)


def missing_columns(log: Log, robot: Robot, file: str) -> list[Fault]:
    """One fault per column that the robot needs and the log does not hold."""
    needed: Sequence[str] = needed_channels(robot)
    near = list(log.channels)
    return [
        Fault(
            f"log {log.name!r} lacks a column that the robot needs",
            "missing_column",
            suggestion(name, near) if len(near) < 200 else "",
            file,
            column=name,
        )
        for name in needed
        if name not in log.channels
    ]


@final
@dataclass(frozen=True)
class Session:
    """started: log -> [s] on one clock; empty where that is not said of every log. remarks: what is missing of it."""

    started: Mapping[str, float]
    remarks: tuple[Remark, ...] = ()


def read_session(file: StudyFile, names: Sequence[str], robot: Robot) -> Session:
    """Asks for nothing where no drift of motors is declared, or where no motion was recorded with and without."""
    entries = dict(zip(names, file.logs, strict=True))
    untold = tuple(name for name, entry in entries.items() if entry.started is None)
    started = {} if untold else {name: entry.started or 0.0 for name, entry in entries.items()}
    plain, worn = (
        {name: entry.motion for name, entry in entries.items() if entry.role in roles and entry.motion is not None}
        for roles in (("without_device", "validation"), ("with_device",))
    )
    both = [motion for motion in dict.fromkeys(worn.values()) if motion in plain.values()]
    if not both or not drifts_in_doubt(robot):
        return Session(started)
    if untold:
        return Session(started, (Remark(About.SESSION_UNKNOWN, untold),))
    late = tuple(motion for motion in both if _last(plain, started, motion) < _last(worn, started, motion))
    return Session(started, (Remark(About.NO_RUN_AFTER, late),) if late else ())


def _last(motions: Mapping[str, str | None], started: Mapping[str, float], motion: str) -> float:
    return max(started[name] for name, own in motions.items() if own == motion)
