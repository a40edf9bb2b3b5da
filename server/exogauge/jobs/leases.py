"""Who is alive: a worker holds a row of `worker_leases` and renews it; whoever sees a stale row deletes it.

A worker id belongs to one start of one process and is never used again. *The row's existence* is the truth:
a worker whose row was deleted (it was frozen, or cut off) finds that its next beat changes nothing, and leaves
without writing anything more. Times are the database's own, so clocks of machines do not matter.
"""

from __future__ import annotations

import logging
import os
import socket
import threading
import time
import uuid
from collections.abc import Callable
from datetime import timedelta
from typing import final

import sqlalchemy as sa
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from exogauge.storage.database import database_now
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
        with Session(self.engine) as session, session.begin():
            now = database_now(session)
            host = socket.gethostname()
            session.add(WorkerLease(worker_id=self.worker_id, beat_at=now, started_at=now, host=host, pid=os.getpid()))

    def beat(self) -> bool:
        """Renew; False when somebody has declared this worker dead."""
        with Session(self.engine) as session, session.begin():
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
        with Session(self.engine) as session, session.begin():
            session.execute(sa.delete(WorkerLease).where(WorkerLease.worker_id == self.worker_id))
