"""Who looks at a live stream that somebody else writes. What is not taken in time is missed and counted; neither the
writer nor the stream's process ever waits for a watcher."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from typing import final

from fastapi import WebSocket

from exogauge.errors import Fault

WAITING_BYTES = 256 * 1024  # for one watcher: a second of answers at 1 kHz, one by one
SEND_S = 10.0  # for which a watcher may take nothing
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
