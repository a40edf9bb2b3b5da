"""The `jobs` table: what users see of a job. Every transition is one guarded UPDATE.

    queued ──claim──> running ──finish──> succeeded | failed | cancelled
       │                 └──release (its worker leaves)──> queued
       └──request_cancel──> cancelled

A guard that does not hold changes nothing and the function says so. Whoever lost a race has lost it once, in the
database, and not in the memories of two processes. An ended job never changes; trying again makes a new one.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any, Literal

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from exogauge.storage.database import database_now
from exogauge.storage.tables import LIVE_STATES, Job, WorkerLease, one_of

ENDED = ("succeeded", "failed", "cancelled")
MAX_ATTEMPTS = 4
LOG_LIMIT = 20_000  # characters of log kept per job: the last ones

QUIET = {"synchronize_session": False}
Ending = Literal["succeeded", "failed", "cancelled"]


def request_hash(study_hash: str, kind: str, settings: Mapping[str, Any], code_version: str) -> str:
    """Equal requests have equal hashes: same files, kind, settings and code."""
    request = [study_hash, kind, settings, code_version]
    return hashlib.sha256(json.dumps(request, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def add(session: Session, job: Job) -> bool:
    """Insert a queued job, unless an equal one is queued, running or succeeded: then nothing happens (False)."""
    insert = sqlite.insert if session.get_bind().dialect.name == "sqlite" else postgresql.insert
    values = {
        "id": job.id, "lab_id": job.lab_id, "created_at": job.created_at, "kind": job.kind, "study_id": job.study_id,
        "request_hash": job.request_hash, "settings": job.settings, "code_version": job.code_version,
    }  # fmt: skip
    row = insert(Job).values(values)
    unless = row.on_conflict_do_nothing(
        index_elements=["lab_id", "request_hash"], index_where=sa.text(one_of("state", LIVE_STATES))
    )
    return session.scalar(unless.returning(Job.id)) is not None


def equal_live(session: Session, lab_id: str, request: str) -> Job | None:
    """The queued, running or succeeded job of this request."""
    found = sa.select(Job).where(Job.lab_id == lab_id, Job.request_hash == request, Job.state.in_(LIVE_STATES))
    return session.scalars(found).one_or_none()


def held_by_nobody() -> sa.ColumnElement[bool]:
    """The job's worker holds no lease: it died, or left."""
    return Job.worker.is_(None) | Job.worker.not_in(sa.select(WorkerLease.worker_id))


def claim(session: Session, job_id: str, worker: str) -> Job | None:
    """Take a job that is queued, or that a dead worker (or this one, before) has left running."""
    free = (Job.state == "queued") | ((Job.state == "running") & (held_by_nobody() | (Job.worker == worker)))
    now = database_now(session)
    update = (
        sa.update(Job)
        .where(Job.id == job_id, free, sa.exists().where(WorkerLease.worker_id == worker))
        .values(
            state="running",
            worker=worker,
            attempts=Job.attempts + 1,
            progress=0.0,
            message="",
            started_at=sa.func.coalesce(Job.started_at, now),
        )
        .returning(Job)
    )
    return session.scalars(update, execution_options=QUIET).one_or_none()


def mine(job_id: str, worker: str) -> sa.ColumnElement[bool]:
    """The job is running here, and this worker has not been declared dead."""
    return sa.and_(
        Job.id == job_id,
        Job.state == "running",
        Job.worker == worker,
        sa.exists().where(WorkerLease.worker_id == worker),
    )


def report(session: Session, job_id: str, worker: str, progress: float, message: str) -> bool:
    """Write progress; False when the job is no longer this worker's."""
    update = sa.update(Job).where(mine(job_id, worker)).values(progress=progress, message=message).returning(Job.id)
    return session.scalar(update, execution_options=QUIET) is not None


def cancel_wanted(session: Session, job_id: str, worker: str) -> bool | None:
    """Whether somebody asked to cancel; None when the job is no longer this worker's."""
    return session.scalar(sa.select(Job.cancel_requested).where(mine(job_id, worker)))


def finish(session: Session, job_id: str, worker: str, state: Ending, reason: str | None = None, log: str = "") -> bool:
    """End a job that runs here; False (and nothing written) when it is no longer this worker's."""
    values: dict[str, Any] = {"state": state, "reason": reason, "finished_at": database_now(session)}
    if state == "succeeded":
        values |= {"progress": 1.0, "message": ""}
    values["log"] = appended(session, log)
    update = sa.update(Job).where(mine(job_id, worker)).values(values).returning(Job.id)
    return session.scalar(update, execution_options=QUIET) is not None


def note(session: Session, job_id: str, worker: str, log: str) -> None:
    """Append to the job's log."""
    update = sa.update(Job).where(mine(job_id, worker)).values(log=appended(session, log))
    session.execute(update, execution_options=QUIET)


def appended(session: Session, text: str) -> sa.ColumnElement[str]:
    """The log with `text` after it, its oldest characters cut off at LOG_LIMIT."""
    whole = Job.log + text
    sqlite_dialect = session.get_bind().dialect.name == "sqlite"
    return sa.func.substr(whole, -LOG_LIMIT) if sqlite_dialect else sa.func.right(whole, LOG_LIMIT)


def release(session: Session, worker: str) -> None:
    """Put back what runs here: the worker leaves of its own will, so this was no attempt."""
    update = (
        sa.update(Job)
        .where(Job.state == "running", Job.worker == worker)
        .values(state="queued", worker=None, attempts=Job.attempts - 1, progress=0.0, message="")
    )
    session.execute(update, execution_options=QUIET)


def request_cancel(session: Session, job_id: str, lab_id: str) -> bool:
    """Cancel a queued job at once; ask the worker of a running one to stop. False when the job has ended."""
    queued = (Job.id == job_id, Job.lab_id == lab_id, Job.state == "queued")
    ended = {"state": "cancelled", "reason": "cancelled before it started", "finished_at": database_now(session)}
    at_once = sa.update(Job).where(*queued).values(cancel_requested=True, **ended).returning(Job.id)
    if session.scalar(at_once, execution_options=QUIET) is not None:
        return True
    running = (Job.id == job_id, Job.lab_id == lab_id, Job.state == "running")
    ask = sa.update(Job).where(*running).values(cancel_requested=True).returning(Job.id)
    return session.scalar(ask, execution_options=QUIET) is not None


def unattended(session: Session) -> list[str]:
    """Jobs that need an entry in the queue: queued ones, and running ones whose worker is gone."""
    needing = (Job.state == "queued") | ((Job.state == "running") & held_by_nobody())
    return list(session.scalars(sa.select(Job.id).where(needing)))


def ahead_in_queue(session: Session, job: Job) -> int:
    """Queued jobs that were submitted before this one."""
    before = (Job.created_at < job.created_at) | ((Job.created_at == job.created_at) & (Job.id < job.id))
    return session.scalar(sa.select(sa.func.count()).select_from(Job).where(Job.state == "queued", before)) or 0


def place_in_words(session: Session, job: Job) -> str:
    """What a waiting user wants to know."""
    if job.state != "queued":
        return ""
    workers = session.scalar(sa.select(sa.func.count()).select_from(WorkerLease)) or 0
    if workers == 0:
        return "waiting for a worker: none is running (start one with `exogauge work`)"
    running = session.scalar(sa.select(sa.func.count()).select_from(Job).where(Job.state == "running")) or 0
    ahead = ahead_in_queue(session, job)
    if ahead == 0:
        return "next to start" if running >= workers else "starting"
    return f"{ahead} {'job' if ahead == 1 else 'jobs'} ahead in the queue, {running} running on {workers} workers"
