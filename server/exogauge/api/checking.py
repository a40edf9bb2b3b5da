"""Ask a short-lived child process (`opening`) what an upload holds. The API process itself opens nothing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from exogauge.errors import BadInput, BadLog, BadRobot, BadStudy
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits

CHILD, OF_PAYLOADS = "exogauge.api.opening", "exogauge.api.opening_payload"
WORDS = {"look": "payload", "examine": "payload"}  # as the user knows what is read


def check_study(folder: Path) -> dict[str, Any]:
    """What the study in `folder` is, after reading every file it names. Raises BadInput with every place."""
    return _ask("study", folder, BadStudy)


def check_robot(folder: Path, file: str = "robot.yaml") -> dict[str, Any]:
    return _ask("robot", folder, BadRobot, file=file)


def check_device(folder: Path, robot_folder: Path, file: str = "device.yaml") -> dict[str, Any]:
    """What the device in `folder` is on the robot whose robot.yaml is in `robot_folder`, which was checked before."""
    return _ask("device", folder, BadStudy, file=file, robot_folder=str(robot_folder))


def check_payload(folder: Path) -> dict[str, Any]:
    """What the payload in `folder` is, after reading every log it names, and trying its plan's robot."""
    return _ask("payload", folder, BadStudy)


def look_at_payload(folder: Path, robots: Sequence[str], logs: Sequence[str]) -> dict[str, Any]:
    """Joints and frames of the URDFs, columns of the logs, and the faults of those that cannot be read."""
    return _ask("look", folder, BadStudy, OF_PAYLOADS, robots=list(robots), logs=list(logs))


def examine_payload(folder: Path) -> list[dict[str, Any]]:
    """What the doctor finds in the payload in `folder`, which was checked before."""
    try:
        findings: list[dict[str, Any]] = _ask("examine", folder, BadStudy, OF_PAYLOADS)["findings"]
    except BadInput as bad:  # of logs that were read: too long to examine, and no reason to refuse them
        said = {"rule": "not_examined", "advice": "`exogauge payload doctor` has no such limit"}
        nothing = {"log": "all", "severity": "note", "channel": "ft", "row": None, "value": None}
        return [nothing | said | {"detail": f"the logs were not examined: {bad.faults[0].detail}"}]
    return findings


def check_log(folder: Path, file: str, mapping: str | None = None, robot: str | None = None) -> dict[str, Any]:
    return _ask("log", folder, BadLog, file=file, mapping=mapping, robot=robot)


def _ask(task: str, folder: Path, error: type[BadInput], child: str = CHILD, /, **options: Any) -> dict[str, Any]:
    limits = Limits.for_bytes(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
    with TemporaryDirectory(prefix="exogauge-") as own:
        return ask(
            child, task, {"folder": str(folder), **options}, Path(own), limits, error, what=WORDS.get(task, task)
        )
