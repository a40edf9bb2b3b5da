"""Who asks, and whether they may, before anything of the request's body is read.

A session's key comes in a cookie, a token in `Authorization: Bearer`. The cookie is `__Host-…` where the line is
encrypted: no other host, path or unencrypted page can set or read it. A browser sends it along with whatever a page
makes it ask for; so a request that changes something by a cookie has to say which page it comes from, and `Guard` has
seen that it is ours.

A stream of events or a websocket ends soon after the session or token that began it: it is looked at again while it
lasts.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import re
import time
from dataclasses import replace
from functools import partial
from typing import final

from sqlalchemy.engine import Connection
from starlette._utils import get_route_path
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exogauge.api.dependencies import CALLER
from exogauge.api.problems import of_error, problem_response
from exogauge.api.rights import SAFE, refusal, right_of
from exogauge.api.threads import in_short_thread
from exogauge.errors import Unavailable
from exogauge.storage import callers
from exogauge.storage.callers import Caller
from exogauge.storage.secrets import hashed, is_token
from exogauge.storage.shares import host_of
from exogauge.storage.store import LOCAL, Installation

WEBSOCKET = "WEBSOCKET"
SHARED = re.compile(  # what a share lets another lab read: a study, its jobs, and all below them but who else may
    r"/api/v1/(?P<thing>studies|jobs)/(?P<key>[0-9a-fA-F-]{36})(/(?!shares(/|$)).*)?"
)
BEARER = "bearer "
LOOK_EVERY_S = 5.0  # whether who asked for a stream may still have it
SHARED_S = 1.0  # judgement: for which a look holds for other streams of the same key: 200 of them took 6 % of a core
POLICY_VIOLATION = 1008  # a close code of RFC 6455, 7.4.1
TITLES = {401: "Not signed in", 403: "Not allowed"}


@final
class Access:
    """ASGI middleware. Where the app has no accounts, all who reach the server may do all, in the settings' lab."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        # by the hash of a key: when it was looked up for a stream, and whose it was
        self._seen = dict[str, tuple[float, Caller | None]]()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        state = scope["app"].state
        if not state.accounts:
            scope[CALLER] = Caller(LOCAL, state.settings.lab, "admin")
            await self.app(scope, receive, send)
            return
        method = scope.get("method", WEBSOCKET)
        right = right_of(method, get_route_path(scope))
        try:
            scope[CALLER] = caller = await in_short_thread(self.who, scope)
        except Unavailable as error:
            await of_error(error, scope["path"])(scope, receive, send)
            return
        refused = refusal(caller, right)
        if refused is None and caller is not None and caller.session_id and method not in SAFE and pageless(scope):
            refused = 403, "a request by a cookie says which page it comes from (Origin or Sec-Fetch-Site)"
        if refused is not None:
            await answer(*refused, scope)(scope, receive, send)
        elif scope["type"] == "websocket":
            await self.line(scope, receive, send)
        elif right != "open" and method == "GET":
            await self.stream(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    def who(self, scope: Scope) -> Caller | None:
        """None where nobody is signed in; a token that is none, or is no more, is nobody too, cookie or not."""
        key, by_token = key_of(scope)
        return None if key is None else self.looked_up(scope, key, by_token)

    def looked_up(self, scope: Scope, key: str, by_token: bool, *, as_guest: bool = True) -> Caller | None:
        """Whose key it is; its use is noted. as_guest: in the lab that shares what is asked for, if another does."""
        installation: Installation = scope["app"].state.installation
        with installation.looking() as connection:
            found = callers.by_token(connection, key) if by_token else callers.by_session(connection, key)
            if found is None:
                return None
            caller, to_note = found
            host = self.host(connection, caller, scope) if as_guest else None
        if to_note:
            with contextlib.suppress(Unavailable), installation.session() as session:
                callers.note(session, caller)
        return caller if host is None else replace(caller, lab_id=host, role="viewer", guest=True)

    def host(self, connection: Connection, caller: Caller, scope: Scope) -> str | None:
        """The other lab as whose viewer this request reads a study that it shares; None: one reads one's own."""
        asked = SHARED.fullmatch(get_route_path(scope)) if scope.get("method") in ("GET", "HEAD") else None
        if asked is None or caller.lab_id is None:
            return None
        return host_of(connection, caller.lab_id, asked["thing"], asked["key"].lower())

    async def still(self, scope: Scope) -> bool:
        """A database that is away ends nothing."""
        try:
            now = await (in_short_thread(self.who, scope) if scope[CALLER].guest else self.lately(scope))
        except Unavailable:
            return True
        right = right_of(scope.get("method", WEBSOCKET), get_route_path(scope))
        return now is not None and now.lab_id == scope[CALLER].lab_id and refusal(now, right) is None

    async def lately(self, scope: Scope) -> Caller | None:
        """Who has the key, in a lab of theirs; looked up once for all streams that began with it, and then not for
        `SHARED_S`: no thread is asked either."""
        key, by_token = key_of(scope)
        if key is None:
            return None
        name, now = hashed(key), time.monotonic()
        at, caller = self._seen.get(name, (-math.inf, None))
        if now - at > SHARED_S:
            look = partial(self.looked_up, as_guest=False)
            caller = await in_short_thread(look, scope, key, by_token)
            self._seen = {each: kept for each, kept in self._seen.items() if now - kept[0] <= SHARED_S}
            self._seen[name] = now, caller
        return caller

    async def stream(self, scope: Scope, receive: Receive, send: Send) -> None:
        """An answer without an end of its own (events) is ended; a file that is under way arrives."""
        over = asyncio.Event()
        watching: asyncio.Task[None] | None = None

        async def watch() -> None:
            while await self.still(scope):
                await asyncio.sleep(LOOK_EVERY_S)
            over.set()
            await send({"type": "http.response.body", "body": b"", "more_body": False})

        async def sending(message: Message) -> None:
            nonlocal watching
            if over.is_set():
                return
            await send(message)
            if message["type"] == "http.response.start" and "content-length" not in Headers(raw=message["headers"]):
                watching = asyncio.create_task(watch())

        async def receiving() -> Message:
            came, ended = asyncio.ensure_future(receive()), asyncio.ensure_future(over.wait())
            try:
                await asyncio.wait((came, ended), return_when=asyncio.FIRST_COMPLETED)
                return came.result() if came.done() else {"type": "http.disconnect"}
            finally:
                came.cancel()
                ended.cancel()

        try:
            await self.app(scope, receiving, sending)
        finally:
            if watching is not None:
                watching.cancel()

    async def line(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def watch() -> None:
            while await self.still(scope):
                await asyncio.sleep(LOOK_EVERY_S)
            with contextlib.suppress(Exception):
                await send({"type": "websocket.close", "code": POLICY_VIOLATION, "reason": "signed out"})

        watching = asyncio.create_task(watch())
        try:
            await self.app(scope, receive, send)
        finally:
            watching.cancel()


def key_of(scope: Scope) -> tuple[str | None, bool]:
    """What the request shows to prove who asks, and whether that is a token; None for nothing, or no such thing."""
    bearer = Headers(scope=scope).get("authorization", "")
    if bearer[: len(BEARER)].lower() != BEARER:
        return session_key(HTTPConnection(scope)), False
    key = bearer[len(BEARER) :].strip()
    return key if is_token(key) else None, True


def answer(status: int, detail: str, scope: Scope) -> Response:
    headers = {"WWW-Authenticate": "Bearer"} if status == 401 else None
    slug = TITLES[status].lower().replace(" ", "-")
    return problem_response(status, slug, TITLES[status], detail, instance=scope["path"], headers=headers)


def pageless(scope: Scope) -> bool:
    headers = Headers(scope=scope)
    return "origin" not in headers and "sec-fetch-site" not in headers


def cookie_name(connection: HTTPConnection) -> str:
    """Cookies of one host are shared by its ports; unencrypted ones are of this machine alone."""
    if connection.url.scheme in ("https", "wss"):
        return "__Host-exogauge"
    return f"exogauge-{connection.url.port or 80}"


def session_key(connection: HTTPConnection) -> str | None:
    return connection.cookies.get(cookie_name(connection)) or None


def set_session(response: Response, connection: HTTPConnection, key: str) -> None:
    response.set_cookie(
        cookie_name(connection), key, max_age=int(callers.SESSION.total_seconds()), path="/",
        secure=connection.url.scheme == "https", httponly=True, samesite="lax",
    )  # fmt: skip


def end_session(response: Response, connection: HTTPConnection) -> None:
    response.delete_cookie(
        cookie_name(connection), path="/", secure=connection.url.scheme == "https", httponly=True, samesite="lax"
    )
