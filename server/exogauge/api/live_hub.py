"""Live streams of this server: one process for each, and who is connected to it. Messages are passed on unread.

Who looks at a live stream that somebody else writes. What is not taken in time is missed and counted; neither the
writer nor the stream's process ever waits for a watcher.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import shutil
import socket
import sys
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, final

from fastapi import WebSocket
from starlette.concurrency import run_in_threadpool

from exogauge.blas_threads import one_thread
from exogauge.errors import Conflict, Fault, NotFound, Unavailable
from exogauge.payload.live_messages import CLIENT_TEXT, CONTROL, Frames, framed
from exogauge.settings import Settings
from exogauge.storage.blobs import disk
from exogauge.storage.live_streams import Counts, lab_of_stream
from exogauge.storage.records import LiveStreamRecord
from exogauge.storage.store import Installation, Storage

log = logging.getLogger(__name__)

SEND_S = 10.0  # for which a client may leave what it is told unread
MOST_WATCHERS = 16  # of one stream: what one answer may cost the loop that all streams share
KEPT_EVERY_S = 5.0  # between two times that the counts go to the database
PROCESS = (sys.executable, "-m", "exogauge.payload.live_process")
DIED = Fault(
    "the process of the stream died", "stream_died",
    "Connect again with the stream's id, and send again from `next` on; what was taken is kept.", "stream",
)  # fmt: skip


@final
class Running:
    """One stream and its process. storage: its lab's."""

    def __init__(self, storage: Storage, key: str, folder: Path, rate_hz: float) -> None:
        self.storage = storage
        self.key, self.folder, self.rate_hz = key, folder, rate_hz
        self.taken = True  # by a writer, who may not be connected yet
        self.client: WebSocket | None = None
        self.watchers = set[Watcher]()
        self.counts: Mapping[str, Any] = {}
        self.ended: Mapping[str, Any] | None = None
        self.refused = False
        self.told = asyncio.Event()  # to all who are there, why it is over
        self.process: asyncio.subprocess.Process | None = None
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None

    async def start(self, silence_s: float) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            self.process = await asyncio.create_subprocess_exec(
                *PROCESS, str(self.folder), str(self.rate_hz), str(silence_s), str(theirs.fileno()),
                pass_fds=[theirs.fileno()], stdin=asyncio.subprocess.DEVNULL, env=one_thread(os.environ),
            )  # fmt: skip
        self._reader, self._writer = await asyncio.open_connection(sock=ours)

    async def pass_on(self, kind: int, content: bytes) -> None:
        """To the process; waits while it is busy. ConnectionError: it is gone."""
        assert self._writer is not None
        if self._writer.is_closing():  # uvloop's transport would say so with a RuntimeError
            raise ConnectionResetError("the process of the stream is gone")
        self._writer.write(framed(kind, content))
        await self._writer.drain()

    async def listen(self) -> None:
        """Until the process is gone."""
        assert self._reader is not None
        assert self.process is not None
        frames, kept = Frames(), time.monotonic()
        with contextlib.suppress(ConnectionError):
            while data := await self._reader.read(1 << 16):
                for kind, content in frames.of(data):
                    if kind == CLIENT_TEXT:
                        await self.tell(content.decode())
                    else:
                        await self._control(json.loads(content))
                if time.monotonic() - kept > KEPT_EVERY_S:
                    kept = time.monotonic()
                    await run_in_threadpool(self._keep_counts)
        await self.process.wait()

    async def _control(self, said: Mapping[str, Any]) -> None:
        self.counts = said.get("counts", self.counts)
        self.ended = said.get("ended", self.ended)
        self.refused |= "fatal" in said
        if "close" in said:
            await self.leave(said["close"])

    async def tell(self, text: str) -> None:
        """Those who watch, and the client, if there is one and it listens."""
        for watcher in self.watchers:
            watcher.offer(text)
        client = self.client
        if client is None:
            return
        try:
            async with asyncio.timeout(SEND_S):
                await client.send_text(text)
        except Exception:  # gone, going, or deaf: whoever receives from it will see
            self.client = None
            with contextlib.suppress(Exception):
                await client.close(1008)

    async def leave(self, code: int) -> None:
        """The client. Who watches stays: somebody may take the stream up again."""
        client, self.client = self.client, None
        if client is not None:
            with contextlib.suppress(Exception):
                await client.close(code)

    async def over(self, code: int) -> None:
        """For all who are there."""
        for watcher in self.watchers:
            watcher.over(code)
        await self.leave(code)

    def _keep_counts(self) -> None:
        with contextlib.suppress(Unavailable), self.storage.transaction() as store:
            store.live_streams.count(self.key, self.row())

    def row(self) -> Counts:
        count = self.counts
        lost = sum(count.get(name, 0) for name in ("missing", "doubled", "out_of_order", "refused"))
        return Counts(count.get("taken", 0), lost, count.get("late", 0), count.get("last"))

    def stop(self) -> None:
        """The process sees that nobody is there, and leaves."""
        if self._writer is not None:
            self._writer.close()


@final
class Hub:
    """All streams of this server, each of its lab. Belongs to the event loop."""

    def __init__(self, installation: Installation, settings: Settings) -> None:
        self._installation, self._settings = installation, settings
        self._folder = settings.live
        self._running = dict[str, Running]()
        self._tasks = set[asyncio.Task[None]]()

    def begin(self) -> None:
        """Streams that an earlier server left: whoever sent them has as long as ever to come back."""
        if self._folder.is_dir():
            for folder in self._folder.iterdir():
                self._later(self._bury(folder.name))

    def close(self) -> None:
        for each in self._running.values():
            each.stop()
        for task in self._tasks:
            task.cancel()

    async def attach(self, storage: Storage, payload_id: str, key: str | None, rate_hz: float) -> Running:
        """The stream of this key, or a new one, taken by a writer. Raises NotFound, Conflict, Unavailable."""
        found = None if key is None else await run_in_threadpool(self._found, storage, payload_id, key)
        if key is not None and key in self._running:
            running = self._running[key]
            if running.taken:
                raise Conflict(f"stream {key} has a writer; a stream takes one at a time")
            if running.rate_hz != rate_hz:
                raise Conflict(f"stream {key} has {running.rate_hz:g} Hz; begin another for another rate")
            running.taken = True
            return running
        if len(self._running) >= self._settings.max_live_streams:
            most = self._settings.max_live_streams
            raise Unavailable(f"{most} live streams are under way, as many as may be (EXOGAUGE_MAX_LIVE_STREAMS)")
        if key is None or found is None:
            key = await run_in_threadpool(self._new, storage, payload_id, rate_hz)
        else:
            rate_hz = self._old(found)
        if key in self._running:
            raise Conflict(f"stream {key} has a writer; a stream takes one at a time")
        running = self._running[key] = Running(storage, key, self._folder / key, rate_hz)
        try:
            await running.start(self._settings.silence_s)
        except OSError as error:
            del self._running[key]
            raise Unavailable(f"cannot start the process of a stream now: {error.strerror}") from error
        self._later(self._follow(running))
        return running

    async def watch(self, storage: Storage, payload_id: str, key: str) -> Running:
        """A stream that runs, to look at. Raises NotFound, Conflict, Unavailable."""
        found = await run_in_threadpool(self._found, storage, payload_id, key)
        running = self._running.get(key)
        if running is None and found.state == "open":
            self._refuse_elsewhere(key)
            raise Conflict(f"nobody sends stream {key} now; watch it when its writer is back")
        if running is None:
            raise Conflict(f"stream {key} has ended; GET /api/v1/streams/{key}/log is what came")
        if len(running.watchers) >= MOST_WATCHERS:
            raise Unavailable(f"{MOST_WATCHERS} watch stream {key}, as many as may")
        return running

    def _new(self, storage: Storage, payload_id: str, rate_hz: float) -> str:
        with storage.transaction() as store:
            key = store.live_streams.begin(payload_id, summary={"rate_hz": rate_hz}).id
        with storage.reading() as store, disk("begin a stream"):
            store.payloads.write_to(payload_id, self._folder / key / "payload")
        return key

    def _old(self, found: LiveStreamRecord) -> float:
        """Its rate. Of a stream whose process, or server, is no more."""
        if found.state == "open":
            self._refuse_elsewhere(found.id)
        if found.state != "open":
            raise Conflict(f"stream {found.id} has ended; begin another")
        return float(found.summary["rate_hz"])

    def _refuse_elsewhere(self, key: str) -> None:
        """A stream lies at the server that took it."""
        if not (self._folder / key).is_dir():
            raise Conflict(
                f"stream {key} is not at this server. Where there are several, their proxy has to send all that "
                "concerns one payload to one of them"
            )

    def _found(self, storage: Storage, payload_id: str, key: str) -> LiveStreamRecord:
        with storage.reading() as store:
            found = store.live_streams.get(key)
        if found.payload_id != payload_id:
            raise NotFound(f"payload {payload_id} has no stream {key}")
        return found

    async def _follow(self, running: Running) -> None:
        try:
            await self._until_over(running)
        finally:
            running.told.set()

    async def _until_over(self, running: Running) -> None:
        await running.listen()
        if running.ended is not None:
            await run_in_threadpool(self._end, running.storage, running.key, running.row(), "ended")
            del self._running[running.key]
            await running.tell(json.dumps({**running.ended, "stream": running.key}))
            await running.over(1000)
        elif running.refused:
            await run_in_threadpool(self._end, running.storage, running.key, running.row(), "ended")
            del self._running[running.key]
            await running.over(1008)
        else:
            assert running.process is not None
            log.warning("the process of stream %s ended with code %s", running.key, running.process.returncode)
            del self._running[running.key]
            told = {"type": "error", "detail": DIED.detail, "rule": DIED.rule, "advice": DIED.advice, "faults": 1}
            await running.tell(json.dumps(told))
            await running.over(1011)
            self._later(self._bury(running.key, running.storage, running.row()))
        running.stop()

    async def _bury(self, key: str, storage: Storage | None = None, counts: Counts | None = None) -> None:
        """A stream without a process: nobody came back to it."""
        await asyncio.sleep(self._settings.silence_s)
        if key in self._running or not (self._folder / key).is_dir():
            return
        done = await asyncio.create_subprocess_exec(*PROCESS, str(self._folder / key), "finish")
        await done.wait()
        await run_in_threadpool(self._end, storage, key, counts, "lost")

    def _end(self, storage: Storage | None, key: str, counts: Counts | None, state: Literal["ended", "lost"]) -> None:
        """The log becomes a blob, then the row says so, then the folder goes."""
        folder = self._folder / key
        try:
            made = folder / "log.parquet"
            storage = storage or self._storage_of(key)
            raw = (storage.blobs.put(made), made.stat().st_size) if made.is_file() else None
            with storage.transaction() as store:
                if counts is None:
                    row = store.live_streams.get(key)
                    counts = Counts(row.samples, row.dropped, row.late, row.last_sequence)
                store.live_streams.end(key, counts, state, raw)
        except (NotFound, Unavailable) as error:
            log.warning("stream %s cannot be closed now: %s", key, error)  # the next server tries again
            return
        shutil.rmtree(folder, ignore_errors=True)

    def _storage_of(self, key: str) -> Storage:
        """Of a stream that an earlier server left on the disk."""
        with self._installation.session() as session:
            lab_id = lab_of_stream(session, key)
        if lab_id is None:
            raise NotFound(f"there is no stream {key}")
        return self._installation.of_lab(lab_id)

    def _later(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


async def greet(running: Running) -> None:
    """The process says hello to whoever has come."""
    await running.pass_on(CONTROL, b"{}")


WAITING_BYTES = 256 * 1024  # for one watcher: a second of answers at 1 kHz, one by one
TALKS = Fault("a watcher only listens", "watcher_talks", "Send samples as the stream's writer, without `/watch`.")


@final
class Watcher:
    """Answers that wait for one watcher, the newest `WAITING_BYTES` of them."""

    def __init__(self) -> None:
        self.missed = 0  # answers
        self._waiting, self._size = deque[str](), 0
        self._news = asyncio.Event()
        self._code: int | None = None

    def offer(self, text: str) -> None:
        """Returns at once. The oldest make room; one alone always fits."""
        self._waiting.append(text)
        self._size += len(text)
        while self._size > WAITING_BYTES and len(self._waiting) > 1:
            self._size -= len(self._waiting.popleft())
            self.missed += 1
        self._news.set()

    def over(self, code: int) -> None:
        self._code = code
        self._news.set()

    async def serve(self, client: WebSocket) -> None:
        """Until the stream is over, or the client is gone, deaf, or talks."""
        sending = asyncio.create_task(self._send(client))
        hearing = asyncio.create_task(client.receive())
        try:
            await asyncio.wait((sending, hearing), return_when=asyncio.FIRST_COMPLETED)
            talks = hearing.done() and hearing.result()["type"] != "websocket.disconnect"
        finally:
            for task in (sending, hearing):
                task.cancel()
            await asyncio.gather(sending, hearing, return_exceptions=True)
        if talks:
            said = {"type": "error", "detail": TALKS.detail, "rule": TALKS.rule, "advice": TALKS.advice, "faults": 1}
            async with asyncio.timeout(SEND_S):
                await client.send_text(json.dumps(said))
                await client.close(1008)

    async def _send(self, client: WebSocket) -> None:
        told = 0
        while True:
            if self.missed > told:
                told = self.missed
                text = json.dumps({"type": "missed", "messages": told})
            elif self._waiting:
                text = self._waiting.popleft()
                self._size -= len(text)
            elif self._code is not None:
                await client.close(self._code)
                return
            else:
                self._news.clear()
                await self._news.wait()
                continue
            async with asyncio.timeout(SEND_S):
                await client.send_text(text)
