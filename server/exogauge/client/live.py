"""A live stream of a payload's sensor: samples go in, the contact wrench and what is known of the payload come out."""

from __future__ import annotations

import json
import logging
import struct
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, final
from urllib.parse import urlencode, urlsplit, urlunsplit

import numpy as np
from numpy.typing import ArrayLike

from exogauge.client.problems import ClientProblem

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

ATTEMPTS = 6  # in 15 s: as long as the service may take a broken line for one that holds
FIRST_PAUSE_S = 0.5
KEPT, AGAIN = 2000, 500  # samples that are sent again if the service lost them, so many at once
LARGEST = 1 << 22  # bytes of an answer

_LINE = logging.getLogger("exogauge.client.line")
_LINE.setLevel(logging.CRITICAL)  # a broken line is taken up again, or told; a ping that met it first is no error


@final
class LiveStream:
    """One writer. A broken line, or a process that died, is taken up again where the service left off.

    >>> with client.live(payload) as stream:                       # doctest: +SKIP
    ...     for row in rows:                                       # time, pose, wrench, as `stream.columns` says
    ...         stream.send([row])
    ...         for message in stream.received():
    ...             if message["type"] == "wrench" and any(message["alarm"]): ...
    ...     ended = stream.end()
    """

    def __init__(
        self, url: str, payload_id: str, rate_hz: float = 250.0, *, timeout_s: float = 30.0, token: str | None = None
    ) -> None:
        """url, token: of the service, as for `Client`."""
        self._headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        self._url, self._payload, self._rate, self._timeout = url, payload_id, rate_hz, timeout_s
        self.stream: str | None = None
        self.columns: Sequence[str] = ()
        self.delay_s = 0.0
        self._next = 0
        self._kept = deque[tuple[int, np.ndarray[Any, np.dtype[np.float64]]]](maxlen=KEPT)
        self._waiting = deque[dict[str, Any]]()
        self._line: ClientConnection | None = None
        self._ended = False
        self._connect()

    def send(self, rows: ArrayLike) -> None:
        """rows: (n, columns) samples that follow those sent before, numbered on."""
        values = np.ascontiguousarray(np.atleast_2d(rows), dtype="<f8")
        first, self._next = self._next, self._next + len(values)
        self._kept.extend((first + k, row) for k, row in enumerate(values))
        self._send(first, values)

    def received(self, timeout_s: float = 0.0) -> Iterator[dict[str, Any]]:
        """What has come; waits for the first of it up to `timeout_s`. Errors of single samples are among it."""
        while self._waiting:
            yield self._waiting.popleft()
        while not self._ended and (message := self._receive(timeout_s)) is not None:
            yield message
            timeout_s = 0.0

    def zero(self) -> None:
        """Take a secondary zero from the next half second, in which nothing may touch the payload."""
        self._say({"type": "zero"})

    def end(self) -> dict[str, Any]:
        """End the stream; what it ended with. What came before that is still `received`."""
        self._say({"type": "end"})
        until = time.monotonic() + self._timeout
        while time.monotonic() < until:
            message = self._receive(until - time.monotonic())
            if message is not None and message["type"] == "ended":
                self._ended = True  # the line may be gone already
                return message
            if message is not None:
                self._waiting.append(message)
        raise ClientProblem(0, "the stream does not end", f"nothing was said for {self._timeout:g} s")

    def close(self) -> None:
        """Leave without ending: the stream waits, and can be taken up by its id."""
        if self._line is not None:
            self._line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _connect(self) -> None:
        """And send again what the service has not taken."""
        from websockets.exceptions import InvalidStatus
        from websockets.sync.client import connect

        parts = urlsplit(self._url)
        asked = {"rate_hz": self._rate} | ({} if self.stream is None else {"stream": self.stream})
        path = f"{parts.path.rstrip('/')}/api/v1/live/payload/{self._payload}"
        scheme = "wss" if parts.scheme == "https" else "ws"
        address = urlunsplit((scheme, parts.netloc, path, urlencode(asked), ""))
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                self._line = connect(
                    address, open_timeout=self._timeout, max_size=LARGEST, compression=None, max_queue=None,
                    additional_headers=self._headers, logger=_LINE,
                )  # fmt: skip
                break
            except InvalidStatus as error:
                if attempt == ATTEMPTS or not (error.response.status_code == 503 or self._still_held(error)):
                    raise _refused(error.response.status_code, error.response.body) from error
            except OSError as error:
                if attempt == ATTEMPTS:
                    raise ClientProblem(0, f"no answer from {self._url}", str(error)) from error
            time.sleep(pause)
            pause *= 2
        self._welcomed()

    def _still_held(self, error: Any) -> bool:
        """Of a line that broke, the service may not know yet."""
        return self.stream is not None and error.response.status_code == 409

    def _welcomed(self) -> None:
        assert self._line is not None
        until = time.monotonic() + self._timeout
        while True:
            try:
                message = json.loads(self._line.recv(max(until - time.monotonic(), 0.0)))
            except TimeoutError as error:
                raise ClientProblem(0, "the stream does not begin", f"after {self._timeout:g} s") from error
            if message["type"] == "stream":
                self.stream = message["stream"]
            elif message["type"] == "welcome":
                break
            elif message["type"] == "error" and not self.columns:
                raise ClientProblem(0, "the stream is refused", message["detail"], [message])
            else:
                self._waiting.append(message)
        self.columns, self.delay_s = message["columns"], message["delay_s"]
        lost = [each for each in self._kept if each[0] >= message["next"]]
        for k in range(0, len(lost), AGAIN):
            self._send(lost[k][0], np.array([row for _, row in lost[k : k + AGAIN]]))

    def _send(self, first: int, values: np.ndarray[Any, np.dtype[np.float64]]) -> None:
        from websockets.exceptions import ConnectionClosed

        assert self._line is not None
        try:
            self._line.send(struct.pack("<Q", first) + values.tobytes())
        except ConnectionClosed as error:
            self._again(error)

    def _say(self, message: dict[str, Any]) -> None:
        from websockets.exceptions import ConnectionClosed

        assert self._line is not None
        try:
            self._line.send(json.dumps(message))
        except ConnectionClosed as error:
            self._again(error)
            self._line.send(json.dumps(message))

    def _receive(self, timeout_s: float) -> dict[str, Any] | None:
        from websockets.exceptions import ConnectionClosed

        assert self._line is not None
        try:
            message: dict[str, Any] = json.loads(self._line.recv(timeout_s))
            return message
        except TimeoutError:
            return None
        except ConnectionClosed as error:
            self._again(error)
            return None

    def _again(self, error: Any) -> None:
        """Take the stream up again; not where the service ended it, or refused what was sent."""
        from websockets.exceptions import ConnectionClosed

        assert self._line is not None
        with suppress(ConnectionClosed, TimeoutError):
            while True:  # what was said before
                self._waiting.append(json.loads(self._line.recv(0.0)))
        code = None if error.rcvd is None else error.rcvd.code
        if code in (1000, 1008, 1009):
            last = next((each for each in reversed(self._waiting) if each["type"] == "error"), None)
            raise ClientProblem(0, "the stream was closed", "" if last is None else last["detail"]) from error
        self._connect()


def _refused(status: int, body: bytes | bytearray) -> ClientProblem:
    try:
        told = json.loads(body)
        return ClientProblem(status, told["title"], told.get("detail") or "", told.get("errors"))
    except (ValueError, KeyError, TypeError):
        return ClientProblem(status, "the stream is refused", body[:500].decode(errors="replace"))
