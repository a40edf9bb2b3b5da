"""The child process that opens an uploaded bundle: study, robot, device, payload or log. Its one answer is a summary
or the faults.

Asked by `checking` in a temporary folder of its own.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exogauge.sandbox.answering import Tasks

if TYPE_CHECKING:
    from exogauge.logs.model import Log


def study(folder: str) -> dict[str, Any]:
    """study.yaml, what it names, and every log from its first row to its last; few logs in memory at a time."""
    from exogauge.errors import BadInput, BadLog, Fault
    from exogauge.sandbox import LogRequest, read_each
    from exogauge.studies.intake.open import missing_columns, open_study
    from exogauge.studies.intake.read_log import log_request
    from exogauge.studies.intake.robot_file import motor_from_joint

    with open_study(Path(folder)) as opened:
        entries = dict(zip(opened.log_names, opened.file.logs, strict=True))
        requests, faults = list[LogRequest](), list[Fault]()
        gears = motor_from_joint(opened.robot_file)
        for name, entry in entries.items():
            try:
                requests.append(log_request(opened.bundle, entry, name, opened.robot_file, gears))
            except BadInput as bad:
                faults += bad.faults

        def look(read: Log) -> tuple[dict[str, Any], list[Fault]]:
            return span(read), missing_columns(read, opened.robot, entries[read.name].file[0])

        spans = list[dict[str, Any]]()
        for found in read_each(requests, look):
            if isinstance(found, BadInput):
                faults += found.faults
            else:
                spans.append(found[0])
                faults += found[1]
        if faults:
            raise BadLog(faults)
        logs = [
            {"name": name, "file": list(entry.file), "role": entry.role, "motion": entry.motion, "device": worn} | seen
            for (name, entry), worn, seen in zip(entries.items(), opened.log_devices, spans, strict=True)
        ]
        return {
            "name": opened.name,
            "robot": {"file": opened.file.robot, **about(opened.robot)},
            "devices": [{"file": file, **worn_by(opened.robot, each)} for file, each in opened.devices.items()],
            "warnings": [each.sentence for each in opened.notices],
            "logs": logs,
            "steps": [vars(step) for step in opened.steps],
        }


def robot(folder: str, file: str) -> dict[str, Any]:
    from exogauge.studies.device_pages.robot_model import robot_model
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.robot_file import read_robot

    described, entry, _ = read_robot(Bundle(Path(folder), file), file)
    planned = {"soles": len(entry.soles), "human_map": sorted(entry.human_map), "home": bool(entry.home)}
    return {"urdf": entry.urdf, **about(described), "motion": planned, "model": robot_model(described, entry)}


def device(folder: str, file: str, robot_folder: str) -> dict[str, Any]:
    """The device `file`, whose via points are on links of the robot that `robot_folder` holds."""
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.device_check import device_doubts
    from exogauge.studies.intake.device_file import read_device
    from exogauge.studies.intake.robot_file import load_robot

    wearer = load_robot(Path(robot_folder))
    bundle = Bundle(Path(folder), file)
    read = read_device(bundle, file, wearer)
    doubts = device_doubts(bundle, file, wearer, read)
    return {
        **worn_by(wearer, read),
        "robot": wearer.name,
        "warnings": [vars(doubt) for doubt in doubts],
        "reads": [each.file for each in bundle.inputs],
    }


def payload(folder: str) -> dict[str, Any]:
    """payload.yaml, every log from its first row to its last, and the robot of its plan at home."""
    from exogauge.errors import BadStudy, Fault
    from exogauge.payload.intake import open_payload, summary

    opened = open_payload(Path(folder))
    if opened.file.plan is not None:
        from exogauge.payload.planning.plan import open_plan  # and all that finds motions

        open_plan(Path(folder))
    elif not opened.recordings:
        advice = "Name `logs` to identify it, or add `plan`."
        raise BadStudy(Fault("there is nothing to identify and nothing to plan", "no_logs", advice, opened.name))
    return summary(opened)


def log(folder: str, file: str, mapping: str | None, robot: str | None) -> dict[str, Any]:
    """The log `file`, read through `mapping` where given; with a robot's joints and gears, else with the mapping's own
    joint names and gears of 1 (enough to find what is broken, not to evaluate)."""
    import numpy as np

    from exogauge.logs.mapping import read_mapped
    from exogauge.logs.reading import read_log
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.mapping_file import parse_mapping
    from exogauge.studies.intake.read_log import known_gears
    from exogauge.studies.intake.robot_file import motor_from_joint, read_robot

    here = Path(folder)
    if mapping is None:
        return told(read_log(here / file, file, file=file), file)
    rules = parse_mapping((here / mapping).read_bytes(), mapping)
    if robot is None:
        joints = joints_of(rules)
        gears = np.eye(len(joints))
    else:
        _, entry, _ = read_robot(Bundle(here, robot), robot)
        joints = [joint.name for joint in entry.joints]
        gears = known_gears(rules, entry, motor_from_joint(entry), mapping)
    return told(read_mapped({file: here / file}, rules, joints=joints, motor_from_joint=gears, name=file), file)


def told(read: Any, file: str) -> dict[str, Any]:
    """Its channels and clock, or BadLog where the unit of time must be wrong."""
    from exogauge.errors import BadLog
    from exogauge.studies.intake.admit import impossible_rate

    if wrong := impossible_rate(read):
        raise BadLog([replace(fault, file=file) for fault in wrong])
    return {"channels": list(read.channels), **span(read)}


def joints_of(rules: Any) -> list[str]:
    """Joint names that a mapping speaks of, in its order."""
    channels = [name for part in rules.files for rule in part.rules for name in getattr(rule, "channels", ())]
    kinds = ("q", "dq", "ddq", "i", "tau", "temp")
    named = (name.partition(".") for name in channels)
    return list(dict.fromkeys(joint for kind, _, joint in named if kind in kinds and joint))


def about(described: Any) -> dict[str, Any]:
    """A `Robot` in words a list can show."""
    return {
        "name": described.name,
        "base": "floating" if described.floating else "fixed",
        "joints": [joint.name for joint in described.joints],
        "sensors": [sensor.name for sensor in described.sensors],
        "mass_kg": float(described.tree.mass),
    }


def worn_by(wearer: Any, worn: Any) -> dict[str, Any]:
    """A `Device` on a `Robot`, in words a list can show.

    joints: that any band passes. …_at_zero: with all joints at zero. arm_m: change of the band's length with the joint
    [m/rad, or 1]; pulls: which way it pulls what the joint carries.
    """
    from exogauge.devices.routing import Routing
    from exogauge.studies.intake.device_check import check_device

    check = check_device(wearer, worn)
    bands = [
        {
            "name": band.name,
            "group": band.group,
            "links": [point.link for point in band.via_points],
            "stiffness_n_per_m": band.stiffness,
            "natural_length_m": band.natural_length,
            "ground_truth": band.ground_truth,
            "law": band.law,
            "bench_points": None if band.bench is None else len(band.bench.length),
            "length_at_zero_m": found.length,
            "tension_at_zero_n": found.tension,
            "arms_at_zero": [{"joint": each.joint, "arm_m": each.arm, "pulls": each.way} for each in found.arms],
        }
        for band, found in zip(worn.bands, check.bands, strict=True)
    ]
    return {
        "name": worn.name,
        "groups": list(worn.groups),
        "joints": list(Routing(wearer.tree, worn.bands).joints),
        "bands": bands,
        "torque_at_zero_n_m": check.torque,
        "notes": list(check.notes),
    }


def span(read: Any) -> dict[str, Any]:
    duration_s = float(read.time[-1] - read.time[0])
    return {"samples": int(read.samples), "rate_hz": float(read.rate_hz), "duration_s": duration_s}


TASKS: Tasks = {"study": study, "robot": robot, "device": device, "payload": payload, "log": log}
LOADED = ("exogauge.studies.intake.admit", "exogauge.studies.intake.open", "exogauge.studies.intake.read_log")
