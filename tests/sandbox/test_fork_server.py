"""Readers are forks of a process that has loaded what they need: it costs once, and nothing outlives who asked."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from exogauge.sandbox import LogRequest, fork_server, parse_log
from exogauge.sandbox.readers import Reader, Readers, readers

pytestmark = pytest.mark.slow
PATIENCE_S = 30.0


@pytest.fixture(autouse=True)
def anew() -> Iterator[None]:
    readers.end()
    yield
    readers.end()


@pytest.fixture
def short(tmp_path: Path) -> LogRequest:
    path = tmp_path / "short.csv"
    path.write_text("t,q.a\n" + "".join(f"{k / 100},{k}\n" for k in range(50)))
    return LogRequest("short", {"short.csv": path})


def used_s(times: int, request: LogRequest) -> float:
    """CPU seconds of the fork server and its readers."""
    before = os.times()
    for _ in range(times):
        parse_log(request)
    readers.end()
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def test_the_second_reader_costs_a_fraction_of_the_first(short: LogRequest) -> None:
    one, many = used_s(1, short), used_s(11, short)
    assert many < 3.0 * one, f"{one:.2f} s for one, {many:.2f} s for eleven"


def test_where_the_fork_server_was_killed_the_next_reader_has_another(short: LogRequest) -> None:
    parse_log(short)
    server = readers._server
    assert server is not None
    server.send_signal(signal.SIGKILL)
    server.wait()
    assert parse_log(short).samples == 50


@pytest.fixture
def waiting(tmp_path: Path) -> Iterator[Reader]:
    """A reader that is never told what to read."""
    asked, never = os.pipe()
    with (tmp_path / "trace").open("w+b") as trace:
        reader = readers.start("exogauge.sandbox.child", tmp_path, asked, trace.fileno(), {})
    os.close(asked)
    yield reader
    reader.end()
    os.close(never)


def test_a_reader_is_waited_for_no_longer_than_it_may_take_and_ended(waiting: Reader) -> None:
    with pytest.raises(TimeoutError):
        waiting.wait(0.2)
    assert not ended(waiting.pid, 0.1)
    waiting.end()
    assert ended(waiting.pid)


def test_a_reader_whose_fork_server_is_killed_is_ended_and_told_as_killed(waiting: Reader) -> None:
    assert readers._server is not None
    readers._server.send_signal(signal.SIGKILL)
    assert waiting.wait(PATIENCE_S) == -signal.SIGKILL
    assert ended(waiting.pid)


KILLED = """
import os, sys, tempfile
from pathlib import Path
from exogauge.sandbox.readers import readers
with tempfile.TemporaryDirectory() as folder, open(os.path.join(folder, "trace"), "w+b") as trace:
    asked, never = os.pipe()
    reader = readers.start("exogauge.sandbox.child", Path(folder), asked, trace.fileno(), {})
    print(reader.pid, readers._server.pid, flush=True)
    sys.stdin.read()
"""


def test_readers_and_their_server_end_with_who_asked_however_it_ended() -> None:
    asker = subprocess.Popen([sys.executable, "-c", KILLED], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert asker.stdout is not None
    found = [int(pid) for pid in asker.stdout.readline().split()]
    assert len(found) == 2
    assert not any(ended(pid, 0.1) for pid in found)
    asker.kill()
    asker.communicate()
    assert all(ended(pid) for pid in found)


def ended(pid: int, within_s: float = PATIENCE_S) -> bool:
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        try:
            if Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except OSError:
            return True
        time.sleep(0.01)
    return False


def test_a_process_that_was_forked_asks_a_server_of_its_own(short: LogRequest) -> None:
    parse_log(short)
    server = readers._server
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            code = 0 if parse_log(short).samples == 50 and readers._server is not server else 2
            readers.end()
        finally:
            os._exit(code)
    assert os.waitpid(pid, 0)[1] == 0
    assert server is not None
    assert server.poll() is None
    assert parse_log(short).samples == 50
    assert readers._server is server


@pytest.mark.parametrize("said", [b"nonsense", b"[]", b'{"module": "exogauge.sandbox.child"}', b""])
def test_what_is_no_request_ends_its_line_alone(said: bytes) -> None:
    """As a reader that was taken over would use the line on which it may ask for others."""
    ours, theirs = socket.socketpair()
    server = fork_server.ForkServer(theirs)
    try:
        ours.sendall(said)
        ours.shutdown(socket.SHUT_WR)
        assert not server.take(theirs)
    finally:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        for fd in server.own:
            os.close(fd)
        ours.close()
        theirs.close()


def test_what_cannot_be_started_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/bin/true")
    with (tmp_path / "asked").open("w+b") as asked, pytest.raises(ChildProcessError, match="ends at once"):
        Readers().start("exogauge.sandbox.child", tmp_path, asked.fileno(), asked.fileno(), {})
