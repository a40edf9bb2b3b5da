"""What one log shows, brought to the frames of a recording: motion, bands, torques, contact forces, doubtful joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.devices.device import Device
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.errors import BadInput
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.scene.frames import Frames
from exogauge.studies.series.recorded_motion import LoggedRobot
from exogauge.studies.words.names import effect_words

Array = NDArray[np.float64]

SETTLE_S = 0.5  # over which the accelerometer is averaged to tell where down is
POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
WRENCH = ("fx", "fy", "fz")


@final
@dataclass(frozen=True)
class Take:
    """F frames of a log, J joints.

    q: (F, J) [rad or m]. base: (F, 7) x, y, z [m], qx, qy, qz, qw of the base link in the world, None where not logged.
    up: (F, 3) away from gravity in the base link, None where no accelerometer tells. force: sensor -> (F, 3) [N] on the
    robot, sensor frame. torque, support: joint -> (F,) [N·m] of the joint itself, and by the device. tension: band ->
    (F,) [N], only of bands whose tension is known. marked: joint -> what the model does not explain there.
    """

    robot: Robot
    urdf: bytes
    frames: Frames
    q: Array
    base: Array | None
    up: Array | None
    force: Mapping[str, Array]
    device: Device | None
    tension: Mapping[str, Array]
    torque: Mapping[str, Array]
    support: Mapping[str, Array]
    marked: Mapping[str, str]


def take(logged: LoggedRobot, series: Path | None, results: Mapping[str, Any]) -> Take:
    """series: what a job found for this log, on the log's own times. results: the job's results.json."""
    log, robot = logged.log, logged.robot
    frames = Frames.of(float(log.time[0]), float(log.time[-1]), log.samples)
    shown = frames.nearest(log.time)
    found = {} if series is None else _at_frames(series, frames)
    q = log.stack([f"q.{joint}" for joint in robot.tree.joints])[shown]
    tension = _part(found, "band.", ".tension")
    if logged.device is not None and not tension:
        tension = _nominal_tension(robot, logged.device, q, frames)
    return Take(
        robot=robot,
        urdf=logged.urdf,
        frames=frames,
        q=q,
        base=_columns(log, [f"base.{axis}" for axis in POSE], shown),
        up=_up(log, robot, shown),
        force=_forces(log, robot, shown),
        device=logged.device,
        tension=tension,
        torque=_part(found, "measured.tau."),
        support=_part(found, "support_b."),
        marked=marked_joints(results, robot.tree.joints),
    )


def marked_joints(results: Mapping[str, Any], joints: Sequence[str]) -> dict[str, str]:
    """Joint -> the effect, in words, that the results say is missing there."""
    findings = (results.get("discrepancy") or {}).get("findings") or []
    marked: dict[str, str] = {}
    for finding in findings:
        joint = (finding.get("where") or {}).get("joint")
        if joint in joints:
            marked.setdefault(str(joint), effect_words(str(finding.get("effect", ""))))
    return marked


def _at_frames(series: Path, frames: Frames) -> dict[str, Array]:
    """Column -> (F,) values; 0 where a value is missing."""
    file = pq.ParquetFile(series)
    wanted = [
        name
        for name in file.schema_arrow.names
        if name == "t" or name.startswith(("measured.tau.", "support_b.", "band."))
    ]
    table = file.read(columns=wanted)
    shown = frames.nearest(table.column("t").to_numpy())
    columns = {name: table.column(name).to_numpy().astype(np.float64)[shown] for name in wanted}
    return {name: np.nan_to_num(values) for name, values in columns.items()}


def _part(found: Mapping[str, Array], start: str, end: str = "") -> dict[str, Array]:
    return {
        name.removeprefix(start).removesuffix(end): values
        for name, values in found.items()
        if name.startswith(start) and name.endswith(end)
    }


def _columns(log: Log, names: list[str], shown: NDArray[np.intp]) -> Array | None:
    if any(name not in log.channels for name in names):
        return None
    return log.stack(names)[shown]


def _up(log: Log, robot: Robot, shown: NDArray[np.intp]) -> Array | None:
    """The accelerometer, averaged, in the base link: away from gravity while the robot hardly accelerates."""
    names = [f"acc.{axis}" for axis in "xyz"]
    if robot.T_base_imu is None or any(name not in log.channels for name in names):
        return None
    averaged = _averaged(log.stack(names), max(round(SETTLE_S * log.rate_hz), 1))[shown]
    up = averaged @ np.asarray(robot.T_base_imu.rotation).T
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    return np.asarray(up)


def _forces(log: Log, robot: Robot, shown: NDArray[np.intp]) -> dict[str, Array]:
    """Contact forces on the robot, each frame the mean of the samples about it."""
    forces = {}
    span = max(len(log.time) // max(len(shown), 1), 1)
    for sensor in robot.sensors:
        names = [f"ft.{sensor.name}.{axis}" for axis in WRENCH]
        if sensor.role == "contact" and all(name in log.channels for name in names):
            forces[sensor.name] = sensor.sign * _averaged(log.stack(names), span)[shown]
    return forces


def _averaged(values: Array, span: int) -> Array:
    """(T, K) the mean of about `span` samples round each one, fewer at the ends."""
    total = np.vstack([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    here = np.arange(len(values))
    first, last = np.maximum(here - span // 2, 0), np.minimum(here + span // 2 + 1, len(values))
    mean: Array = (total[last] - total[first]) / (last - first)[:, None]
    return mean


def _nominal_tension(robot: Robot, device: Device, q: Array, frames: Frames) -> dict[str, Array]:
    """By the device file's own values; none where it does not give them."""
    try:
        found = band_torque(Routing(robot.tree, device.bands), device.bands, q, frames.times)
    except BadInput:
        return {}
    return {band.name: found.tension[:, k] for k, band in enumerate(device.bands)}
