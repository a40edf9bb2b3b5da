"""Scenes drawn when they are first asked for, in a child process."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from exogauge.errors import BadStudy
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.scene.opening import SCENE

CHILD = "exogauge.scene.opening"


def draw_log(folder: Path, log: str, series: Path | None, results: Path) -> bytes:
    """folder: the study's files, results.json and the series beside it or elsewhere. Raises BadInput, Unavailable."""
    found = None if series is None else str(series)
    options = {"folder": str(folder), "log": log, "series": found, "results": str(results)}
    return _drawn("recording", options, folder, "study")


def draw_at_rest(folder: Path, robot: str, device: str | None) -> bytes:
    """robot, device: folders below `folder` that hold robot.yaml and device.yaml. Raises BadInput, Unavailable."""
    worn = None if device is None else str(folder / device)
    return _drawn("still", {"robot_folder": str(folder / robot), "device_folder": worn}, folder, "robot")


def draw_payload(folder: Path, results: Path | None, postures: Path | None) -> bytes:
    """folder: the payload's files; results.json and postures.csv elsewhere. Raises BadInput, Unavailable."""
    given = {name: None if path is None else str(path) for name, path in (("results", results), ("postures", postures))}
    return _drawn("payload", {"folder": str(folder), **given}, folder, "payload")


def draw_played(robot: Path, played: Path, figure: Path | None) -> bytes:
    """robot: folder of robot.yaml; what a job of a plan left to draw. Raises BadInput, Unavailable."""
    given = {"played": str(played), "figure": None if figure is None else str(figure)}
    return _drawn("played", {"robot_folder": str(robot), **given}, robot, "plan")


def draw_captured(folder: Path, figure: Path | None) -> bytes:
    """folder: the motion's files; figure: of a body that was fitted. Raises BadInput, Unavailable."""
    options = {"folder": str(folder), "figure": None if figure is None else str(figure)}
    return _drawn("captured", options, folder, "motion")


def _drawn(task: str, options: dict[str, Any], folder: Path, what: str) -> bytes:
    limits = Limits.for_bytes(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
    with TemporaryDirectory(prefix="exogauge-") as own:
        ask(CHILD, task, options, Path(own), limits, BadStudy, what=what)
        return (Path(own) / SCENE).read_bytes()
