"""`Idempotency-Key` on every POST: a request that is sent twice happens once.

Same key and same request: the same answer, with `Idempotency-Replayed: true`. Another request under the key: 422.
The first one still running, in whichever process: 409. An answer that asks to try again (5xx, 429) is not kept, nor is
one that shows a secret. The key is its lab's and is kept for a day. A server that was killed holds a key no longer than
its lease. A multipart boundary is no part of the request: clients make a new one for each attempt.
"""

from __future__ import annotations

import asyncio
import base64
import hashlib
import logging
import re
from collections.abc import Mapping
from datetime import timedelta
from email.message import Message as Headers_
from typing import Any, final

from starlette._utils import get_route_path
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exogauge.api.dependencies import storage_of
from exogauge.api.problems import of_error, of_http, problem_response
from exogauge.errors import Unavailable
from exogauge.storage.keys import Held, UsedKey
from exogauge.storage.store import Storage

log = logging.getLogger(__name__)

LEASE = timedelta(seconds=10)  # of a key, put off three times in it while its request is served
LONGEST_KEY = 255
USABLE = re.compile(rf"[!-~]{{1,{LONGEST_KEY}}}")
LONGEST_ANSWER = 1024 * 1024
SECRET = re.compile(
    r"/api/v1/(session|set-up|invitations|tokens|lab/invitations|webhooks|oidc)\b"
)  # answers that are kept nowhere
KEPT_HEADERS = (b"content-type", b"location", b"etag", b"upload-expires", b"upload-offset")
SAYING = ("upload-length", "upload-metadata")  # headers that are what a request asks for


@final
class Idempotency:
    """ASGI middleware around the whole API."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        key = Headers(scope=scope).get("idempotency-key") if scope["type"] == "http" else None
        if key is None or scope["method"] != "POST" or SECRET.match(get_route_path(scope)):
            await self.app(scope, receive, send)
            return
        if not USABLE.fullmatch(key):
            detail = f"the Idempotency-Key must have 1 to {LONGEST_KEY} printable ASCII characters, no spaces"
            await problem_response(422, "bad-idempotency-key", "Unusable key", detail)(scope, receive, send)
            return
        storage = storage_of(HTTPConnection(scope))
        body = HashedBody(scope, receive)
        try:
            found = await run_in_threadpool(reserve, storage, key)
            if isinstance(found, Held):
                await self._first(storage, found, body, scope, send)
            else:
                await replay(found, body, scope, send)
        except Unavailable as error:
            await of_error(error)(scope, receive, send)
        except HTTPException as error:
            await of_http(error)(scope, receive, send)

    async def _first(self, storage: Storage, held: Held, body: HashedBody, scope: Scope, send: Send) -> None:
        """Run the request, keep its answer, and only then send it."""
        answer, holding = Answer(), asyncio.create_task(hold_on(storage, held))
        try:
            await self.app(scope, body.receive, answer.take)
            if answer.is_final and body.complete:
                await run_in_threadpool(keep, storage, held, body.digest(), answer.document())
            else:
                await run_in_threadpool(release, storage, held)
        except BaseException:
            await run_in_threadpool(release, storage, held)
            raise
        finally:
            holding.cancel()
        await answer.send_to(send)


@final
class HashedBody:
    """The request body, hashed while the app reads it."""

    def __init__(self, scope: Scope, receive: Receive) -> None:
        self._receive = receive
        headers = Headers(scope=scope)
        self.complete = headers.get("content-length", "0") == "0" and "transfer-encoding" not in headers
        kind, self._boundary = content_type(headers.get("content-type", ""))
        head = [scope["method"], scope["path"], scope.get("query_string", b"").decode("latin-1"), kind]
        head += [f"{name}: {headers[name]}" for name in SAYING if name in headers]
        self._hash = hashlib.sha256("\0".join(head).encode())
        self._tail = b""

    async def receive(self) -> Message:
        message = await self._receive()
        if message["type"] == "http.request":
            self._feed(message.get("body", b""))
            self.complete = not message.get("more_body", False)
        return message

    async def drain(self) -> None:
        while not self.complete:
            if (await self.receive())["type"] == "http.disconnect":
                return

    def _feed(self, chunk: bytes) -> None:
        """Hash the chunk with every boundary taken out; what may be the start of one waits for the next chunk."""
        if not self._boundary:
            self._hash.update(chunk)
            return
        text = (self._tail + chunk).replace(self._boundary, b"")
        kept = max(len(text) - len(self._boundary) + 1, 0)
        self._hash.update(text[:kept])
        self._tail = text[kept:]

    def digest(self) -> str:
        self._hash.update(self._tail)
        self._tail = b""
        return self._hash.hexdigest()


@final
class Answer:
    """An answer held back until it is recorded."""

    def __init__(self) -> None:
        self.status, self.headers, self.body = 0, [(b"", b"")], b""

    async def take(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.status, self.headers = message["status"], list(message["headers"])
        elif message["type"] == "http.response.body":
            self.body += message.get("body", b"")

    @property
    def is_final(self) -> bool:
        return 200 <= self.status < 500 and self.status != 429 and len(self.body) <= LONGEST_ANSWER

    def document(self) -> dict[str, Any]:
        kept = [(name.decode(), value.decode("latin-1")) for name, value in self.headers if name in KEPT_HEADERS]
        return {"status": self.status, "headers": kept, "body": base64.b64encode(self.body).decode()}

    async def send_to(self, send: Send) -> None:
        await send({"type": "http.response.start", "status": self.status, "headers": self.headers})
        await send({"type": "http.response.body", "body": self.body})


async def replay(used: UsedKey, body: HashedBody, scope: Scope, send: Send) -> None:
    await body.drain()
    if used.answer is None:
        detail = "the first request with this Idempotency-Key is still being served; try again in a moment"
        response = problem_response(409, "request-in-flight", "In flight", detail, headers={"Retry-After": "1"})
        await response(scope, body.receive, send)
    elif used.request_hash != body.digest():
        detail = "this Idempotency-Key was used for another request; take a new key for a new request"
        await problem_response(422, "idempotency-key-reused", "Key used before", detail)(scope, body.receive, send)
    else:
        await send_kept(used.answer, send)


async def send_kept(answer: Mapping[str, Any], send: Send) -> None:
    body = base64.b64decode(answer["body"])
    headers = [(name.encode(), value.encode("latin-1")) for name, value in answer["headers"]]
    headers += [(b"idempotency-replayed", b"true"), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": answer["status"], "headers": headers})
    await send({"type": "http.response.body", "body": body})


def content_type(text: str) -> tuple[str, bytes]:
    """The media type without its parameters, and a multipart boundary where there is one."""
    header = Headers_()
    header["content-type"] = text
    boundary = header.get_param("boundary")
    return header.get_content_type(), boundary.encode("latin-1", "replace") if isinstance(boundary, str) else b""


async def hold_on(storage: Storage, held: Held) -> None:
    """Keep the lease of a request that takes long, until it is cancelled or the lease is lost."""
    while True:
        await asyncio.sleep(LEASE.total_seconds() / 3)
        try:
            if not await run_in_threadpool(hold_on_once, storage, held):
                log.warning("a request under an Idempotency-Key was silent for longer than its lease")
                return
        except Unavailable as error:
            log.warning("the lease of an Idempotency-Key is not renewed: %s", error)


def hold_on_once(storage: Storage, held: Held) -> bool:
    with storage.transaction() as store:
        return store.keys.hold_on(held, LEASE)


def reserve(storage: Storage, key: str) -> Held | UsedKey:
    with storage.transaction() as store:
        return store.keys.reserve(key, LEASE)


def keep(storage: Storage, held: Held, request_hash: str, answer: Mapping[str, Any]) -> None:
    with storage.transaction() as store:
        store.keys.answer(held, request_hash, answer)


def release(storage: Storage, held: Held) -> None:
    with storage.transaction() as store:
        store.keys.release(held)
