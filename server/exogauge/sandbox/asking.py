"""Put one request to a short-lived child process, and turn whatever becomes of it into a result or an error that helps.

The other end is `answering`.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, final

from exogauge.errors import BadInput, BadLog, BadMotion, BadRobot, BadStudy, DiskFull, Fault, TooLarge, Unavailable
from exogauge.sandbox.limits import Limits
from exogauge.sandbox.protocol import ANSWER, NO_ROOM
from exogauge.sandbox.readers import readers

log = logging.getLogger(__name__)

MAX_ANSWER = 8 << 20
VMSTAT = Path("/proc/vmstat")
KERNELS = ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")
ERRORS: Mapping[str, type[BadInput]] = {
    each.__name__: each for each in (BadInput, BadLog, BadMotion, BadRobot, BadStudy, TooLarge)
}


@final
class Places:
    """How many children this process has at once: no bound, unless a server sets one. taken: of a bound, about now."""

    def __init__(self) -> None:
        self._places: threading.Semaphore | None = None
        self._wait_s = 0.0
        self.taken = 0

    def bound(self, most: int | None, wait_s: float = 5.0) -> None:
        """wait_s: for which a request may wait for a place, before it is told to come again."""
        self._places, self._wait_s = None if most is None else threading.Semaphore(most), wait_s

    @contextmanager
    def place(self, what: str) -> Iterator[None]:
        """Unavailable where all are taken."""
        places = self._places
        if places is None:
            yield
            return
        if not places.acquire(timeout=self._wait_s):
            raise Unavailable(f"too many files are being read to read the {what} now; try again in a moment")
        self.taken += 1
        try:
            yield
        finally:
            self.taken -= 1
            places.release()


at_once = Places()


def ask(
    module: str,
    task: str,
    options: Mapping[str, Any],
    folder: Path,
    limits: Limits,
    error: type[BadInput],
    what: str = "file",
    file: str | None = None,
) -> dict[str, Any]:
    """The result of one task of `module`, run in `folder`, where it may leave files.

    error: the class for input that brings the child down. what, file: how the user knows the input.
    """
    request = {"task": task, "options": options, "limits": dataclasses.asdict(limits)}
    short_before = times_short_of_memory()
    with at_once.place(what):
        code, trace = _run(module, json.dumps(request), folder, limits.wall_s, what, file)
    answer = _read_answer(folder / ANSWER)
    if code == 0 and "result" in answer:
        return dict(answer["result"])
    if code == 0 and answer.get("error") in ERRORS:
        raise ERRORS[answer["error"]]([Fault(**fault) for fault in answer["faults"]])
    stop = answer.get("error", "none")
    log.warning("reading %s: child ended with %s, answer %s; %s", file or f"a {what}", code, stop, trace)
    if stop == "NoSpace" or code == NO_ROOM:
        raise DiskFull(f"there is no space left for reading the {what}")
    if code == -signal.SIGKILL:  # none of its limits does that
        raise Unavailable(_killed(file or f"the {what}", limits, times_short_of_memory() > short_before))
    if code == -signal.SIGXCPU:
        raise TooLarge(_fault(f"reading the {what} takes more than {limits.cpu_s} s of computing", "time_limit", file))
    if code == -signal.SIGXFSZ or stop == "FileTooLarge":
        raise TooLarge(_fault(f"the {what} unpacks to too many bytes", "too_many_bytes", file))
    if stop == "MemoryError" or "bad_alloc" in trace or "MemoryError" in trace:
        raise TooLarge(_fault(f"reading the {what} takes too much memory", "memory_limit", file))
    raise error(
        Fault(
            f"the {what} cannot be read: its reader failed on it"
            if code == 0
            else f"the {what} makes its reader crash",
            "unreadable_file" if code == 0 else "reader_crashed",
            "It is damaged or not what its format promises; export it again.",
            file,
        )
    )


def times_short_of_memory() -> int:
    """How often the kernel has killed a process for want of memory since it started; 0 where it does not tell."""
    try:
        lines = VMSTAT.read_text().splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in lines if line.startswith("oom_kill ")), 0)


def _killed(file: str, limits: Limits, short: bool) -> str:
    """What is known of a reader that was killed from outside, and what is not."""
    why = (
        "the kernel killed processes for want of memory meanwhile, this one most likely"
        if short
        else "by hand, or because memory ran out; this machine does not tell which"
    )
    return (
        f"the process that read {file} was killed: {why}. Of the file nothing is known: it was within its limits, "
        f"{limits.memory >> 20} MiB of memory and {limits.cpu_s} s. Try again when less runs on the machine; if it "
        "happens each time, split the file, give the machine more memory, or let fewer read at once (EXOGAUGE_READERS)"
    )


def _run(module: str, request: str, folder: Path, wall_s: float, what: str, file: str | None) -> tuple[int, str]:
    """Exit code and the end of standard error."""
    with (folder / "request").open("w+b") as asked, (folder / "stderr").open("w+b") as trace:
        asked.write(request.encode())
        asked.seek(0)
        try:
            reader = readers.start(module, folder, asked.fileno(), trace.fileno(), _environment())
        except OSError as problem:
            raise Unavailable(
                f"no process can be started to read {file or f'the {what}'}: {problem.strerror or problem}"
            ) from None
        try:
            code = reader.wait(wall_s)
        except TimeoutError:
            raise TooLarge(_fault(f"reading the {what} takes more than {wall_s:g} s", "time_limit", file)) from None
        finally:
            reader.end()
        trace.seek(max(0, trace.seek(0, os.SEEK_END) - 4000))
        return code, trace.read().decode("utf-8", "replace")


def _environment() -> dict[str, str]:
    """Nothing of the parent's environment but what chooses the kernels of its linear algebra, so that both compute the
    same bits; one thread; an allocator that does not reserve address space. A reader's own folder comes to it."""
    return {
        **{name: value for name, value in os.environ.items() if name in KERNELS},
        "PATH": "/usr/bin:/bin",
        "LANG": "C.UTF-8",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
        "ARROW_DEFAULT_MEMORY_POOL": "system",
        "ARROW_IO_THREADS": "1",
        "MALLOC_ARENA_MAX": "2",
    }


def _read_answer(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > MAX_ANSWER:
            return {}
        answer = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return answer if isinstance(answer, dict) else {}


def _fault(detail: str, rule: str, file: str | None) -> Fault:
    return Fault(detail, rule, "Split it, or hand in less of it.", file)
