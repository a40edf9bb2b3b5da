"""Entries of study.yaml's `logs` become Logs: contract columns directly, other files through their mapping."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadRobot, Fault
from exogauge.logs.mapping_rules import LogMapping, Values
from exogauge.logs.model import Log
from exogauge.sandbox import LogRequest, parse_log, parse_logs
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.contract import LogEntry, RobotFile
from exogauge.studies.intake.mapping_file import parse_mapping
from exogauge.studies.intake.yaml_file import MAX_BYTES

Array = NDArray[np.float64]


def read_entry(bundle: Bundle, entry: LogEntry, name: str, robot: RobotFile, motor_from_joint: Array) -> Log:
    """One log alone; arguments as for `log_request`."""
    return parse_log(log_request(bundle, entry, name, robot, motor_from_joint))


def read_entries(
    bundle: Bundle, entries: Mapping[str, LogEntry], robot: RobotFile, motor_from_joint: Array
) -> list[Log]:
    """entries: by the log's name. The faults of all files are told at once."""
    return parse_logs([log_request(bundle, entry, name, robot, motor_from_joint) for name, entry in entries.items()])


def log_request(bundle: Bundle, entry: LogEntry, name: str, robot: RobotFile, motor_from_joint: Array) -> LogRequest:
    """name: of the log. motor_from_joint: (J, J), NaN on the diagonal where robot.yaml gives no gear ratio."""
    paths = {file: bundle.path(file) for file in entry.file}
    if entry.mapping is None:
        return LogRequest(name, paths, rows=entry.rows)
    mapping = parse_mapping(bundle.read(entry.mapping, limit=MAX_BYTES), entry.mapping)
    joints = [joint.name for joint in robot.joints]
    gears = known_gears(mapping, robot, motor_from_joint, entry.mapping)
    return LogRequest(name, paths, mapping, joints, gears, entry.rows)


def known_gears(mapping: LogMapping, robot: RobotFile, motor_from_joint: Array, file: str) -> Array:
    """motor_from_joint without NaN; a gear ratio that the mapping needs and robot.yaml lacks is refused."""
    motor_side = {
        channel.partition(".")[2]
        for part in mapping.files
        for rule in part.rules
        if isinstance(rule, Values) and rule.side == "motor"
        for channel in rule.channels
    }
    unknown = np.isnan(np.diag(motor_from_joint))
    lacking = [joint.name for joint, gap in zip(robot.joints, unknown, strict=True) if gap and joint.name in motor_side]
    if lacking:
        detail = f"{file} reads motor-side values of joints without gear_ratio: {', '.join(lacking)}"
        raise BadRobot(Fault(detail, "no_gear_ratio", "Give their gear_ratio in robot.yaml.", column="joints"))
    return np.where(np.isnan(motor_from_joint), 1.0, motor_from_joint)
