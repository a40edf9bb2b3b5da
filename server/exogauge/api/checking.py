"""Ask a short-lived child process (`opening`) what an upload holds. The API process itself opens nothing."""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from exogauge.api.opening import ANSWER
from exogauge.errors import BadInput, BadLog, BadRobot, BadStudy, Fault, TooLarge, Unavailable
from exogauge.sandbox.limits import Limits

log = logging.getLogger(__name__)

LARGEST_ANSWER = 4 * 1024 * 1024
ERRORS: Mapping[str, type[BadInput]] = {
    each.__name__: each for each in (BadInput, BadLog, BadRobot, BadStudy, TooLarge)
}


def check_study(folder: Path) -> dict[str, Any]:
    """What the study in `folder` is, after reading every file it names. Raises BadInput with every place."""
    return ask("study", folder, BadStudy)


def check_robot(folder: Path, file: str = "robot.yaml") -> dict[str, Any]:
    return ask("robot", folder, BadRobot, file=file)


def check_log(folder: Path, file: str, mapping: str | None = None, robot: str | None = None) -> dict[str, Any]:
    return ask("log", folder, BadLog, file=file, mapping=mapping, robot=robot)


def ask(task: str, folder: Path, error: type[BadInput], **options: Any) -> dict[str, Any]:
    """The child's summary. error: the class for an upload that brings the child down."""
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    limits = Limits.for_bytes(size)
    request = {"task": task, "folder": str(folder), "options": options, "limits": dataclasses.asdict(limits)}
    with TemporaryDirectory(prefix="exogauge-") as own:
        code, trace = run(json.dumps(request), Path(own), limits.wall_s)
        answer = read_answer(Path(own) / ANSWER)
    if code == 0 and "result" in answer:
        return dict(answer["result"])
    kind = answer.get("error", "none")
    if code == 0 and kind in ERRORS:
        raise ERRORS[kind]([Fault(**fault) for fault in answer["faults"]])
    log.warning("opening a %s: the child ended with %s (%s): %s", task, code, kind, trace)
    if kind == "MemoryError" or code in (-signal.SIGKILL, -signal.SIGXCPU, -signal.SIGXFSZ) or "bad_alloc" in trace:
        advice = "Hand in fewer or shorter logs at a time."
        raise TooLarge(Fault(f"the {task} takes too much memory or time to read", "too_much_to_read", advice))
    what = "its reader failed on it" if code == 0 else "it makes its reader crash"
    advice = "A file in it is damaged or not what it promises; export it again."
    raise error(Fault(f"the {task} cannot be read: {what}", "unreadable", advice))


def run(request: str, own: Path, wall_s: float) -> tuple[int, str]:
    """Exit code and the end of standard error."""
    with (own / "stderr").open("w+b") as trace:
        try:
            child = subprocess.Popen(
                [sys.executable, "-I", "-m", "exogauge.api.opening"],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=trace,
                cwd=own,
                env=environment(own),
                start_new_session=True,
            )
        except OSError as problem:
            raise Unavailable(f"no process can be started to read the upload: {problem.strerror}") from problem
        try:
            child.communicate(request.encode(), timeout=wall_s)
        except subprocess.TimeoutExpired:
            fault = Fault(f"reading takes more than {wall_s:g} s", "time_limit", "Hand in less at a time.")
            raise TooLarge(fault) from None
        finally:
            if child.poll() is None:
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
        trace.seek(max(0, trace.tell() - 4000))
        return child.returncode, trace.read().decode("utf-8", "replace")


def environment(own: Path) -> dict[str, str]:
    """Nothing of the parent's: no addresses, no secrets; one thread."""
    return {
        "PATH": "/usr/bin:/bin",
        "HOME": str(own),
        "TMPDIR": str(own),
        "LANG": "C.UTF-8",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "ARROW_DEFAULT_MEMORY_POOL": "system",
        "ARROW_IO_THREADS": "1",
        "MALLOC_ARENA_MAX": "2",
        "HDF5_PLUGIN_PATH": str(own),
    }


def read_answer(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > LARGEST_ANSWER:
            return {}
        answer = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return answer if isinstance(answer, dict) else {}
