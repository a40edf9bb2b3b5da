"""The compute child: a process that does one computation at a time and may die without harm.

Started by `compute.ComputeChild` with one end of a socket pair. Requests and replies are JSON lines:

    <- {"id": 7, "call": "package.module:function", "folder": "...", "out": "...", "settings": {...}}
    -> {"id": 7, "progress": 0.25, "message": "reading logs", "stage": "reading" | null}    any number of times
    -> {"id": 7, "done": true}  |  {"id": 7, "error": {"class", "message", "faults", "trace"}}

The child leaves as soon as the other end of the socket is gone, even in the middle of a computation:
a thread of its own does nothing but read. A worker that was killed leaves no orphan behind. It computes by its
worker's code alone (`code_version.hold_to`): modules are imported when a job first needs them, and may be others then.
"""

from __future__ import annotations

import contextlib
import dataclasses
import faulthandler
import importlib
import json
import os
import queue
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from exogauge.errors import BadInput, DiskFull, ExogaugeError, no_room
from exogauge.garbage import left_while_loading
from exogauge.jobs.code_version import hold_to
from exogauge.progress import Stage
from exogauge.sandbox.readers import readers

PROGRESS_INTERVAL_S = 0.1


class Replies:
    """Writes replies to one request; progress at most every 0.1 s, the last before the end and the end always."""

    def __init__(self, channel: socket.socket, request_id: int) -> None:
        self._channel, self._id, self._last = channel, request_id, 0.0
        self._unsaid: tuple[float, str, Stage | None] | None = None

    def end(self, **body: Any) -> None:
        """With where it ended, before: who reads how a job failed wants to know at what."""
        if self._unsaid is not None:
            self._say(*self._unsaid)
        self._send(**body)

    def _send(self, **body: Any) -> None:
        self._channel.sendall(json.dumps({"id": self._id, **body}).encode() + b"\n")

    def progress(self, fraction: float, message: str, stage: Stage | None = None) -> None:
        self._unsaid = (fraction, message, stage)
        if time.monotonic() - self._last >= PROGRESS_INTERVAL_S:
            self._say(fraction, message, stage)

    def _say(self, fraction: float, message: str, stage: Stage | None) -> None:
        self._last, self._unsaid = time.monotonic(), None
        self._send(progress=min(max(float(fraction), 0.0), 1.0), message=str(message), stage=stage)


def resolve(name: str) -> Callable[..., None]:
    """The function named `package.module:function`."""
    module, _, function = name.partition(":")
    with contextlib.nullcontext() if module in sys.modules else left_while_loading():
        found: Callable[..., None] = getattr(importlib.import_module(module), function)
    return found


def answer(request: dict[str, Any], replies: Replies) -> None:
    """Compute one request; every ending becomes a reply."""
    try:
        function = resolve(request["call"])
        try:
            function(Path(request["folder"]), Path(request["out"]), replies.progress, request["settings"])
        finally:
            readers.end()  # what they used is of this job
    except Exception as error:
        replies.end(error=described(error))
    else:
        replies.end(done=True)


def described(error: Exception) -> dict[str, Any]:
    """An exception as JSON: what the user may read, and the trace only for what nobody foresaw."""
    faults = [dataclasses.asdict(fault) for fault in error.faults] if isinstance(error, BadInput) else []
    if no_room(error):
        return {"class": DiskFull.__name__, "message": "the disk is full", "faults": [], "trace": None}
    expected = isinstance(error, ExogaugeError)
    return {
        "class": type(error).__name__,
        "message": str(error),
        "faults": faults,
        "trace": None if expected else traceback.format_exc(),
    }


def read_requests(channel: socket.socket, requests: queue.SimpleQueue[dict[str, Any]]) -> None:
    """Hand on each line; the end of the stream ends the process, whatever it is doing."""
    try:
        with channel.makefile("rb") as lines:
            for line in lines:
                requests.put(json.loads(line))
    except OSError:
        pass
    os._exit(0)


def be_first_to_go() -> None:
    """Ask the kernel to pick this process, not the worker, when memory runs out (Linux)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")


def main() -> None:
    """Serve requests on the socket whose number is the first argument, by the code that the second names."""
    hold_to(sys.argv[2])
    faulthandler.enable()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the whole group; the worker decides
    be_first_to_go()
    channel = socket.socket(fileno=int(sys.argv[1]))
    requests: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=read_requests, args=(channel, requests), daemon=True).start()
    while True:
        request = requests.get()
        answer(request, Replies(channel, request["id"]))


if __name__ == "__main__":
    main()
