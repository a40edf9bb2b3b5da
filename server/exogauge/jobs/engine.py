"""The queue: DBOS Transact, kept behind the four names the rest of the program needs.

A job is one row of ours (`jobs`, what users see) and one *entry* in the queue (a DBOS workflow whose id begins with
the job's id). Both are written in one transaction. The row alone decides what is true: an entry only says "there is one
more job to look for", and whoever takes it takes the job whose turn it is (`jobs.turns`). A second entry for the same
job does no harm and a lost one is written again by the reaper.
"""

from __future__ import annotations

import logging
import threading
import uuid
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast, final

import dbos._dbos
import dbos._sys_db
import sqlalchemy as sa
from dbos import DBOS, DBOSClient
from sqlalchemy.orm import Session

from exogauge.jobs.bell import Bell, Patience, ring_when_committed
from exogauge.storage.database import make_engine, seeing_cuts
from exogauge.storage.row_security import grant_schema

APPLICATION = "exogauge"
QUEUE = "jobs"
SCHEMA = "dbos"  # on PostgreSQL
WORKFLOW = "run_job"
VERSION = "jobs-1"  # set by hand: DBOS would hash the code and strand every queued job after an edit
POLL_S = 1.0  # judgement: while the bell has just rung (`bell`)
UNUSED_S = 600.0  # judgement, as seldom as does no harm: how often DBOS looks for what nobody here asks it for
# DBOS would hold up to 20 connections of a database that gives 100, and one more to hear of messages that nobody sends.
# None of its transactions needs another one beside it, so that its threads can share one. judgement: they wait for it
# longer than a line that was cut keeps all of them, as DBOS tries again what a database refused, but not that wait
POOL = {"pool_size": 1, "max_overflow": 0, "pool_timeout": 600.0}
WAITING = ["ENQUEUED", "DELAYED"]
TAKEN = "PENDING"


def engine_url(database_url: str) -> str:
    """The database address as DBOS wants it: no driver in the name. Its connections see a cut as ours do."""
    url = sa.make_url(database_url)
    if url.get_backend_name() == "postgresql":
        url = url.set(query={**seeing_cuts(), **url.query})
    return url.set(drivername=url.get_backend_name()).render_as_string(hide_password=False)


def migrate_engine(database_url: str) -> None:
    """Create or upgrade the queue's own tables (schema `dbos` on PostgreSQL, `dbos_…`-managed tables on SQLite)."""
    logging.getLogger("dbos").setLevel(logging.ERROR)
    DBOS.migrate(engine_url(database_url))
    if database_url.startswith("sqlite"):
        return
    owner = make_engine(database_url, migrating=True)
    with owner.begin() as connection:
        grant_schema(connection, SCHEMA)
    owner.dispose()


@dataclass(frozen=True)
class Entry:
    """taken_by: the worker that took it; None while it waits."""

    id: str
    taken_by: str | None

    @property
    def job(self) -> str:
        """The job it was written for."""
        return self.id.partition(".")[0]


@final
class JobQueue:
    """Entries of the queue, seen from outside a worker."""

    def __init__(self, engine: sa.Engine) -> None:
        self._client = DBOSClient(
            system_database_engine=engine, application_name=APPLICATION, lazy=True, retry_connection_errors=False
        )

    def enqueue(self, connection: sa.Connection | Session, job_id: str) -> str:
        """Write an entry for the job in the caller's transaction; returns its id."""
        entry = f"{job_id}.{uuid.uuid4().hex[:8]}"
        options = {"workflow_name": WORKFLOW, "queue_name": QUEUE, "workflow_id": entry, "app_version": VERSION}
        self._client.enqueue_in_transaction(connection, options, job_id)
        ring_when_committed(connection)
        return entry

    def entries(self) -> list[Entry]:
        """All entries that are waiting or taken."""
        found = self._client.list_workflows(
            status=[*WAITING, TAKEN], name=WORKFLOW, load_input=False, load_output=False
        )
        return [Entry(e.workflow_id, e.executor_id if e.status == TAKEN else None) for e in found]

    def drop(self, entries: Sequence[Entry]) -> None:
        """Cancel entries; a worker that was only frozen finds its entry refused."""
        if entries:
            self._client.cancel_workflows([entry.id for entry in entries])

    def forget_before(self, timestamp: str, limit: int = 1000) -> None:
        """Delete ended entries created before an ISO time; what users see of a job is not in them."""
        ended = self._client.list_workflows(
            status=["SUCCESS", "ERROR", "CANCELLED"],
            name=WORKFLOW,
            end_time=timestamp,
            limit=limit,
            load_input=False,
            load_output=False,
        )
        if ended:
            self._client.delete_workflows([entry.workflow_id for entry in ended])

    def close(self) -> None:
        self._client.destroy()


def take_jobs(database_url: str, worker_id: str, run: Callable[[], None], bell: Bell) -> None:
    """Begin to take entries and call `run()` for each, one at a time, in a thread of the engine. It looks for them when
    the bell rings. What DBOS does beside that again and again is for what is not used here (notifications, delays,
    deadlines, schedules): it was most of what an idle worker cost."""

    def run_job(_job_id: str) -> None:
        try:
            run()
        finally:
            bell.ring()  # there may be more

    queue, database = dbos._dbos, dbos._sys_db.SystemDatabase
    look, sweep, hear = queue.queue_thread, queue.background_jobs_thread, database.run_notification_listener
    schedule = queue.dynamic_scheduler_loop
    queue.queue_thread = lambda stop, of: look(cast(threading.Event, Patience(stop, bell)), of)
    queue.background_jobs_thread = lambda _stop, _of: None
    queue.dynamic_scheduler_loop = lambda _stop, _every_s: None
    database.run_notification_listener = lambda _self: None

    DBOS(
        config={
            "name": APPLICATION,
            "system_database_url": engine_url(database_url),
            "executor_id": worker_id,
            "application_version": VERSION,
            "log_level": "ERROR",
            "max_executor_threads": 4,
            "db_engine_kwargs": POOL,
            "notification_coalesce_sec": UNUSED_S,
            "run_migrations": False,
        }
    )
    DBOS.workflow(name=WORKFLOW, max_recovery_attempts=1000)(run_job)  # `attempts` of the job row is the guard
    DBOS.listen_queues([QUEUE])
    DBOS.launch()
    queue.queue_thread, queue.background_jobs_thread = look, sweep
    queue.dynamic_scheduler_loop = schedule
    database.run_notification_listener = hear
    DBOS.register_queue(QUEUE, worker_concurrency=1, polling_interval_sec=POLL_S, on_conflict="always_update")
