"""The child process that draws a log of a stored study, a robot at rest, or a payload on its robot: it reads what was
uploaded, and leaves one packed scene.

Asked by `drawing` in a temporary folder of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import Tasks

SCENE = "log.scene"


def recording(folder: str, log: str, series: str | None, results: str) -> dict[str, Any]:
    """folder: the study's files. series: the log's series file, if it has one. results: results.json."""
    import json

    from exogauge.scene.recording import record
    from exogauge.scene.take import take
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.mesh_files import mesh_opener
    from exogauge.studies.series.recorded_motion import read_logged

    logged = read_logged(Bundle(Path(folder), "study.yaml"), log)
    found = take(logged, None if series is None else Path(series), json.loads(Path(results).read_bytes()))
    Path(SCENE).write_bytes(record(found, log, mesh_opener(Path(folder))))
    return {}


def still(robot_folder: str, device_folder: str | None) -> dict[str, Any]:
    """The robot that robot_folder/robot.yaml describes, wearing what device_folder/device.yaml does."""
    from exogauge.scene.recording import draw_still
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.device_file import read_device
    from exogauge.studies.intake.mesh_files import mesh_opener
    from exogauge.studies.intake.robot_file import read_robot

    robot, _, urdf = read_robot(Bundle(Path(robot_folder), "robot.yaml"), "robot.yaml")
    file = "device.yaml"
    device = None if device_folder is None else read_device(Bundle(Path(device_folder), file), file, robot)
    Path(SCENE).write_bytes(draw_still(robot, urdf, device, mesh_opener(Path(robot_folder))))
    return {}


def payload(folder: str, results: str | None, postures: str | None) -> dict[str, Any]:
    """folder: the payload's files. results: its results.json, postures: a plan's postures.csv, where there are any."""
    import csv

    import numpy as np

    from exogauge.payload.contract import PayloadFile
    from exogauge.payload.exports.body import body_of
    from exogauge.payload.exports.formats import read_results
    from exogauge.payload.planning.plan import caps_of
    from exogauge.robots.description import Joint, Robot
    from exogauge.robots.urdf import load_tree
    from exogauge.scene.payload_view import draw_payload
    from exogauge.studies.intake.mesh_files import mesh_opener
    from exogauge.studies.intake.yaml_file import load_yaml

    here = Path(folder)
    file = load_yaml((here / "payload.yaml").read_bytes(), PayloadFile, file="payload.yaml")
    pose, plan, joints = file.pose, file.plan, list(file.pose.joints or ())
    urdf = (here / str(pose.urdf)).read_bytes()
    tree = load_tree(urdf, joints=joints, base_link=str(pose.base_link), floating=False, file=str(pose.urdf))
    robot = Robot(file.name, tree, tuple(Joint(name, "none") for name in joints), None, (), np.eye(len(joints)))
    home = np.array([plan.home[name] for name in joints]) if plan else np.zeros(len(joints))
    caps = caps_of(plan) if plan else ()
    ghosts = None
    if postures is not None:
        with Path(postures).open(encoding="utf-8", newline="") as table:
            ghosts = np.array([[float(row[f"q.{name}"]) for name in joints] for row in csv.DictReader(table)])
    found = None if results is None else read_results(Path(results))
    body = None if found is None else body_of(found)
    touches = [] if found is None else [np.array(each.force_n) for log in found.contacts.values() for each in log]
    scene = draw_payload(robot, urdf, mesh_opener(here), file.sensor.frame or "", home, caps, ghosts, body, touches)
    Path(SCENE).write_bytes(scene)
    return {}


def played(robot_folder: str, played: str, figure: str | None) -> dict[str, Any]:
    """A plan: robot_folder/robot.yaml, what its job left to draw, and of the person, where one was captured."""
    from exogauge.motion.figure import read_figure
    from exogauge.motion.played import Played
    from exogauge.motion.robot_file import load_motion_robot
    from exogauge.scene.motion_view import draw_played
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.mesh_files import mesh_opener
    from exogauge.studies.intake.robot_file import read_robot

    folder = Path(robot_folder)
    robot, _, urdf = read_robot(Bundle(folder, "robot.yaml"), "robot.yaml")
    joints = load_motion_robot(folder / "robot.yaml").joints
    person = None if figure is None else read_figure(Path(figure))
    Path(SCENE).write_bytes(draw_played(robot, urdf, mesh_opener(folder), Played.read(Path(played)), joints, person))
    return {}


def captured(folder: str, figure: str | None) -> dict[str, Any]:
    """The motion in `folder`. figure: of a body that was fitted to it."""
    from exogauge.motion.figure import figure_of, read_figure
    from exogauge.motion.intake import open_capture
    from exogauge.scene.motion_view import draw_captured

    shown = figure_of(open_capture(Path(folder)).motion) if figure is None else read_figure(Path(figure))
    Path(SCENE).write_bytes(draw_captured(shown))
    return {}


TASKS: Tasks = {"recording": recording, "still": still, "payload": payload, "played": played, "captured": captured}
LOADED = ("exogauge.scene.recording", "exogauge.scene.take", "exogauge.studies.series.recorded_motion")
