"""Ask the child process, and turn whatever becomes of it into a result or an error that helps."""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from exogauge.errors import BadInput, BadLog, BadRobot, BadStudy, Fault, TooLarge, Unavailable
from exogauge.logs.mapping_rules import LogMapping
from exogauge.logs.model import Array, Log
from exogauge.logs.reading import read_log
from exogauge.robots.urdf_check import MAX_BYTES as MAX_URDF_BYTES
from exogauge.sandbox.limits import Limits
from exogauge.sandbox.protocol import ANSWER, LOG, URDF

log = logging.getLogger(__name__)

MAX_ANSWER = 8 << 20
_ERRORS: Mapping[str, type[BadInput]] = {
    each.__name__: each for each in (BadInput, BadLog, BadRobot, BadStudy, TooLarge)
}


@final
@dataclass(frozen=True)
class LogRequest:
    """paths: the name a user knows the file by -> where it lies; several only with a mapping.

    joints, motor_from_joint (J, J), rows, allow_gaps: as for `logs.mapping.read_mapped`.
    """

    name: str
    paths: Mapping[str, Path]
    mapping: LogMapping | None = None
    joints: Sequence[str] = ()
    motor_from_joint: Array | None = None
    rows: tuple[int, int] | None = None
    allow_gaps: bool = False


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
        _ask(_log_request(request), Path(folder), limits or _log_limits(request), BadLog, ", ".join(request.paths))
        return read_log(Path(folder) / LOG, request.name, allow_gaps=request.allow_gaps)


def canonicalise(request: LogRequest, out: Path, limits: Limits | None = None) -> LogSummary:
    """The log in the files as canonical Parquet at `out`, which appears complete or not at all."""
    with tempfile.TemporaryDirectory(prefix=".exogauge-", dir=out.parent) as folder:
        result = _ask(
            _log_request(request), Path(folder), limits or _log_limits(request), BadLog, ", ".join(request.paths)
        )
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
        plain = {
            "task": "robot",
            "joints": None if request.joints is None else list(request.joints),
            "base_link": request.base_link,
            "floating": request.floating,
            "cut_frames": list(request.cut_frames),
            "file": request.file,
        }
        result = _ask(plain, Path(folder), limits or Limits(), BadRobot, request.file)
    return RobotSummary(tuple(result["bodies"]), tuple(result["joints"]), result["mass"])


def _log_request(request: LogRequest) -> dict[str, Any]:
    if request.mapping is None and len(request.paths) != 1:
        advice = "Several files make one log only through a mapping."
        raise BadLog(Fault(f"{len(request.paths)} files without a mapping", "mapping_missing", advice))
    matrix = request.motor_from_joint
    return {
        "task": "log",
        "name": request.name,
        "paths": {name: str(path.resolve()) for name, path in request.paths.items()},
        "mapping": None if request.mapping is None else request.mapping.to_plain(),
        "joints": list(request.joints),
        "motor_from_joint": None if matrix is None else matrix.tolist(),
        "rows": request.rows,
        "allow_gaps": request.allow_gaps,
    }


def _log_limits(request: LogRequest) -> Limits:
    return Limits.for_bytes(sum(path.stat().st_size for path in request.paths.values()))


def _ask(request: dict[str, Any], folder: Path, limits: Limits, error: type[BadInput], file: str) -> dict[str, Any]:
    """The child's result. error: the class for a file that brings the child down."""
    request = {**request, "limits": dataclasses.asdict(limits)}
    code, trace = _run(json.dumps(request), folder, limits.wall_s, file)
    answer = _read_answer(folder / ANSWER)
    if code == 0 and "result" in answer:
        return dict(answer["result"])
    if code == 0 and answer.get("error") in _ERRORS:
        raise _ERRORS[answer["error"]]([Fault(**fault) for fault in answer["faults"]])
    stop = answer.get("error", "none")
    log.warning("reading %s: child ended with %s, answer %s; %s", file, code, stop, trace)
    if stop == "NoSpace":
        raise Unavailable("there is no space left for reading the file")
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        raise TooLarge(_fault("reading the file takes too long or too much memory", "time_limit", file))
    if code == -signal.SIGXFSZ or stop == "FileTooLarge":
        raise TooLarge(_fault("the file unpacks to too many bytes", "too_many_bytes", file))
    if stop == "MemoryError" or "bad_alloc" in trace or "MemoryError" in trace:
        raise TooLarge(_fault("reading the file takes too much memory", "memory_limit", file))
    raise error(
        Fault(
            "the file cannot be read: its reader failed on it" if code == 0 else "the file makes its reader crash",
            "unreadable_file" if code == 0 else "reader_crashed",
            "It is damaged or not what its format promises; export it again.",
            file,
        )
    )


def _run(request: str, folder: Path, wall_s: float, file: str) -> tuple[int, str]:
    """Exit code and the end of standard error."""
    with (folder / "stderr").open("w+b") as trace:
        try:
            child = subprocess.Popen(
                [sys.executable, "-I", "-X", "faulthandler", "-m", "exogauge.sandbox.child"],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=trace,
                cwd=folder,
                env=_environment(folder),
                start_new_session=True,
                close_fds=True,
            )
        except OSError as problem:
            raise Unavailable(f"no process can be started to read {file}: {problem.strerror}") from None
        try:
            child.communicate(request.encode(), timeout=wall_s)
        except subprocess.TimeoutExpired:
            raise TooLarge(_fault(f"reading the file takes more than {wall_s:g} s", "time_limit", file)) from None
        finally:
            _end(child)
        trace.seek(max(0, trace.tell() - 4000))
        return child.returncode, trace.read().decode("utf-8", "replace")


def _end(child: subprocess.Popen[bytes]) -> None:
    """Kill the child and whatever it started: they share one session of their own."""
    if child.poll() is None:
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    if child.stdin is not None and not child.stdin.closed:
        child.stdin.close()


def _environment(folder: Path) -> dict[str, str]:
    """Nothing of the parent's environment; one thread; an allocator that does not reserve address space."""
    return {
        "PATH": "/usr/bin:/bin",
        "HOME": str(folder),
        "TMPDIR": str(folder),
        "LANG": "C.UTF-8",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "ARROW_DEFAULT_MEMORY_POOL": "system",
        "ARROW_IO_THREADS": "1",
        "MALLOC_ARENA_MAX": "2",
        "HDF5_PLUGIN_PATH": str(folder),
    }


def _read_answer(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > MAX_ANSWER:
            return {}
        answer = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return answer if isinstance(answer, dict) else {}


def _fault(detail: str, rule: str, file: str) -> Fault:
    return Fault(detail, rule, "Split it, or hand in less of it.", file)
