"""One connection from outside: how much it may say without saying anything, and how long it may take.

httptools joins the pieces of a header's value, of its name and of the path as they come in (`value += piece`): that
costs the square of their number. 20 MB of one header in pieces of 1 kB took six minutes, in which nobody else was
answered; and neither it nor uvicorn sets a limit to the size or the time of a request's head or body.

    connected ──> HEAD ──headers──> BODY ──its end──> ANSWER ──first byte of the next request──> HEAD …

Only time in which the server listened counts, look by look: a server that is busy blames nobody.
"""

from __future__ import annotations

import asyncio
import sys
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, final

from httptools import HttpParserCallbackError, HttpParserError
from uvicorn.config import Config
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.server import ServerState

from exogauge.api.problems import problem_response

MOST_HEAD = 32 * 1024  # bytes of a request's line and headers; what nginx takes, and four times our longest header
HEAD_S = 20.0  # for all of them; a line that needs longer cannot carry the smallest log either
SLOWEST = 64.0  # bytes of a body per second, in the mean …
GRACE_S = 120.0  # … once it has taken so long
LOOK_EVERY_S = 0.5
LINGER_S = (
    0.5  # between a refusal and the end, in which what still comes is thrown away: else its reset hides the answer
)


class Stage(Enum):
    """What the connection is at."""

    HEAD = auto()
    BODY = auto()
    ANSWER = auto()  # or nothing: uvicorn ends connections that stay so for 5 s
    ENDING = auto()


@final
@dataclass(frozen=True)
class Limits:
    """connections: at once. silence_s: between two pieces of a request."""

    connections: int
    silence_s: float


class Connection(HttpToolsProtocol):
    """uvicorn's protocol within limits."""

    limits = Limits(connections=256, silence_s=30.0)

    def __init__(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self.stage = Stage.HEAD
        self.since = self.loop.time()  # of the stage
        self._unclear = 0  # bytes that came after the last whole head, piece of a body, or end of one
        self._received = 0  # bytes of the stage
        self._listened = self._silent = 0.0  # seconds of the stage; since its last byte
        self._next_look: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        if len(self.connections) > self.limits.connections and not self._someone_gives_way():
            self.refuse(503, "Too many connections", "all connections are in use; try again in a moment")
            return
        self._begin(Stage.HEAD)

    def _someone_gives_way(self) -> bool:
        """End the connection that waits longest without a request; False where all have one."""
        waiting = [
            each for each in self.connections if isinstance(each, Connection) and each.waits and each is not self
        ]
        if not waiting:
            return False
        min(waiting, key=lambda each: each.since).transport.abort()
        return True

    @property
    def waits(self) -> bool:
        """Neither body nor answer is under way."""
        return self.stage in (Stage.HEAD, Stage.ANSWER) and (self.cycle is None or self.cycle.response_complete)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._next_look is not None:
            self._next_look.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """In pieces that no head is too long for, so that it is refused before it is read to its end."""
        at = 0
        while at < len(data) and self.stage is not Stage.ENDING and not self.transport.is_closing():
            if self._unclear >= MOST_HEAD:
                self.refuse(431, "Header too large", f"line and headers of a request may have {MOST_HEAD} bytes")
                return
            if self.stage is Stage.ANSWER:
                self._begin(Stage.HEAD)
            piece = data[at : at + MOST_HEAD - self._unclear]
            at += len(piece)
            self._unclear += len(piece)
            self._received += len(piece)
            self._silent = 0.0
            super().data_received(piece)

    def on_headers_complete(self) -> None:
        self._unclear = 0
        self._begin(Stage.BODY)
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        self._unclear = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        self._unclear = 0
        self._begin(Stage.ANSWER)
        super().on_message_complete()

    def _begin(self, stage: Stage) -> None:
        self.stage, self.since = stage, self.loop.time()
        self._received, self._listened, self._silent = 0, 0.0, 0.0
        if self._next_look is None:
            self._next_look = self.loop.call_later(LOOK_EVERY_S, self._look)

    def _look(self) -> None:
        """Again and again, for as long as something is to come."""
        self._next_look = None
        if self.stage not in (Stage.HEAD, Stage.BODY):
            return
        if not self.flow.read_paused:
            self._listened += LOOK_EVERY_S
            self._silent += LOOK_EVERY_S
            if self._late():
                detail = f"the request's {self.stage.name.lower()} did not come in time"
                self.refuse(408, "Too slow", detail, say=self._received > 0 or self.stage is Stage.BODY)
                return
        self._next_look = self.loop.call_later(LOOK_EVERY_S, self._look)

    def _late(self) -> bool:
        most = HEAD_S if self.stage is Stage.HEAD else GRACE_S + self._received / SLOWEST
        return self._silent > self.limits.silence_s or self._listened > most

    def handle_websocket_upgrade(self) -> None:
        """From here on these limits end: `api.live` has its own, and as many streams as the settings allow."""
        self.stage = Stage.ENDING
        if self._next_look is not None:
            self._next_look.cancel()
        super().handle_websocket_upgrade()

    def send_400_response(self, msg: str) -> None:
        """Called where the parser has raised what it found."""
        found = sys.exc_info()[1]
        ours = not isinstance(found, HttpParserError) or isinstance(found, HttpParserCallbackError)
        self.refuse(400, "Not a request", msg if ours else f"{msg} {found}.")

    def refuse(self, status: int, title: str, detail: str, *, say: bool = True) -> None:
        """Answer with a problem where no other answer has begun, and end."""
        self.stage = Stage.ENDING
        if self.transport.is_closing():
            return
        begun = False
        if self.cycle is not None and not self.cycle.response_complete:
            begun = self.cycle.response_started
            self.cycle.disconnected = True  # the app hears of it, and says nothing more
            self.cycle.message_event.set()
        if begun or not say:
            self.transport.abort()
            return
        slug = title.lower().replace(" ", "-")
        again = {"retry-after": "1"} if status == 503 else {}
        answer = problem_response(status, slug, title, detail, headers={"connection": "close", **again})
        head = b"".join(name + b": " + value + b"\r\n" for name, value in answer.raw_headers)
        self.transport.write(b"HTTP/1.1 %d %s\r\n%s\r\n%s" % (status, title.encode(), head, bytes(answer.body)))
        self.transport.write_eof()
        self.loop.call_later(LINGER_S, self.transport.abort)


def connection_within(limits: Limits) -> type[Connection]:
    """The protocol that uvicorn makes one of for each connection."""
    return type("LimitedConnection", (Connection,), {"limits": limits})
