"""The housekeeping of a server: each machine's own files by each, the installation's by one at a time."""

from __future__ import annotations

import logging
import socket
import threading
import time
import uuid
from dataclasses import asdict
from datetime import timedelta
from functools import partial
from os import getpid
from typing import Any, final

from exogauge.errors import ExogaugeError
from exogauge.settings import Settings
from exogauge.storage import chores
from exogauge.storage.checking import check
from exogauge.storage.closing import remove_due
from exogauge.storage.retention import Ages, no_labs, retire
from exogauge.storage.store import Installation
from exogauge.storage.sweeping import sweep_installation, sweep_machine

log = logging.getLogger(__name__)
EVERY = timedelta(hours=1)
AGAIN = timedelta(minutes=5)  # after one that failed
FIRST_S = 15.0  # after the start: requests come first
LOOK_EVERY_S = 60.0  # whether a chore is due
SCRUBBED = 2  # of 256 parts of the blobs are read and hashed in an hour: all of them in five days
SWEEP, CHECK, CLOSED, AGED = "sweep", "check", "closed labs", "what is old"


class LostTheChore(ExogaugeError):
    """Another process does it by now."""


@final
class Housekeeping:
    """A thread that sweeps and checks until `stop`."""

    def __init__(self, installation: Installation, settings: Settings) -> None:
        self._installation, self._settings = installation, settings
        self._holder = f"{socket.gethostname()[:150]}-{getpid()}-{uuid.uuid4().hex[:8]}"
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="housekeeping", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopping.set()
        self._thread.join(timeout=5.0)

    def _keep(self) -> None:
        self._stopping.wait(FIRST_S)
        machine_due = time.monotonic()
        while not self._stopping.is_set():
            if time.monotonic() >= machine_due:
                machine_due = time.monotonic() + (EVERY if self._tried(self._sweep_here) else AGAIN).total_seconds()
            chores_of_all = (
                (CLOSED, self._remove_closed),
                (AGED, self._retire),
                (SWEEP, self._sweep),
                (CHECK, self._check),
            )
            for name, work in chores_of_all:
                self._tried(partial(self._chore, name, work))
            self._stopping.wait(LOOK_EVERY_S)

    def _tried(self, work: Any) -> bool:
        try:
            work()
        except Exception as error:  # the next look tries again; a server serves without a swept floor
            if not self._stopping.is_set():
                log.warning("housekeeping: %s", error, exc_info=not isinstance(error, ExogaugeError))
            return False
        return True

    def _sweep_here(self) -> None:
        swept = sweep_machine(self._installation, self._settings)
        log.info("swept this machine: %s", asdict(swept))

    def _chore(self, name: str, work: Any) -> None:
        with self._installation.session() as session:
            if not chores.take(session, name, self._holder):
                return
        outcome: dict[str, Any] | None = None
        try:
            outcome = work()
            log.info("%s: %s", name, outcome)
        finally:
            with self._installation.session() as session:
                chores.done(session, name, self._holder, AGAIN if outcome is None else EVERY, outcome)

    def _still(self, name: str) -> None:
        with self._installation.session() as session:
            mine = chores.hold_on(session, name, self._holder)
        if not mine or self._stopping.is_set():
            raise LostTheChore(name)

    def _sweep(self) -> dict[str, Any]:
        return asdict(sweep_installation(self._installation, still=partial(self._still, SWEEP)))

    def _retire(self) -> dict[str, Any]:
        with self._installation.reading() as session:
            unknown = no_labs(session, self._settings.studies_kept_days, self._settings.lab)
        if unknown:
            log.warning("EXOGAUGE_STUDIES_KEPT_DAYS names labs that are not there: %s", ", ".join(unknown))
        return retire(self._installation, Ages.of(self._settings), partial(self._still, AGED)).as_json()

    def _remove_closed(self) -> dict[str, Any]:
        kept = timedelta(days=self._settings.lab_kept_days)
        return remove_due(self._installation, kept, partial(self._still, CLOSED))

    def _check(self) -> dict[str, Any]:
        """A part of the blobs, another every hour."""
        hour = int(time.time() // EVERY.total_seconds())
        parts = [f"{(hour * SCRUBBED + k) % 256:02x}" for k in range(SCRUBBED)]
        found = check(self._installation, self._settings, parts, lambda _done, _of: self._still(CHECK))
        if not found.sound:
            log.error("the store is not sound: %s", found.as_json())
        return found.as_json()
