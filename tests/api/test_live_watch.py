"""Who looks at a live stream sees what its writer sees, and nobody waits for them."""

from __future__ import annotations

import asyncio
import json
import socket
import time
from collections.abc import MutableMapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from fastapi import WebSocket
from numpy.typing import NDArray
from tests.api.test_live import begun, client, folder, opened, packed, payload, rows, service, to_the_end, until
from tests.client.conftest import Service
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from exogauge.api.live_hub import MOST_WATCHERS, WAITING_BYTES, Watcher
from exogauge.client import Client

__all__ = ["client", "folder", "payload", "rows", "service"]  # fixtures

pytestmark = pytest.mark.slow
Array = NDArray[np.float64]
END = json.dumps({"type": "end"})


def watching(service: Service, payload: str, stream: str) -> ClientConnection:
    line = opened(service, payload, f"/watch?stream={stream}")
    assert json.loads(line.recv(30)) == {"type": "stream", "stream": stream, "rate_hz": 250.0}
    return line


def test_watchers_see_every_answer_of_the_writer(service: Service, payload: str, rows: Array) -> None:
    """A line of the writer that breaks does not end theirs."""
    line, stream, _ = begun(service, payload)
    watchers = [watching(service, payload, stream) for _ in range(3)]
    for k in range(0, 500, 50):
        line.send(packed(k, rows[k : k + 50]))
    told = until(line, "wrench")
    while told[-1].get("seq", [0])[-1] < 450:
        told += until(line, "wrench")
    line.socket.shutdown(socket.SHUT_RDWR)
    time.sleep(0.5)
    line, _, welcome = begun(service, payload, f"?stream={stream}")
    line.send("no JSON")
    line.send(packed(500, rows[500:600]))
    line.send(END)
    last, _ = to_the_end(line)
    for each in watchers:
        seen, code = to_the_end(each)
        assert code == 1000
        assert told == seen[: len(told)]
        assert seen[seen.index(welcome) + 1 :] == last
        assert [message["rule"] for message in seen if message["type"] == "error"] == ["not_json"]
        assert sum(len(message["seq"]) for message in seen if message["type"] == "wrench") == 600


def test_a_watcher_that_does_not_read_costs_the_writer_nothing(service: Service, payload: str, rows: Array) -> None:
    """1.5 MB of answers, more than buffers between the two hold; who reads misses none of them."""
    line, stream, _ = begun(service, payload, "?rate_hz=1000")
    deaf_ = deaf(service, payload, stream)
    reader = opened(service, payload, f"/watch?stream={stream}")
    sent, slowest, writers, readers = 0, 0.0, list[dict[str, Any]](), list[dict[str, Any]]()
    reader.recv(30)
    while sent < 9000:  # as many at once as a burst may have
        began = time.monotonic()
        line.send(packed(sent, moved(rows, sent, 500)))
        sent += 500
        writers += until(line, "wrench")
        slowest = max(slowest, time.monotonic() - began)
        readers += until(reader, "wrench")
    line.send(END)
    last, code = to_the_end(line)
    writers += last
    readers += to_the_end(reader)[0]
    assert code == 1000
    assert writers[-1]["samples"] == sent
    assert slowest < 5.0  # a send to the deaf one would wait for 10 s
    assert readers == writers
    deaf_.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    deaf_.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_WINDOW_CLAMP, 1 << 20)  # it would stay as small as it began
    seen = list[str | bytes]()
    with pytest.raises(ConnectionClosed):
        seen.extend(iter(lambda: deaf_.recv(30), None))
    missed = [told["messages"] for told in map(json.loads, seen) if told["type"] == "missed"]
    assert missed
    assert missed[-1] + len(seen) - len(missed) == len(writers) + 1  # what the stream is comes before its answers


def test_of_what_is_offered_to_a_slow_watcher_each_is_seen_or_counted() -> None:
    offered = [json.dumps({"number": k, "long": "x" * 1000}) for k in range(1000)]
    seen = list[dict[str, Any]]()

    async def watched() -> None:
        watcher, gate = Watcher(), asyncio.Event()

        async def send(message: MutableMapping[str, Any]) -> None:
            await gate.wait()
            if "text" in message:
                seen.append(json.loads(message["text"]))

        async def receive() -> MutableMapping[str, Any]:
            if not connected:
                connected.append(True)
                return {"type": "websocket.connect"}
            await asyncio.Event().wait()
            raise AssertionError

        connected = list[bool]()
        client = WebSocket({"type": "websocket"}, receive, send)
        gate.set()
        await client.accept()
        gate.clear()
        serving = asyncio.create_task(watcher.serve(client))
        for each in offered:
            watcher.offer(each)
            await asyncio.sleep(0)
        watcher.over(1000)
        gate.set()
        await serving

    asyncio.run(watched())
    missed = [each["messages"] for each in seen if "messages" in each]
    numbers = [each["number"] for each in seen if "number" in each]
    assert missed[-1] + len(numbers) == len(offered)
    assert numbers == sorted(numbers)
    assert numbers[-1] == 999
    assert len(numbers) * 1000 < WAITING_BYTES


def deaf(service: Service, payload: str, stream: str) -> ClientConnection:
    """Takes next to nothing until it is read: small buffers, no messages ahead. Its segments are small, too: by their
    size the system measures what it keeps at the server's end: 3.9 MB with those of loopback, 69 kB with these."""
    parts = urlsplit(service.url)
    line = socket.socket()
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, 536)
    line.connect((parts.hostname, parts.port))
    address = f"{service.url.replace('http', 'ws', 1)}/api/v1/live/payload/{payload}/watch?stream={stream}"
    return connect(address, sock=line, compression=None, max_queue=1, max_size=None, ping_interval=None)


def moved(rows: Array, first: int, size: int) -> Array:
    """The log over and over, back and forth, its clock at 1 kHz."""
    number = np.arange(first, first + size)
    at = np.abs((number + len(rows) - 1) % (2 * len(rows) - 2) - (len(rows) - 1))
    found = rows[at].copy()
    found[:, 0] = number / 1000.0
    return found


def test_what_cannot_be_watched_says_why(service: Service, payload: str, rows: Array, folder: Path) -> None:
    with Client(service.url) as opened_:
        other = opened_.upload_payload(folder).id  # equal files: the same
    assert other == payload
    line, stream, _ = begun(service, payload)
    none = "00000000-0000-0000-0000-000000000000"
    assert refused(service, payload, f"/watch?stream={none}")[0] == 404
    assert refused(service, none, f"/watch?stream={stream}")[0] == 404
    assert refused(service, payload, "/watch") == (422, "this is no id")
    line.send(END)
    to_the_end(line)
    status, detail = refused(service, payload, f"/watch?stream={stream}")
    assert status == 409
    assert "has ended" in detail
    assert f"/streams/{stream}/log" in detail
    address = f"{service.url.replace('http', 'ws', 1)}/api/v1/live/payload/{payload}/watch?stream={stream}"
    with pytest.raises(InvalidStatus) as closed:
        connect(address, origin="https://elsewhere.example")
    assert closed.value.response.status_code == 403


def refused(service: Service, payload: str, query: str) -> tuple[int, str]:
    with pytest.raises(InvalidStatus) as error:
        opened(service, payload, query)
    told = json.loads(error.value.response.body)
    return error.value.response.status_code, str((told.get("errors") or [told])[0]["detail"])


def test_a_watcher_writes_nothing_and_more_than_may_watch_are_refused(
    service: Service, payload: str, rows: Array
) -> None:
    line, stream, _ = begun(service, payload)
    watchers = [watching(service, payload, stream) for _ in range(MOST_WATCHERS)]
    assert refused(service, payload, f"/watch?stream={stream}")[0] == 503
    for said in (packed(0, rows[:10]), END):
        watcher = watchers.pop()
        watcher.send(said)
        told, code = to_the_end(watcher)
        assert (code, told[-1]["rule"]) == (1008, "watcher_talks")
    line.send(packed(0, rows[:100]))
    until(line, "payload")
    line.send(END)
    told, _ = to_the_end(line)
    assert told[-1]["samples"] == 100
    for watcher in watchers:
        assert to_the_end(watcher)[1] == 1000
