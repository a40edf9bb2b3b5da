"""A job always ends: what a dead worker left behind is given to the living, and nothing queued is forgotten.

Level-triggered: each pass looks at what *is* (leases, jobs, entries) and not at what happened, so a pass that was
missed, interrupted or made twice changes nothing about the outcome.
"""

from __future__ import annotations

import logging
import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.jobs.claims import unattended
from exogauge.jobs.engine import JobQueue
from exogauge.jobs.leases import delete_stale, live_workers

log = logging.getLogger(__name__)

KEEP_ENTRIES = timedelta(days=7)
FORGET_EVERY = 1000  # passes


@final
class Reaper:
    """scratch: the folder that holds one folder per worker."""

    def __init__(self, engine: sa.Engine, queue: JobQueue, ttl_s: float, scratch: Path) -> None:
        self._engine, self._queue, self._ttl_s, self._scratch = engine, queue, ttl_s, scratch
        self._passes = 0

    def reap(self, may_judge: bool = True) -> None:
        """One pass. Safe to run in many workers at once: a second entry for a job does no harm.

        may_judge: whether silent workers may be declared dead in this pass.
        """
        if may_judge:
            self._judge()
        self._give_again()
        self._sweep()
        if self._passes % FORGET_EVERY == 0:
            self._queue.forget_before((datetime.now(UTC) - KEEP_ENTRIES).isoformat())
        self._passes += 1

    def _judge(self) -> None:
        with Session(self._engine) as session, session.begin():
            for worker in delete_stale(session, self._ttl_s):
                log.warning("worker %s did not answer for %.0f s; its work goes to another", worker, self._ttl_s)

    def _give_again(self) -> None:
        """Entries of dead workers are dropped; jobs without an entry get one.

        Leases are read after the entries: a worker takes its lease before its first entry, so none is misjudged.
        """
        with Session(self._engine) as session, session.begin():
            waiting = unattended(session)
        if not waiting:
            return
        entries = self._queue.entries()
        live = self._live()
        stranded = [entry for entry in entries if entry.taken_by is not None and entry.taken_by not in live]
        self._queue.drop(stranded)
        usable = {entry.job for entry in entries if entry not in stranded}
        for job in waiting:
            if job not in usable:
                log.warning("job %s gets a new place in the queue", job)
                with Session(self._engine) as session, session.begin():
                    self._queue.enqueue(session, job)

    def _live(self) -> set[str]:
        with Session(self._engine) as session, session.begin():
            return live_workers(session)

    def _sweep(self) -> None:
        """Remove the folders of workers that are gone."""
        if self._scratch.is_dir() and (folders := list(self._scratch.iterdir())):
            live = self._live()
            for folder in folders:
                if folder.name not in live:
                    shutil.rmtree(folder, ignore_errors=True)
