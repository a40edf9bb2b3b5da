"""A process that has loaded what readers need and forks one for each request: to load it takes most of a second, to
read a short log some milliseconds.

Run as `python -I -m exogauge.sandbox.fork_server FD` by `readers`, the socket FD to it. It opens nothing that anybody
handed in. It ends when the other end of the socket is gone, its readers with it, or after a minute without any.
"""

from __future__ import annotations

import importlib
import json
import os
import select
import signal
import socket
import sys
import tempfile
import traceback
from contextlib import suppress
from typing import NoReturn, final

from exogauge.garbage import left_while_loading
from exogauge.sandbox.protocol import FORK_ERROR, REQUEST_BYTES, TOLD

IDLE_S = 60.0  # judgement: uploads of one sitting share a server, and its 92 MB are held no longer
OWN_FOLDER = ("HOME", "TMPDIR", "HDF5_PLUGIN_PATH")  # of a reader's environment


@final
class ForkServer:
    def __init__(self, channel: socket.socket) -> None:
        self.channel = channel
        self.running: dict[int, int] = {}  # process id -> the pipe to who waits for it
        self.channels = [channel]  # and one to each reader, which may ask for readers of its own
        self.woken, waking = os.pipe()
        os.set_blocking(self.woken, False)
        os.set_blocking(waking, False)
        signal.set_wakeup_fd(waking, warn_on_full_buffer=False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        self.own = (self.woken, waking)

    def serve(self) -> None:
        while True:
            waited = [self.woken, *(each.fileno() for each in self.channels)]
            ready, _, _ = select.select(waited, [], [], None if self.running else IDLE_S)
            if self.woken in ready:
                with suppress(BlockingIOError):
                    os.read(self.woken, 4096)
                self.reap()
            for channel in [each for each in self.channels if each.fileno() in ready]:
                if not self.take(channel):
                    self.channels.remove(channel)
                    channel.close()
            if not ready or self.channel not in self.channels:
                break
        for pid in self.running:
            with suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGKILL)

    def take(self, channel: socket.socket) -> bool:
        """One request; False where nobody is left to make one, or what is asked is none, as of a reader taken over."""
        fds = list[int]()
        try:
            message, fds, _, _ = socket.recv_fds(channel, REQUEST_BYTES, 3)
            request, (asked, trace, told) = json.loads(message), fds
            module, folder = str(request["module"]), str(request["folder"])
        except (OSError, ValueError, KeyError, TypeError):
            for fd in fds:
                os.close(fd)
            return False
        load(module)
        ours, theirs = socket.socketpair()
        try:
            pid = os.fork()
        except OSError as problem:
            tell(told, FORK_ERROR, problem.errno or 0)
            os.close(told)
            ours.close()
        else:
            if pid == 0:
                for each in (ours, *self.channels):
                    each.close()
                for fd in (*self.own, *self.running.values(), told):
                    os.close(fd)
                be_a_reader(module, folder, asked, trace, theirs)
            self.running[pid] = told
            self.channels.append(ours)
            tell(told, pid, 0)
        theirs.close()
        os.close(asked)
        os.close(trace)
        return True

    def reap(self) -> None:
        while self.running:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            told = self.running.pop(pid)
            tell(told, pid, os.waitstatus_to_exitcode(status))
            os.close(told)


def tell(told: int, pid: int, code: int) -> None:
    with suppress(BrokenPipeError):  # nobody waits any more
        os.write(told, TOLD.pack(pid, code))


def load(module: str) -> None:
    """What cannot be loaded here is told by the reader that cannot load it."""
    if module in sys.modules:
        return
    with left_while_loading(), suppress(Exception):
        for name in importlib.import_module(module).LOADED:
            importlib.import_module(name)


def be_a_reader(module: str, folder: str, asked: int, trace: int, channel: socket.socket) -> NoReturn:
    """In a session of its own, with nothing open but the request, the trace and where to ask for readers of its own."""
    try:
        os.setsid()
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        os.chdir(folder)
        os.environ.update(dict.fromkeys(OWN_FOLDER, folder))
        tempfile.tempdir = None
        os.dup2(asked, 0)
        os.dup2(trace, 2)
        os.close(asked)
        os.close(trace)
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115 (as long as the process)
        from exogauge.sandbox.answering import serve
        from exogauge.sandbox.readers import readers

        readers.ask_through(channel)
        serve(importlib.import_module(module).TASKS)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(1)


if __name__ == "__main__":
    with socket.socket(fileno=int(sys.argv[1])) as line:
        ForkServer(line).serve()
