"""One entry of study.yaml's `logs` becomes a Log: contract columns directly, other files through their mapping."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadRobot, Fault
from exogauge.logs.mapping_rules import LogMapping, Values
from exogauge.logs.model import Log
from exogauge.sandbox import LogRequest, parse_log
from exogauge.studies.bundle import Bundle
from exogauge.studies.contract import LogEntry, RobotFile
from exogauge.studies.mapping_file import parse_mapping
from exogauge.studies.yaml_file import MAX_BYTES

Array = NDArray[np.float64]


def read_entry(bundle: Bundle, entry: LogEntry, name: str, robot: RobotFile, motor_from_joint: Array) -> Log:
    """name: of the log. motor_from_joint: (J, J), NaN on the diagonal where robot.yaml gives no gear ratio."""
    paths = {file: bundle.path(file) for file in entry.file}
    if entry.mapping is None:
        return parse_log(LogRequest(name, paths, rows=entry.rows))
    mapping = parse_mapping(bundle.read(entry.mapping, limit=MAX_BYTES), entry.mapping)
    joints = [joint.name for joint in robot.joints]
    gears = known_gears(mapping, robot, motor_from_joint, entry.mapping)
    return parse_log(LogRequest(name, paths, mapping, joints, gears, entry.rows))


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
