"""One compute child per worker slot: ask, watch, and kill when it must stop.

The request id is echoed by the child and checked here, and the child is killed on every ending but its own
answer. So no reply is ever taken for the reply to another request.
"""

from __future__ import annotations

import json
import os
import select
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, final

from exogauge.blas_threads import one_thread
from exogauge.errors import DiskFull, ExogaugeError
from exogauge.jobs.code_version import OUTDATED, code_version
from exogauge.storage.blobs import disk

POLL_S = 0.1
Watch = Callable[[float | None, str | None, str | None], None]
"""Called with share, message and stage."""
STDERR_TAIL = 4000  # characters of the child's stderr kept for the job's log


class ComputeChildDied(ExogaugeError):
    """The computing process ended without an answer (a crash in native code, or out of memory)."""

    def __init__(self, message: str, stderr: str = "") -> None:
        self.stderr = stderr
        super().__init__(message)


class Outdated(ExogaugeError):
    """The program's files were replaced: what goes on would be computed by code of two versions."""


class ComputeTimeout(ExogaugeError):
    """The computation took longer than its kind allows."""


class ComputeFailed(ExogaugeError):
    """The computation raised. `kind` is the class, `expected` tells bad input from a defect."""

    def __init__(self, error: Mapping[str, Any]) -> None:
        self.kind: str = error["class"]
        self.faults: list[dict[str, Any]] = error["faults"]
        self.trace: str | None = error["trace"]
        super().__init__(error["message"])

    @property
    def expected(self) -> bool:
        return self.trace is None

    @property
    def failure(self) -> dict[str, Any]:
        """What was wrong with what was handed in, or with exogauge itself, as the job's row keeps it."""
        return {"class": self.kind, "faults": self.faults, "defect": not self.expected}


@final
class ComputeChild:
    """A long-lived child process; started on first use and again after it was killed.

    >>> child.call("package.module:function", folder, out, settings, watch, timeout_s=60)  # doctest: +SKIP

    `watch(fraction, message, stage)` is called on every progress line and at least every 0.1 s (then with None);
    it raises to stop the computation. What time it takes is not the computation's.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._channel: socket.socket | None = None
        self._stderr: IO[bytes] | None = None
        self._request_id = 0
        self._used = self._used_before = 0.0

    def start(self) -> None:
        """Start the process if there is none; imports nothing of the numerics yet."""
        if self._process is not None and self._process.poll() is None:
            return
        self.kill()
        with disk("start to compute"):
            self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 (lives as long as the process)
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-m", "exogauge.jobs.child", str(theirs.fileno()), code_version()]
        self._process = subprocess.Popen(
            command,
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=self._stderr,
            stderr=self._stderr,
            env=one_thread(os.environ),
        )
        theirs.close()
        self._channel = ours

    def call(
        self,
        call: str,
        folder: Path,
        out: Path,
        settings: Mapping[str, Any],
        watch: Watch,
        timeout_s: float,
    ) -> None:
        """Run `call(folder, out, progress, settings)` in the child.

        Raises ComputeFailed when the function raised, DiskFull when it met one, ComputeChildDied when the process
        died, Outdated when it would have gone on by other code, ComputeTimeout, and whatever `watch` raises. In all but
        the first case the process is gone afterwards.
        """
        self.start()
        self._request_id += 1
        request = {"id": self._request_id, "call": call, "folder": str(folder), "out": str(out), "settings": settings}
        try:
            self._converse(json.dumps(request).encode() + b"\n", watch, timeout_s)
        except ComputeFailed:
            raise
        except BaseException:
            self.kill()
            raise

    def _converse(self, request: bytes, watch: Watch, timeout_s: float) -> None:
        channel, buffer, deadline = self._channel, b"", time.monotonic() + timeout_s
        assert channel is not None

        def watching(fraction: float | None, message: str | None, stage: str | None) -> None:
            nonlocal deadline
            begun = time.monotonic()
            watch(fraction, message, stage)
            deadline += time.monotonic() - begun

        try:
            channel.sendall(request)
            while True:
                if time.monotonic() > deadline:
                    raise ComputeTimeout(f"stopped after {timeout_s:.0f} s, the limit for this kind of job")
                self._look()
                readable, _, _ = select.select([channel], [], [], POLL_S)
                if not readable:
                    watching(None, None, None)
                    continue
                received = channel.recv(1 << 16)
                if not received:
                    raise self._died()
                *lines, buffer = (buffer + received).split(b"\n")
                if any(self._take(json.loads(line), watching) for line in lines):
                    self._look()
                    return
        except (BrokenPipeError, ConnectionResetError) as error:
            raise self._died() from error

    def _take(self, reply: dict[str, Any], watch: Watch) -> bool:
        """Act on one reply; True when it is the last one."""
        if reply["id"] != self._request_id:
            raise ComputeChildDied(f"reply {reply['id']} to request {self._request_id}")
        if "error" in reply:
            if reply["error"]["class"] == DiskFull.__name__:
                raise DiskFull(f"cannot compute now: {reply['error']['message']}")
            raise ComputeFailed(reply["error"])
        if "progress" in reply:
            watch(reply["progress"], reply["message"], reply["stage"])
        return "done" in reply

    def _died(self) -> ComputeChildDied | Outdated:
        process = self._process
        assert process is not None
        try:
            code = process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            code = 0
        if code == OUTDATED:
            return Outdated(self.stderr_tail().strip())
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        return ComputeChildDied(f"the computing process died ({how})", self.stderr_tail())

    @property
    def used_s(self) -> float:
        """CPU seconds of all processes that there were, and of their children that ended, as far as was looked."""
        return self._used_before + self._used

    def _look(self) -> None:
        with suppress(OSError):  # gone, or no /proc
            assert self._process is not None
            fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
            utime_stime_and_of_children = map(int, fields[11:15])
            self._used = max(self._used, sum(utime_stime_and_of_children) / os.sysconf("SC_CLK_TCK"))

    def stderr_tail(self) -> str:
        """The last characters the child wrote to stdout or stderr."""
        if self._stderr is None:
            return ""
        self._stderr.seek(0)
        return self._stderr.read().decode(errors="replace")[-STDERR_TAIL:]

    def kill(self) -> None:
        """End the process now, whatever it is doing, and wait for it."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        for resource in (self._channel, self._stderr):
            if resource is not None:
                resource.close()
        self._process = self._channel = self._stderr = None
        self._used_before, self._used = self.used_s, 0.0
