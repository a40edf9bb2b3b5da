"""Readers that a `fork_server` of this process's own starts: begin one, wait for its end, end it."""

from __future__ import annotations

import atexit
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import final

from exogauge.sandbox.protocol import FORK_ERROR, TOLD

SERVER = ("-I", "-X", "faulthandler", "-m", "exogauge.sandbox.fork_server")


@final
class Reader:
    """A process in a session of its own. told: the pipe on which the fork server says its end."""

    def __init__(self, pid: int, told: int) -> None:
        self.pid, self._told = pid, told
        self._code: int | None = None
        self._over = False

    def wait(self, timeout_s: float) -> int:
        """Exit code, negative for a signal; that of a kill where its fork server is gone. TimeoutError."""
        if self._code is None:
            said = _said(self._told, timeout_s)
            self._code = -signal.SIGKILL if said is None else said[1]
            if said is None:
                self._kill()
        return self._code

    def end(self) -> None:
        """Whatever it started ends with it: they share its session."""
        if self._over:
            return
        self._over = True
        if self._code is None:
            self._kill()
            with suppress(TimeoutError):
                self.wait(10.0)
        os.close(self._told)

    def _kill(self) -> None:
        with suppress(ProcessLookupError):
            try:
                os.killpg(self.pid, signal.SIGKILL)
            except ProcessLookupError:  # it has no session yet
                os.kill(self.pid, signal.SIGKILL)


@final
class Readers:
    """Starts the fork server with the first reader, and anew where it has ended."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._server: subprocess.Popen[bytes] | None = None
        self._channel: socket.socket | None = None
        self._environment: Mapping[str, str] | None = None
        self._of = os.getpid()

    def start(self, module: str, folder: Path, asked: int, trace: int, environment: Mapping[str, str]) -> Reader:
        """A reader that answers, as `answering` has it, what stands in the file `asked`, by the tasks of `module`.

        folder: its own. trace: the file of its standard error. OSError: no process can be started.
        """
        request = json.dumps({"module": module, "folder": str(folder)}).encode()
        with self._lock:  # one request at a time is on its way
            for _ in range(2):  # a server that has been idle for long may end at this very moment
                reader = self._begun(request, asked, trace, environment)
                if reader is not None:
                    return reader
                self._end()
        raise ChildProcessError("the process that starts readers ends at once")

    def ask_through(self, channel: socket.socket) -> None:
        """For a reader, of which the fork server started it; where it is gone, one of its own takes its place."""
        self._server, self._channel, self._environment, self._of = None, channel, None, os.getpid()
        self._lock = threading.Lock()

    def end(self) -> None:
        """The fork server's, and of every reader that still runs."""
        with self._lock:
            self._end()

    def _begun(self, request: bytes, asked: int, trace: int, environment: Mapping[str, str]) -> Reader | None:
        channel = self._connected(environment)
        told, telling = os.pipe()
        reader = None
        try:
            try:
                socket.send_fds(channel, [request], [asked, trace, telling])
            except ConnectionError:
                return None
            finally:
                os.close(telling)
            said = _said(told, None)
            if said is not None and said[0] == FORK_ERROR:
                raise OSError(said[1], os.strerror(said[1]))
            reader = None if said is None else Reader(said[0], told)
            return reader
        finally:
            if reader is None:
                os.close(told)

    def _connected(self, environment: Mapping[str, str]) -> socket.socket:
        if self._channel is not None and self._of == os.getpid() and self._environment in (None, environment):
            return self._channel
        self._end()
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                self._server = subprocess.Popen(
                    [sys.executable, *SERVER, str(theirs.fileno())],
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    cwd="/",
                    env=dict(environment),
                    start_new_session=True,
                )
        except BaseException:
            ours.close()
            raise
        threading.Thread(target=self._server.wait, daemon=True).start()  # one that ends by itself leaves no name behind
        self._channel, self._environment, self._of = ours, environment, os.getpid()
        return ours

    def _end(self) -> None:
        channel, server = self._channel, self._server
        self._server = self._channel = None
        if channel is None or self._of != os.getpid():  # or another's, of which this is a fork
            return
        with suppress(OSError):
            channel.shutdown(socket.SHUT_RDWR)
        channel.close()
        if server is None:
            return
        try:
            server.wait(10.0)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()


def _said(told: int, timeout_s: float | None) -> tuple[int, int] | None:
    """Process id and exit code; None where nobody is left to say them. TimeoutError."""
    end = None if timeout_s is None else time.monotonic() + timeout_s
    ready = select.poll()  # not `select`: a server has more than a thousand files open
    ready.register(told, select.POLLIN)
    said = b""
    while len(said) < TOLD.size:
        if not ready.poll(None if end is None else max(end - time.monotonic(), 0.0) * 1000.0):
            raise TimeoutError
        more = os.read(told, TOLD.size - len(said))
        if not more:
            return None
        said += more
    pid, code = TOLD.unpack(said)
    return pid, code


readers = Readers()
atexit.register(readers.end)
