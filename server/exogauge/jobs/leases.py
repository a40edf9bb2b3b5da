"""Who is alive: a worker holds a row of `worker_leases` and renews it; whoever sees a stale row deletes it.

A worker id belongs to one start of one process and is never used again. *The row's existence* is the truth:
a worker whose row was deleted (it was frozen, or cut off) finds that its next beat changes nothing, and leaves
without writing anything more. Times are the database's own, so clocks of machines do not matter.

A job always ends: what a dead worker left behind is given to the living, and nothing queued is forgotten.

Level-triggered: each pass looks at what *is* (leases, jobs, entries) and not at what happened, so a pass that was
missed, interrupted or made twice changes nothing about the outcome.
"""

from __future__ import annotations

import logging
import os
import shutil
import socket
import threading
import time
import uuid
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import final

import sqlalchemy as sa
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from exogauge.jobs.claims import unattended
from exogauge.jobs.engine import JobQueue
from exogauge.storage.database import database_now
from exogauge.storage.scope import AllLabsSession
from exogauge.storage.tables import WorkerLease

log = logging.getLogger(__name__)


def new_worker_id() -> str:
    """A name for this start of this process, for people and for the queue."""
    return f"{socket.gethostname()[:150]}-{os.getpid()}-{uuid.uuid4().hex[:8]}"


def live_workers(session: Session) -> set[str]:
    """Ids of the workers that hold a lease."""
    return set(session.scalars(sa.select(WorkerLease.worker_id)))


def delete_stale(session: Session, ttl_s: float) -> list[str]:
    """Declare dead whoever did not beat for `ttl_s`; returns their ids."""
    oldest = database_now(session) - timedelta(seconds=ttl_s)
    gone = sa.delete(WorkerLease).where(WorkerLease.beat_at < oldest).returning(WorkerLease.worker_id)
    return list(session.scalars(gone, execution_options={"synchronize_session": False}))


@final
class Lease:
    """This worker's proof of life, renewed by a thread of its own."""

    def __init__(self, engine: sa.Engine, worker_id: str, ttl_s: float) -> None:
        self.engine, self.worker_id, self.ttl_s = engine, worker_id, ttl_s
        self._ended = threading.Event()

    def take(self) -> None:
        """Write the row; to be done before the first job is taken."""
        with AllLabsSession(self.engine) as session, session.begin():
            now = database_now(session)
            host = socket.gethostname()
            session.add(WorkerLease(worker_id=self.worker_id, beat_at=now, started_at=now, host=host, pid=os.getpid()))

    def beat(self) -> bool:
        """Renew; False when somebody has declared this worker dead."""
        with AllLabsSession(self.engine) as session, session.begin():
            mine = sa.update(WorkerLease).where(WorkerLease.worker_id == self.worker_id)
            renewed = mine.values(beat_at=database_now(session)).returning(WorkerLease.worker_id)
            return session.scalar(renewed) is not None

    def keep(self, lost: Callable[[], None], reap: Callable[[bool], None]) -> None:
        """Beat every third of the time to live in a thread; call `reap(may_judge)` after good beats, `lost()` if lost.

        may_judge: false at the start and after a time without the database, for one time to live: the others were
        cut off too, and nobody is to be declared dead for that.
        """
        threading.Thread(target=self._keep, args=(lost, reap), name="lease", daemon=True).start()

    def _keep(self, lost: Callable[[], None], reap: Callable[[bool], None]) -> None:
        last_good = time.monotonic()
        judge_from = last_good + self.ttl_s
        while not self._ended.wait(self.ttl_s / 3):
            try:
                if not self.beat():
                    if not self._ended.is_set():  # else it was given back while this beat waited its turn
                        lost()
                    return
                now = time.monotonic()
                if now - last_good > self.ttl_s:
                    judge_from = now + self.ttl_s
                last_good = now
                reap(now >= judge_from)
            except SQLAlchemyError as error:
                log.warning("worker %s: the database did not answer a beat: %s", self.worker_id, error)

    def give_back(self) -> None:
        """Delete the row: this worker leaves on its own."""
        self._ended.set()
        with AllLabsSession(self.engine) as session, session.begin():
            session.execute(sa.delete(WorkerLease).where(WorkerLease.worker_id == self.worker_id))


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
        folders = list(self._scratch.iterdir()) if self._scratch.is_dir() else []
        with AllLabsSession(self._engine) as session, session.begin():
            for worker in delete_stale(session, self._ttl_s) if may_judge else ():
                log.warning("worker %s did not answer for %.0f s; its work goes to another", worker, self._ttl_s)
            waiting, live = unattended(session), live_workers(session)
        for folder in folders:  # whose workers are gone: one takes its lease before it makes its folder
            if folder.name not in live:
                shutil.rmtree(folder, ignore_errors=True)
        if waiting:
            self._give_again(waiting)
        if self._passes % FORGET_EVERY == 0:
            self._queue.forget_before((datetime.now(UTC) - KEEP_ENTRIES).isoformat())
        self._passes += 1

    def _give_again(self, waiting: Sequence[str]) -> None:
        """Entries of dead workers are dropped; there are as many waiting entries as jobs that wait.

        Leases are read after the entries: a worker takes its lease before its first entry, so none is misjudged.
        """
        entries = self._queue.entries()
        with AllLabsSession(self._engine) as session, session.begin():
            live = live_workers(session)
        stranded = [entry for entry in entries if entry.taken_by is not None and entry.taken_by not in live]
        self._queue.drop(stranded)
        usable = [entry.job for entry in entries if entry.taken_by is None]
        without = [job for job in waiting if job not in usable]
        for job in without[: max(len(waiting) - len(usable), 0)]:
            log.warning("job %s gets a new entry in the queue", job)
            with AllLabsSession(self._engine) as session, session.begin():
                self._queue.enqueue(session, job)
