"""HEAD wherever there is a GET: its status and headers without its body (RFC 9110, 9.3.2), for whoever asks how large a
download is or whether something is there. What the GET would go on to do for its body ends with the headers."""

from __future__ import annotations

import asyncio
import contextlib
from typing import final

from starlette.routing import Match
from starlette.types import ASGIApp, Message, Receive, Scope, Send


@final
class Heads:
    """ASGI middleware. A path that has a HEAD of its own answers it by itself."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "HEAD" or has_its_own(scope):
            await self.app(scope, receive, send)
            return
        told = asyncio.Event()

        async def headers_alone(message: Message) -> None:
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b""})
                told.set()

        asked = asyncio.ensure_future(self.app({**scope, "method": "GET"}, receive, headers_alone))
        ended = asyncio.ensure_future(told.wait())
        try:
            await asyncio.wait((asked, ended), return_when=asyncio.FIRST_COMPLETED)
            if told.is_set():
                asked.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await asked
        finally:
            asked.cancel()
            ended.cancel()


def has_its_own(scope: Scope) -> bool:
    return any(route.matches(scope)[0] is Match.FULL for route in scope["app"].router.routes)
