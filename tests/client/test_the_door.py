"""A real server and raw sockets: what one connection can take from the others, and who may connect at all."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

import httpx
import pytest

from exogauge.settings import Settings, refuse_open_house

SILENCE_S, CONNECTIONS = 2.0, 12
MEGABYTES = 20
BUSY = 5.0  # what a machine that is busy with other things may add to any second


@pytest.fixture(scope="module")
def door(tmp_path_factory, service_of):
    """The address of a server that loses patience soon and takes few at once."""
    more = {"EXOGAUGE_SILENCE_S": str(SILENCE_S), "EXOGAUGE_MAX_CONNECTIONS": str(CONNECTIONS)}
    made = service_of(tmp_path_factory.mktemp("door"), workers=0, **more)
    yield made.start()
    made.stop()


@contextmanager
def line(url: str) -> Iterator[socket.socket]:
    with socket.create_connection((urlsplit(url).hostname, urlsplit(url).port), timeout=30.0) as opened:
        yield opened


def told(opened: socket.socket) -> bytes:
    """All that the server says until it ends the connection."""
    said = b""
    try:
        while more := opened.recv(65536):
            said += more
    except ConnectionResetError:
        pass
    return said


ENDLESS = {
    "value": (b"GET / HTTP/1.1\r\nHost: localhost\r\nX: ", b"a" * 1024),
    "name": (b"GET / HTTP/1.1\r\nHost: localhost\r\nX", b"a" * 1024),
    "path": (b"GET /", b"a" * 1024),
    "headers": (b"GET / HTTP/1.1\r\nHost: localhost\r\n", b"a: b\r\n" * 170),
    "trailer": (b"POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\nX: ", b"a" * 1024),
}


@pytest.mark.parametrize("what", ENDLESS)
def test_a_header_without_end_is_cut_off_while_others_are_answered(door, what):
    begin, piece = ENDLESS[what]
    ended, sent, said = threading.Event(), [0], [b""]

    def pester() -> None:
        with line(door) as opened:
            opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            try:
                opened.sendall(begin)
                while sent[0] < MEGABYTES << 20:
                    opened.sendall(piece)
                    sent[0] += len(piece)
            except OSError:
                pass
            said[0] = told(opened)
        ended.set()

    began = time.monotonic()
    pesterer = threading.Thread(target=pester)
    pesterer.start()
    waits = []
    with httpx.Client(base_url=door) as other:
        while not ended.is_set() or not waits:
            asked = time.monotonic()
            assert other.get("/healthz", timeout=10.0).status_code == 200
            waits.append(time.monotonic() - asked)
    took = time.monotonic() - began
    pesterer.join()
    assert took < 1.0 + BUSY
    assert max(waits) < 1.0 + BUSY
    if what != "trailer":  # answered before, by the app
        assert said[0] == b"" or said[0].startswith(b"HTTP/1.1 431")


def test_a_long_header_is_read_and_a_longer_one_is_told_why_not(door):
    for size, status in ((16_000, 200), (40_000, 431)):
        answer = httpx.get(f"{door}/healthz", headers={"X": "a" * size})
        assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["status"] == 431


def test_headers_that_do_not_come_are_not_waited_for(door):
    with line(door) as silent, line(door) as begun:
        began = time.monotonic()
        begun.sendall(b"GET / HTTP/1.1\r\nHost: local")
        assert told(begun).startswith(b"HTTP/1.1 408")
        assert told(silent) == b""
        assert SILENCE_S <= time.monotonic() - began < SILENCE_S + 1.0 + BUSY


@pytest.fixture
def upload(door):
    """The head of a request that sends the next piece of an upload: head(offset, size), and how to ask its offset."""
    tus = {"Tus-Resumable": "1.0.0"}
    place = httpx.post(f"{door}/api/v1/uploads", headers={**tus, "Upload-Length": "16"}).headers["location"]

    def head(offset: int, size: int) -> bytes:
        return (
            f"PATCH {place} HTTP/1.1\r\nHost: localhost\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: {offset}\r\n"
            f"Content-Type: application/offset+octet-stream\r\nContent-Length: {size}\r\nConnection: close\r\n\r\n"
        ).encode()

    def offset() -> int:
        return int(httpx.head(f"{door}{place}", headers=tus).headers["upload-offset"])

    return head, offset


@pytest.mark.slow
def test_a_slow_upload_arrives_and_one_that_stops_keeps_what_came(door, upload):
    head, offset = upload
    with line(door) as slow:
        slow.sendall(head(0, 8))
        for k in range(8):  # in all twice as long as silence may last
            time.sleep(SILENCE_S / 4)
            slow.sendall(b"%d" % k)
        assert told(slow).startswith(b"HTTP/1.1 204")
    assert offset() == 8
    with line(door) as stops:
        stops.sendall(head(8, 8) + b"abc")
        began = time.monotonic()
        assert told(stops).startswith(b"HTTP/1.1 408")
        assert time.monotonic() - began < SILENCE_S + 1.0 + BUSY
    assert offset() == 11


def test_connections_that_ask_nothing_give_way_and_those_at_work_do_not(door, upload):
    head, _ = upload
    lines = [socket.create_connection((urlsplit(door).hostname, urlsplit(door).port)) for _ in range(CONNECTIONS)]
    try:
        assert httpx.get(f"{door}/healthz").status_code == 200
        for each in lines[1:]:
            each.close()
        time.sleep(0.2)
        lines[1:] = [socket.create_connection(each) for each in [lines[0].getpeername()] * CONNECTIONS]
        for each in lines[1:]:
            each.sendall(head(0, 8))  # all at work now
        with line(door) as late:
            late.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            assert told(late).startswith(b"HTTP/1.1 503")
    finally:
        for each in lines:
            each.close()
    until = time.monotonic() + SILENCE_S + BUSY
    while httpx.get(f"{door}/healthz").status_code != 200:
        assert time.monotonic() < until
        time.sleep(0.1)


CERTIFICATE = {"TLS_CERTIFICATE": "c.pem", "TLS_KEY": "k.pem"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("host", "said", "refused"),
    [
        ("0.0.0.0", {}, "EXOGAUGE_ACCOUNTS=1"),
        ("::", {}, "EXOGAUGE_OPEN_TO_ALL=1"),
        ("0.0.0.0", CERTIFICATE, "EXOGAUGE_ACCOUNTS=1"),
        ("0.0.0.0", {"ACCOUNTS": "1"}, "EXOGAUGE_TLS_CERTIFICATE"),
        ("0.0.0.0", {"ACCOUNTS": "1", "TLS_KEY": "k.pem"}, "EXOGAUGE_TLS_KEY"),
        ("0.0.0.0", {"ACCOUNTS": "1", "OPEN_TO_ALL": "1"}, "EXOGAUGE_OPEN_TO_ALL"),
        ("127.0.0.1", {"PROXY": "127.0.0.1"}, "EXOGAUGE_ACCOUNTS=1"),
    ],
)
def test_a_network_is_served_only_on_purpose(tmp_path, host, said, refused):
    """Another host than this one takes accounts and encryption, or says that all may do all."""
    ended = ended_server(tmp_path, host, said, port=0)
    assert ended.returncode == 2
    assert refused in ended.stderr
    assert not (tmp_path / "data").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("host", "said"),
    [
        ("0.0.0.0", {"ACCOUNTS": "1", **CERTIFICATE}),
        ("0.0.0.0", {"ACCOUNTS": "1", "PROXY": "10.0.0.1"}),
        ("localhost", {}),
    ],
)
def test_what_is_served_on_purpose_is_not_refused(monkeypatch, tmp_path, host, said):
    for name, value in {"DATA_DIR": str(tmp_path), "HOST": host, **said}.items():
        monkeypatch.setenv(f"EXOGAUGE_{name}", value)
    refuse_open_house(Settings())


@pytest.mark.slow
def test_a_server_that_is_open_to_all_on_purpose_begins_to_listen(tmp_path):
    with socket.socket() as taken:  # it ends here, at a port that is in use
        taken.bind(("", 0))
        taken.listen()
        ended = ended_server(tmp_path, "0.0.0.0", {"OPEN_TO_ALL": "1"}, taken.getsockname()[1])
    assert "cannot listen" in ended.stderr


def ended_server(tmp_path, host, said, port):
    own = {
        "EXOGAUGE_DATA_DIR": str(tmp_path / "data"),
        "EXOGAUGE_HOST": host,
        "EXOGAUGE_PORT": str(port),
        **{f"EXOGAUGE_{name}": value for name, value in said.items()},
    }
    command = [sys.executable, "-m", "exogauge.cli", "serve", "--workers", "0"]
    return subprocess.run(command, env={**os.environ, **own}, capture_output=True, text=True, timeout=120)
