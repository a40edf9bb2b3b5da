"""The child process that draws a log of a stored study, or a robot at rest: it reads what was uploaded, and leaves one
packed scene.

Run by `drawing` as `python -I -m exogauge.scene.opening` in a temporary folder of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import serve

SCENE = "log.scene"


def recording(folder: str, log: str, series: str | None, results: str) -> dict[str, Any]:
    """folder: the study's files. series: the log's series file, if it has one. results: results.json."""
    import json

    from exogauge.scene.mesh_files import mesh_opener
    from exogauge.scene.recording import record
    from exogauge.scene.take import take
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.series.recorded_motion import read_logged

    logged = read_logged(Bundle(Path(folder), "study.yaml"), log)
    found = take(logged, None if series is None else Path(series), json.loads(Path(results).read_bytes()))
    Path(SCENE).write_bytes(record(found, log, mesh_opener(Path(folder))))
    return {}


def still(robot_folder: str, device_folder: str | None) -> dict[str, Any]:
    """The robot that robot_folder/robot.yaml describes, wearing what device_folder/device.yaml does."""
    from exogauge.scene.mesh_files import mesh_opener
    from exogauge.scene.still import draw_still
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.intake.device_file import read_device
    from exogauge.studies.intake.robot_file import read_robot

    robot, _, urdf = read_robot(Bundle(Path(robot_folder), "robot.yaml"), "robot.yaml")
    file = "device.yaml"
    device = None if device_folder is None else read_device(Bundle(Path(device_folder), file), file, robot)
    Path(SCENE).write_bytes(draw_still(robot, urdf, device, mesh_opener(Path(robot_folder))))
    return {}


if __name__ == "__main__":
    serve({"recording": recording, "still": still})
