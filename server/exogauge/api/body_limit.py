"""No request body is larger than its limit: announced, it is refused at once; unannounced, it is cut off."""

from __future__ import annotations

from typing import final

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exogauge.api.problems import of_http


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
        limit = self.piece_limit if scope["method"] == "PATCH" else self.limit
        refusal = HTTPException(413, f"a request body may have at most {limit} bytes; upload large files in pieces")
        declared = Headers(scope=scope).get("content-length", "0")
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
