"""Which worker has which job, and how it ended. Every change is one guarded UPDATE.

    queued ──claim──> running ──succeed | fail | end_cancelled──> succeeded | failed | cancelled
       ^                 │  ^
       └─────release─────┘  └── claim again: its worker's lease is gone

A guard that does not hold changes nothing and the function says so. Whoever lost a race has lost it once, in the
database, and not in the memories of two processes. An ended job never changes; trying again makes a new one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, cast

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import ExogaugeError
from exogauge.jobs.code_version import code_version
from exogauge.jobs.recipes import recipe_for
from exogauge.jobs.turns import free
from exogauge.storage.database import database_now
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import JobRecord
from exogauge.storage.rows import Lab, as_record
from exogauge.storage.tables import Artifact, Job, Result, WorkerLease, owner_of
from exogauge.storage.webhooks import Webhooks

MAX_CRASHES = 4  # of what computes a job: the job is to blame
MAX_ATTEMPTS = 8  # whoever is to blame: a kill of the whole service takes its jobs with it
LOG_TAIL = 64 * 1024  # characters of log kept per job: the last ones
MOST_STEPS = 100  # kept of one attempt
MOST_FAULTS = 100  # kept of a failed job
GONE = " is gone (killed, crashed or cut off), and what it had computed\n"
MEDIA_TYPES = {
    ".parquet": "application/vnd.apache.parquet",
    ".urdf": "application/xml",
    ".json": "application/json",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
}


def held_by(job_id: str, worker: str) -> sa.ColumnElement[bool]:
    """The job runs at this worker."""
    return sa.and_(Job.id == job_id, Job.state == "running", Job.worker == worker)


def change(session: Session, guard: sa.ColumnElement[bool], values: Mapping[str, Any]) -> int:
    """Set `values` where `guard` still holds; returns how many jobs it held for."""
    statement = sa.update(Job).where(guard).values(**values)
    done = session.execute(statement, execution_options={"synchronize_session": False})
    return cast("sa.CursorResult[Any]", done).rowcount


def claim(session: Session, job_id: str, worker: str) -> JobRecord | None:
    """Take a job that is queued, or that a dead worker (or this one, before) has left running; one more attempt, by the
    code of this process."""
    mine = (Job.state == "running") & (Job.worker == worker)
    orphaned = (Job.state == "running") & (Job.worker != worker)
    alive = sa.exists().where(WorkerLease.worker_id == worker)
    taken = {
        "state": "running",
        "worker": worker,
        "attempts": Job.attempts + 1,
        "code_version": code_version(),
        "progress": 0.0,
        "message": "",
        "stage": None,
        "steps": None,
        "log": sa.case((orphaned, _kept_with(_of_the_gone(database_now(session)))), else_=Job.log),
        "started_at": sa.func.coalesce(Job.started_at, sa.literal(database_now(session), Job.started_at.type)),
    }
    if not change(session, sa.and_(Job.id == job_id, free() | mine, alive), taken):
        return None
    row = session.scalars(sa.select(Job).where(Job.id == job_id).execution_options(populate_existing=True)).one()
    return as_record(JobRecord, row)


def report(session: Session, job_id: str, worker: str, progress: float, message: str, stage: str | None = None) -> bool:
    """Say how far the job is; False when it is no longer this worker's. Another message begins another step."""
    share, text = min(max(progress, 0.0), 1.0), printable(message)[:1000]
    said: dict[str, Any] = {"progress": share, "message": text, "stage": stage}
    steps = session.scalar(sa.select(Job.steps).where(held_by(job_id, worker))) or []
    if message and len(steps) < MOST_STEPS and (not steps or steps[-1]["message"] != said["message"]):
        said["steps"] = [*steps, {**said, "at": database_now(session).isoformat()}]
    return change(session, held_by(job_id, worker), said) == 1


def crashed(session: Session, job_id: str, worker: str) -> bool:
    """What computed it died, and this worker did not."""
    return change(session, held_by(job_id, worker), {"crashes": Job.crashes + 1}) == 1


def charge(session: Session, job_id: str, worker: str, cpu_s: float) -> bool:
    """Add what this attempt has computed since the last time."""
    return change(session, held_by(job_id, worker), {"cpu_s": Job.cpu_s + cpu_s}) == 1


def append_log(session: Session, job_id: str, worker: str, text: str) -> bool:
    """Add to the job's log; its end stays."""
    added = _kept_with(sa.literal(printable(text)[-LOG_TAIL:]))
    return change(session, held_by(job_id, worker), {"log": added}) == 1


def stamped(at: datetime, text: str) -> str:
    """A line of a job's log."""
    return f"{at.isoformat(timespec='seconds')} {text.rstrip()}\n"


def _kept_with(added: sa.ColumnElement[str]) -> sa.ColumnElement[str]:
    """The job's log with that at its end; the first of what is too much goes."""
    surplus = sa.func.length(Job.log) + sa.func.length(added) - LOG_TAIL
    return sa.func.substr(Job.log, sa.case((surplus > 0, surplus + 1), else_=1)).concat(added)


def _of_the_gone(now: datetime) -> sa.ColumnElement[str]:
    """What nobody was left to say of the attempt before, from the row as it is when the job is taken."""
    number, who = sa.cast(Job.attempts, sa.String), sa.func.coalesce(Job.worker, "?")
    return sa.literal(f"{stamped(now, 'attempt')[:-1]} ") + number + ": its worker " + who + GONE


def cancel_wanted(session: Session, job_id: str, worker: str) -> bool | None:
    """Whether somebody asked to cancel; None when the job is no longer this worker's."""
    return session.scalar(sa.select(Job.cancel_requested).where(held_by(job_id, worker)))


def fail(session: Session, job_id: str, worker: str, reason: str, failure: Mapping[str, Any] | None = None) -> bool:
    """End the job with the reason why; failure: {class, faults, defect} where an error ended it."""
    ended = {"state": "failed", "reason": printable(reason), "finished_at": database_now(session)}
    if failure is not None:
        ended["failure"] = {
            "class": failure["class"],
            "faults": [kept(fault) for fault in failure["faults"][:MOST_FAULTS]],
            "defect": failure.get("defect", False),
        }
    return end(session, job_id, held_by(job_id, worker), ended)


def end_cancelled(session: Session, job_id: str, worker: str) -> bool:
    """End the job because its owner asked."""
    ended = {"state": "cancelled", "reason": "cancelled while it ran", "finished_at": database_now(session)}
    return end(session, job_id, held_by(job_id, worker), ended)


def end(session: Session, job_id: str, guard: sa.ColumnElement[bool], values: Mapping[str, Any]) -> bool:
    """One job, by a change that sets its last state; whoever wants to know is told in the same transaction."""
    if change(session, guard, values) != 1:
        return False
    job = session.scalars(sa.select(Job).where(Job.id == job_id).execution_options(populate_existing=True)).one()
    noun, key = owner_of(job)
    said = {"job_id": job_id, "kind": job.kind, "state": job.state, f"{noun}_id": key}
    Webhooks(Lab(session, job.lab_id)).tell("job.ended", said)
    return True


def succeed(session: Session, job: JobRecord, worker: str, files: Sequence[PinnedFile]) -> bool:
    """End the job with these files, already in the blob store: all rows appear in its lab, once, or none does.

    What other code than the one asked has made stays to be seen, but an equal request is not answered with it.
    """
    wanted = recipe_for(job.kind).result
    main = next((file for file in files if file.path == wanted), None)
    if main is None:
        raise ExogaugeError(f"the computation made no {wanted}")
    ended = {"state": "succeeded", "progress": 1.0, "message": "", "stage": None, "finished_at": database_now(session)}
    if job.code_version != job.requested_code_version:
        ended["request_hash"] = hashlib.sha256(f"{job.request_hash} {job.code_version} {job.id}".encode()).hexdigest()
    if not end(session, job.id, held_by(job.id, worker), ended):
        return False
    ours = {"lab_id": job.lab_id, "job_id": job.id}
    noun, key = owner_of(job)
    session.add(Result(sha256=main.sha256, size=main.size, **{f"{noun}_id": key}, **ours))
    for file in files:
        kind = media_type(file.path)
        session.add(Artifact(name=file.path, sha256=file.sha256, size=file.size, media_type=kind, **ours))
    Lab(session, job.lab_id).audit("succeed", "job", job.id, after=main.sha256)
    return True


def release(session: Session, worker: str) -> int:
    """Put back what runs here: the worker leaves of its own will, so this was no attempt."""
    nothing = {"worker": None, "code_version": None, "progress": 0.0, "message": "", "stage": None, "steps": None}
    back = {"state": "queued", "attempts": Job.attempts - 1, **nothing}
    return change(session, sa.and_(Job.state == "running", Job.worker == worker), back)


def unattended(session: Session) -> list[str]:
    """Jobs that need an entry in the queue: queued ones, and running ones whose worker is gone."""
    return list(session.scalars(sa.select(Job.id).where(free())))


def media_type(name: str) -> str:
    suffix = name[name.rfind(".") :].lower() if "." in name else ""
    return MEDIA_TYPES.get(suffix, "application/octet-stream")


def kept(fault: Mapping[str, Any]) -> dict[str, Any]:
    """A fault as a row can hold it."""
    return {key: printable(value)[:4000] if isinstance(value, str) else value for key, value in fault.items()}


def printable(text: str) -> str:
    """Without what PostgreSQL cannot keep: NUL and lone surrogates."""
    return text.replace("\0", "\ufffd").encode("utf-8", "replace").decode()
