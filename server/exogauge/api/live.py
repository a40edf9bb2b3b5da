"""Live streams of a payload's sensor: a websocket for samples and answers, and what was recorded."""

from __future__ import annotations

import json
import time
from datetime import datetime
from typing import Any, final
from uuid import UUID

from fastapi import Request, Response, WebSocket, WebSocketDisconnect
from starlette.concurrency import run_in_threadpool

from exogauge.api.dependencies import Cursor, Id, Limit, ReaderDep, encoded_cursor, storage_of
from exogauge.api.live_hub import Hub, Running, Watcher, greet
from exogauge.api.problems import of_error
from exogauge.api.results import ANY_FILE, file_response
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import BadInput, ExogaugeError, Fault, NotFound
from exogauge.payload.live_messages import CLIENT_BYTES, CLIENT_TEXT

router = Router(tags=["live"])

MOST_BYTES = 256 * 1024  # of a message: 1024 samples of 30 columns
MOST_MESSAGES = 2000  # per second: a sample each at 1 kHz, and as much again
RATES = (20.0, 1000.0)


@final
class LiveStreamOut(Answer):
    """state: open, ended, or lost (whoever sent or took it went without a word). dropped: refused, doubled, out of
    order, or never arrived. size: of the log [bytes], None while there is none."""

    id: str
    payload_id: str
    state: str
    started_at: datetime
    ended_at: datetime | None
    samples: int
    dropped: int
    late: int
    last_sequence: int | None
    size: int | None


@final
class LiveStreamList(ListOf):
    items: list[LiveStreamOut]


@router.get("/payloads/{payload_id}/streams", operation_id="listLiveStreams")
def list_streams(payload_id: Id, store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> LiveStreamList:
    """Newest first."""
    store.payloads.get(str(payload_id))
    page = store.live_streams.page(cursor, limit, payload_id=str(payload_id))
    items = [LiveStreamOut.model_validate(each) for each in page.items]
    return LiveStreamList(items=items, next_cursor=encoded_cursor(page.after))


@router.get("/streams/{stream_id}/log", operation_id="getLiveStreamLog", responses=ANY_FILE)
def get_stream_log(stream_id: Id, store: ReaderDep, request: Request) -> Response:
    """What came, as Parquet with the columns of payload.yaml; there once the stream has ended."""
    stream = store.live_streams.get(str(stream_id))
    if stream.sha256 is None:
        raise NotFound(f"stream {stream.id} has no log: it is open, or nothing came")
    return file_response(store.blobs, request, stream.sha256, f"{stream.id}.parquet", "application/vnd.apache.parquet")


@router.websocket("/live/payload/{payload_id}")
async def follow(client: WebSocket, payload_id: str) -> None:
    """docs/payload.md says what is sent and answered. Refusals before it begins are problem documents."""
    try:
        running = await attached(client, payload_id)
    except ExogaugeError as error:
        await client.send_denial_response(of_error(error, client.url.path))
        return
    try:
        await client.accept()
        await client.send_text(json.dumps({"type": "stream", "stream": running.key}))
        running.client = client
        await greet(running)
        await listen(client, running)
    except ConnectionError:  # the process is gone: who follows it says why, and needs the line for that
        await running.told.wait()
    except WebSocketDisconnect:
        pass
    finally:
        if running.client in (client, None):
            running.client, running.taken = None, False


@router.websocket("/live/payload/{payload_id}/watch")
async def watch(client: WebSocket, payload_id: str, stream: str = "") -> None:
    """Every answer that the stream's writer gets from now on, for others to see; nothing is taken from them."""
    hub: Hub = client.app.state.live
    try:
        running = await hub.watch(storage_of(client), _id(payload_id, "payload_id"), _id(stream, "stream"))
    except ExogaugeError as error:
        await client.send_denial_response(of_error(error, client.url.path))
        return
    watcher = Watcher()
    watcher.offer(json.dumps({"type": "stream", "stream": running.key, "rate_hz": running.rate_hz}))
    running.watchers.add(watcher)
    try:
        await client.accept()
        await watcher.serve(client)
    except (ConnectionError, TimeoutError, WebSocketDisconnect, RuntimeError):
        pass  # gone or going
    finally:
        running.watchers.discard(watcher)


async def attached(client: WebSocket, payload_id: str) -> Running:
    hub: Hub = client.app.state.live
    storage = storage_of(client)
    payload = _id(payload_id, "payload_id")
    stream = client.query_params.get("stream")
    rate_hz = _rate(client.query_params.get("rate_hz", "250"))

    def check() -> None:
        with storage.reading() as store:
            store.payloads.get(payload)

    await run_in_threadpool(check)
    return await hub.attach(storage, payload, None if stream is None else _id(stream, "stream"), rate_hz)


async def listen(client: WebSocket, running: Running) -> None:
    """Passes on until the client is gone or breaks a rule of the line."""
    since, count = time.monotonic(), 0
    while (message := await client.receive())["type"] != "websocket.disconnect":
        text, data = message.get("text"), message.get("bytes")
        content = text.encode() if text is not None else data or b""
        now = time.monotonic()
        if now - since >= 1.0:
            since, count = now, 0
        count += 1
        if count > MOST_MESSAGES:
            advice = "Put several samples into one message."
            await refuse(running, Fault(f"more than {MOST_MESSAGES} messages per second", "too_fast", advice))
            return
        if len(content) > MOST_BYTES:
            fault = Fault(
                f"a message may have {MOST_BYTES} bytes", "too_large", "Send several.", value=str(len(content))
            )
            await refuse(running, fault)
            return
        await running.pass_on(CLIENT_TEXT if text is not None else CLIENT_BYTES, content)


async def refuse(running: Running, fault: Fault) -> None:
    told: dict[str, Any] = {"type": "error", "detail": fault.detail, "rule": fault.rule, "advice": fault.advice}
    await running.tell(json.dumps({**told, "faults": 1} | ({} if fault.value is None else {"value": fault.value})))
    await running.leave(1008)


def _id(text: str, name: str) -> str:
    try:
        return str(UUID(text))
    except ValueError as error:
        raise BadInput(Fault("this is no id", "no_id", "Give the id as the service did.", column=name)) from error


def _rate(text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = 0.0
    if not RATES[0] <= rate <= RATES[1]:
        detail = f"`rate_hz` is a number from {RATES[0]:g} to {RATES[1]:g}"
        raise BadInput(Fault(detail, "no_rate", "Say how many samples come per second.", column="rate_hz"))
    return rate
