"""Deliveries of webhooks, signed as Standard Webhooks has it; a thread of each server, of which one at a time sends."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import logging
import random
import socket
import threading
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from os import getpid
from typing import final

from exogauge import __version__
from exogauge.settings import Settings
from exogauge.storage import chores, webhooks
from exogauge.storage.store import Installation
from exogauge.storage.webhooks import Due
from exogauge.upkeep.public_line import NoAnswer, Refused, post

log = logging.getLogger(__name__)
CHORE = "webhooks"
LOOK_EVERY_S = 2.0  # whether something is to be sent
AT_ONCE = 4  # judgement: addresses asked side by side; one that is slow holds up a quarter
BATCH = 16  # deliveries taken in one transaction, four for each that is asked
GONE = 410  # by which an address says that it wants no more


@final
class Postman:
    """Sends what is due until `stop`."""

    def __init__(self, installation: Installation, settings: Settings) -> None:
        self._installation = installation
        self._private = settings.private_webhooks
        self._holder = f"{socket.gethostname()[:150]}-{getpid()}-{uuid.uuid4().hex[:8]}"
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="postman", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopping.set()
        self._thread.join(timeout=5.0)

    def _keep(self) -> None:
        while not self._stopping.wait(LOOK_EVERY_S):
            try:
                while self.round() and not self._stopping.is_set():
                    pass
            except Exception as error:  # the next look tries again
                if not self._stopping.is_set():
                    log.warning("webhooks: %s", error)

    def round(self) -> int:
        """Send what is due now, at most a batch, if nobody else does; how many were tried."""
        with self._installation.reading() as session:
            if not webhooks.any_due(session):
                return 0
        with self._installation.session() as session:
            if not chores.take(session, CHORE, self._holder, now_due=True):
                return 0
        try:
            with self._installation.session() as session:
                due = webhooks.take_due(session, BATCH)
            with ThreadPoolExecutor(AT_ONCE) as several:
                list(several.map(self._send, due))
            return len(due)
        finally:
            with self._installation.session() as session:
                chores.done(session, CHORE, self._holder, timedelta(0), {"sent": len(due)})

    def _send(self, due: Due) -> None:
        body = json.dumps(
            {"type": due.event, "timestamp": due.created_at.isoformat(), "data": due.data}, allow_nan=False
        ).encode()
        status, said = None, ""
        try:
            status = post(due.url, body, headers_of(due, body, int(time.time())), self._private)
        except (Refused, NoAnswer) as error:
            said = str(error)
        with self._installation.session() as session:
            if status is not None and 200 <= status < 300:
                webhooks.delivered(session, due, status)
            else:
                said = said or f"it answered {status}"
                jitter = random.uniform(0.9, 1.1)  # so that not all come at once to what was away
                webhooks.not_delivered(session, due, status, said, jitter, status == GONE)


def headers_of(due: Due, body: bytes, now: int) -> dict[str, str]:
    """Standard Webhooks 1.0: a try has a time of its own, a delivery one id however often it is tried."""
    return {
        "content-type": "application/json",
        "user-agent": f"exogauge/{__version__}",
        "webhook-id": due.id,
        "webhook-timestamp": str(now),
        "webhook-signature": signature(due.secret, due.id, now, body),
    }


def signature(secret: str, key: str, now: int, body: bytes) -> str:
    signed = b".".join((key.encode(), str(now).encode(), body))
    digest = hmac.new(base64.b64decode(secret.removeprefix("whsec_")), signed, hashlib.sha256).digest()
    return f"v1,{base64.b64encode(digest).decode()}"
