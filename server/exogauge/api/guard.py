"""Outer guards of every request: who may be asked for, from which page, and what a browser may do with the answer.

With accounts or without, the service must not be usable from a web page that its user happens to visit: a request that
changes something must come from our own page or from no page, and a server on the loopback interface answers only to
names that nobody can register (addresses and names without a dot), against DNS rebinding.

No request body is larger than its limit: announced, it is refused at once; unannounced, it is cut off.
"""

from __future__ import annotations

from ipaddress import ip_address
from typing import final
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exogauge.api.problems import of_http, problem_response

WEBSOCKET = "WEBSOCKET"  # in place of a method: not safe, as its sender reads and writes
SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
PLAIN = "identity"
OWN_PAGES = ("same-origin", "none")
PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


@final
class Guard:
    """ASGI middleware. local_only: the server listens on the loopback interface."""

    def __init__(self, app: ASGIApp, local_only: bool) -> None:
        self.app = app
        self.local_only = local_only

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        refusal = self.refusal(scope.get("method", WEBSOCKET), headers)
        if refusal is not None:
            response = problem_response(403, "foreign-page", "Refused", refusal, instance=scope["path"])
            await response(scope, receive, send)
            return

        await self.app(scope, receive, Guarded(scope, receive, send) if scope["type"] == "http" else send)

    def refusal(self, method: str, headers: Headers) -> str | None:
        host = headers.get("host", "")
        if self.local_only and not cannot_be_registered(host):
            return "this server answers on this machine only; EXOGAUGE_HOST lets it serve under a public name"
        if method in SAFE_METHODS:
            return None
        site = headers.get("sec-fetch-site")
        if site is not None:
            return None if site in OWN_PAGES else "the request comes from a page of another site"
        origin = headers.get("origin")
        if origin is not None and host_in(origin) != host.lower():
            return "the request comes from a page of another origin"
        return None


@final
class Guarded:
    """`send` with our headers on every answer, and a problem document in place of the framework's few plain-text
    refusals (a range that cannot be satisfied)."""

    def __init__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self.scope, self.receive, self.send = scope, receive, send
        self.replaced = False

    async def __call__(self, message: Message) -> None:
        if self.replaced:
            return
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            if message["status"] >= 400 and headers.get("content-type", "text/plain").startswith("text/plain"):
                await self.replace(message["status"], headers)
                return
            add_headers(headers)
        await self.send(message)

    async def replace(self, status: int, headers: MutableHeaders) -> None:
        kept = {name: value for name, value in headers.items() if name in ("content-range", "allow", "retry-after")}
        response = of_http(HTTPException(status, headers=kept), self.scope["path"])
        await response(self.scope, self.receive, Guarded(self.scope, self.receive, self.send))
        self.replaced = True


def host_in(origin: str) -> str | None:
    """With its port; None where it is no address."""
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return None


def cannot_be_registered(host: str) -> bool:
    """An address, or a name without a dot (`localhost`)."""
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return False
    if name in ("", "localhost") or name.endswith(".localhost"):
        return True
    try:
        ip_address(name)
    except ValueError:
        return "." not in name
    return True


def add_headers(headers: MutableHeaders) -> None:
    headers.setdefault("Content-Security-Policy", PAGE_POLICY)
    headers.setdefault("Cache-Control", "no-cache")
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Referrer-Policy"] = "no-referrer"
    headers["Cross-Origin-Resource-Policy"] = "same-origin"


@final
class BodyLimit:
    """ASGI middleware. limit: bytes. piece_limit: bytes of a PATCH, which only resumable uploads take and which goes
    straight to the disk."""

    def __init__(self, app: ASGIApp, limit: int, piece_limit: int) -> None:
        self.app = app
        self.limit, self.piece_limit = limit, piece_limit

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        packed = headers.get("content-encoding", PLAIN).strip().lower()
        if packed != PLAIN and scope["method"] not in SAFE_METHODS:
            detail = (
                f"no body is taken as Content-Encoding: {packed[:80]}; send it as it is, or as a zip where one may be"
            )
            unpack = HTTPException(415, detail, {"Accept-Encoding": PLAIN})
            await of_http(unpack, scope["path"])(scope, receive, send)
            return
        limit = self.piece_limit if scope["method"] == "PATCH" else self.limit
        refusal = HTTPException(413, f"a request body may have at most {limit} bytes; upload large files in pieces")
        declared = headers.get("content-length", "0")
        if not declared.isdecimal() or int(declared) > limit:
            await of_http(refusal, scope["path"])(scope, receive, send)
            return
        received = 0

        async def receive_counted() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > limit:
                raise refusal
            return message

        await self.app(scope, receive_counted, send)
