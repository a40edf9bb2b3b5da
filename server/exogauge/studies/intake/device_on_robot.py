"""A device file, a robot and a log as a person names them on a command line, brought together and checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exogauge.errors import BadLog, BadRobot, BadStudy, Fault
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot
from exogauge.robots.urdf import load_tree
from exogauge.robots.urdf_check import MOVING_TYPES, read_urdf
from exogauge.sandbox import LogRequest, parse_log
from exogauge.studies.intake.bundle import Bundle, open_bundle
from exogauge.studies.intake.contract import StudyFile
from exogauge.studies.intake.device_check import DeviceCheck, check_device, device_doubts
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.open import log_names
from exogauge.studies.intake.read_log import read_entry
from exogauge.studies.intake.robot_file import MAX_URDF_BYTES, motor_from_joint, read_robot
from exogauge.studies.intake.yaml_file import MAX_BYTES, load_yaml


def check_device_file(
    device: Path, robot: Path | None = None, study: Path | None = None, log: Path | None = None
) -> DeviceCheck:
    """robot: a robot.yaml or a URDF; without one, that of the study. device: a file anywhere, or one of the study.

    log: one of the study by name or file, read as the study says; or any table with the joints' positions.
    Raises BadInput with every fault of the device file.
    """
    wearer = read_wearer(robot, study)
    opened = None if study is None else open_bundle(study)
    try:
        bundle, name = _holding(device, opened, robot)
        found = read_device(bundle, name, wearer)
        recorded = None if log is None else _read_log(log, opened)
        return check_device(wearer, found, recorded, device_doubts(bundle, name, wearer, found))
    finally:
        if opened is not None:
            opened.close()


def read_wearer(robot: Path | None, study: Path | None) -> Robot:
    """robot: a robot.yaml or a URDF; without one, the robot of the study. Raises BadInput."""
    if robot is not None:
        bundle = Bundle(robot.resolve().parent, "")
        if robot.suffix.lower() in (".yaml", ".yml"):
            return read_robot(bundle, robot.name)[0]
        return robot_of_urdf(bundle.read(robot.name, limit=MAX_URDF_BYTES), robot.name)
    if study is None:
        advice = "Give --robot ROBOT.yaml, --robot ROBOT.urdf or --study STUDY."
        raise BadStudy(Fault("a device is looked at on a robot", "no_robot", advice))
    opened = open_bundle(study)
    try:
        return read_robot(opened, _study_file(opened).robot, named_in=opened.study_file)[0]
    finally:
        opened.close()


def _holding(device: Path, study: Bundle | None, robot: Path | None) -> tuple[Bundle, str]:
    """The folder that the device file's own paths are relative to, and the file's name in it.

    It is the study's, or the robot's, where the file lies in it or below; else the file's own.
    """
    full = device.resolve()
    if study is not None and (full.is_relative_to(study.root) or not full.is_file()):
        return study, full.relative_to(study.root).as_posix() if full.is_relative_to(study.root) else str(device)
    if robot is not None and full.is_relative_to(robot.resolve().parent):
        root = robot.resolve().parent
        return Bundle(root, ""), full.relative_to(root).as_posix()
    return Bundle(full.parent, ""), full.name


def _study_file(bundle: Bundle) -> StudyFile:
    return load_yaml(bundle.read(bundle.study_file, limit=MAX_BYTES), StudyFile, file=bundle.study_file)


def _read_log(log: Path, study: Bundle | None) -> Log:
    if study is not None:
        file, data = _study_file(study), study.read(study.study_file, limit=MAX_BYTES)
        full = log.resolve()
        name = full.relative_to(study.root).as_posix() if full.is_relative_to(study.root) else log.as_posix()
        for entry, known_as in zip(file.logs, log_names(file, study.study_file, data), strict=True):
            if str(log) == known_as or name in entry.file:
                _, robot_file, _ = read_robot(study, file.robot, named_in=study.study_file)
                return read_entry(study, entry, known_as, robot_file, motor_from_joint(robot_file))
    if not log.is_file():
        raise BadLog(Fault("no such file", "missing_file", "", str(log)))
    return parse_log(LogRequest(log.name, {log.name: log}))


def robot_of_urdf(urdf: bytes, file: str) -> Robot:
    """Every joint that moves and mimics no other, in the URDF's order; the root link is the base, and stands still.

    Raises BadRobot.
    """
    description = read_urdf(urdf, file)
    joints = [
        joint.get("name", "")
        for joint in description.findall("joint")
        if joint.get("type") in MOVING_TYPES and joint.find("mimic") is None
    ]
    if not joints:
        raise BadRobot(Fault("no joint of the URDF moves, so no band can act on one", "no_joint", "", file))
    children = {child.get("link") for joint in description.findall("joint") for child in joint.findall("child")}
    names = [link.get("name", "") for link in description.findall("link")]
    root = next(name for name in names if name not in children)
    tree = load_tree(urdf, joints=joints, base_link=root, floating=False, file=file)
    return Robot(
        name=description.get("name") or file,
        tree=tree,
        joints=tuple(Joint(name, "none") for name in joints),
        T_base_imu=None,
        sensors=(),
        axes_from_joints=np.eye(len(joints)),
    )
