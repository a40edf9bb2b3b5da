"""What the child process is asked for: a log, or whether a URDF can be trusted."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

from exogauge.errors import BadLog, BadRobot, Fault, TooLarge
from exogauge.logs.mapping_rules import LogMapping
from exogauge.logs.model import Array, Log, Note
from exogauge.logs.reading import read_log
from exogauge.robots.urdf_check import MAX_BYTES as MAX_URDF_BYTES
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.sandbox.protocol import LOG, URDF

CHILD = "exogauge.sandbox.child"


@final
@dataclass(frozen=True)
class LogRequest:
    """paths: the name a user knows the file by -> where it lies; several only with a mapping.

    joints, motor_from_joint (J, J), rows, allow_gaps: as for `logs.mapping.read_mapped`. left_out: as for
    `logs.reading.read_log`, without a mapping.
    """

    name: str
    paths: Mapping[str, Path]
    mapping: LogMapping | None = None
    joints: Sequence[str] = ()
    motor_from_joint: Array | None = None
    rows: tuple[int, int] | None = None
    allow_gaps: bool = False
    left_out: str | None = None

    @property
    def size(self) -> int:
        """Bytes of its files."""
        return sum(path.stat().st_size for path in self.paths.values())

    def to_plain(self) -> dict[str, Any]:
        """As the child takes it."""
        matrix = self.motor_from_joint
        return {
            "name": self.name,
            "paths": {name: str(path.resolve()) for name, path in self.paths.items()},
            "mapping": None if self.mapping is None else self.mapping.to_plain(),
            "joints": list(self.joints),
            "motor_from_joint": None if matrix is None else matrix.tolist(),
            "rows": self.rows,
            "allow_gaps": self.allow_gaps,
            "left_out": self.left_out,
        }


@final
@dataclass(frozen=True)
class LogSummary:
    """t0, t1: first and last time [s]; rate_hz: median."""

    channels: tuple[str, ...]
    samples: int
    rate_hz: float
    t0: float
    t1: float


@final
@dataclass(frozen=True)
class RobotRequest:
    """joints: None = check the file alone, otherwise also load it as `robots.urdf.load_tree` does."""

    urdf: bytes
    joints: Sequence[str] | None = None
    base_link: str = ""
    floating: bool = False
    cut_frames: Sequence[str] = ()
    file: str = "robot.urdf"


@final
@dataclass(frozen=True)
class RobotSummary:
    """What loading gave; empty where only the file was checked. mass: of the moving bodies [kg]."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    mass: float | None


def parse_log(request: LogRequest, limits: Limits | None = None) -> Log:
    """The log in the files. Raises BadLog, TooLarge, Unavailable."""
    with tempfile.TemporaryDirectory(prefix="exogauge-") as folder:
        result = _ask_for_log(request, Path(folder), limits)
        return read_answer(Path(folder) / LOG, request, result)


def read_answer(path: Path, request: LogRequest, result: Mapping[str, Any]) -> Log:
    """The log that a child has written at `path`, with its notes of what it did."""
    log = read_log(path, request.name, allow_gaps=request.allow_gaps)
    return replace(log, notes=tuple(Note(**note) for note in result["notes"]))


def canonicalise(request: LogRequest, out: Path, limits: Limits | None = None) -> LogSummary:
    """The log in the files as canonical Parquet at `out`, which appears complete or not at all."""
    with tempfile.TemporaryDirectory(prefix=".exogauge-", dir=out.parent) as folder:
        result = _ask_for_log(request, Path(folder), limits)
        os.replace(Path(folder) / LOG, out)
    return LogSummary(
        tuple(result["channels"]), result["samples"], result["rate_hz"], float(result["t0"]), float(result["t1"])
    )


def check_robot(request: RobotRequest, limits: Limits | None = None) -> RobotSummary:
    """Whether the URDF can be trusted and loaded. Raises BadRobot, TooLarge, Unavailable."""
    if len(request.urdf) > MAX_URDF_BYTES:
        advice = "Leave meshes out of the URDF."
        raise TooLarge(Fault(f"a URDF may have {MAX_URDF_BYTES} bytes", "too_many_bytes", advice, request.file))
    with tempfile.TemporaryDirectory(prefix="exogauge-") as folder:
        (Path(folder) / URDF).write_bytes(request.urdf)
        options = {
            "joints": None if request.joints is None else list(request.joints),
            "base_link": request.base_link,
            "floating": request.floating,
            "cut_frames": list(request.cut_frames),
            "file": request.file,
        }
        result = ask(CHILD, "robot", options, Path(folder), limits or Limits(), BadRobot, file=request.file)
    return RobotSummary(tuple(result["bodies"]), tuple(result["joints"]), result["mass"])


def _ask_for_log(request: LogRequest, folder: Path, limits: Limits | None) -> dict[str, Any]:
    """The child's summary of the log that it left in `folder`."""
    if request.mapping is None and len(request.paths) != 1:
        advice = "Several files make one log only through a mapping."
        raise BadLog(Fault(f"{len(request.paths)} files without a mapping", "mapping_missing", advice))
    limits = limits or Limits.for_bytes(request.size)
    return ask(CHILD, "log", request.to_plain(), folder, limits, BadLog, file=", ".join(request.paths))
