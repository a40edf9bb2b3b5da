"""What a user asks of jobs: submit, cancel, try again, and where in the queue one is."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.engine import Connection
from sqlalchemy.orm import Session

from exogauge.errors import Conflict
from exogauge.jobs.claims import change, end
from exogauge.jobs.code_version import code_version
from exogauge.jobs.engine import JobQueue
from exogauge.jobs.recipes import recipe_for
from exogauge.jobs.turns import attended, in_turn
from exogauge.storage.database import database_now
from exogauge.storage.quotas import refuse_jobs
from exogauge.storage.records import JobRecord, ListedJobRecord
from exogauge.storage.rows import Lab, once
from exogauge.storage.scope import OF_ALL_LABS
from exogauge.storage.store import Store
from exogauge.storage.tables import LIVE_STATES, Base, Job, WorkerLease, owner_of

log = logging.getLogger(__name__)


def request_hash(content_hash: str, kind: str, settings: Mapping[str, Any], code_version: str) -> str:
    """What makes two requests the same: content of what it is of, kind, settings and code version."""
    text = json.dumps([content_hash, kind, settings, code_version], sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def submit(
    store: Store, queue: JobQueue, owner_id: str, kind: str, settings: Mapping[str, Any]
) -> tuple[JobRecord, bool]:
    """The job of this request, and whether it is new; a failed or cancelled one does not count. BadStudy when the
    summary already says that this kind has nothing to compute. owner_id: of what the kind is of.

    The row and its entry in the queue are written in the transaction of `store`: both or neither.
    """
    recipe = recipe_for(kind)
    wanted = recipe.checked(settings)
    owner = store.owners(recipe.of).get(owner_id)
    recipe.refuse_unsuited(owner.summary)
    asked = request_hash(owner.content_hash, kind, wanted, code_version())
    lab = Lab(store.session, store.lab_id)
    same = lab.select(Job).where(Job.request_hash == asked, Job.state.in_(LIVE_STATES))

    def make() -> list[Base]:
        refuse_jobs(lab, store.quotas)
        common = {"lab_id": store.lab_id, f"{recipe.of}_id": owner_id, "requested_code_version": code_version()}
        return [Job(kind=kind, request_hash=asked, settings=wanted, **common)]

    job, new = lab.find_or_add(lambda: lab.one(JobRecord, same), make, "job")
    if new:
        queue.enqueue(store.session, job.id)
        log.info("job %s asked for", job.id, extra={"facts": {"job": job.id, "kind": kind}})
        lab.audit("submit", "job", job.id, after=asked)
    return job, new


def try_again(store: Store, queue: JobQueue, job_id: str) -> tuple[JobRecord, bool]:
    """A new job with the request of one that failed or was cancelled; that one stays as it is."""
    job = store.jobs.get(job_id)
    if job.state not in ("failed", "cancelled"):
        raise Conflict(f"only a failed or cancelled job can be tried again; this one is {job.state}")
    return submit(store, queue, owner_of(job)[1], job.kind, job.settings)


def cancel(store: Store, job_id: str) -> JobRecord:
    """A queued job ends at once, a running one is asked to stop, an ended one stays as it is."""
    store.jobs.get(job_id)
    this = sa.and_(Job.id == job_id, Job.lab_id == store.lab_id)
    now = database_now(store.session)
    ended = {"state": "cancelled", "reason": "cancelled before it started", "finished_at": now}
    if not end(store.session, job_id, this & (Job.state == "queued"), {"cancel_requested": True, **ended}):
        change(store.session, this & (Job.state == "running"), {"cancel_requested": True})
    Lab(store.session, store.lab_id).audit("cancel", "job", job_id)
    return store.jobs.get(job_id)


@final
@dataclass(frozen=True)
class Place:
    """Where a queued job stands. ahead: how many start before it; words: what its owner wants to know."""

    ahead: int
    words: str


def places(session: Session, jobs: Sequence[ListedJobRecord]) -> dict[str, Place]:
    """Job id -> its place among those of all labs, as workers take them, of those that are queued. Two statements,
    however many they are."""
    return places_of(session, [job.id for job in jobs if job.state == "queued"])


def places_of(within: Session | Connection, wanted: Sequence[str]) -> dict[str, Place]:
    """The same for ids of queued jobs."""
    if not wanted:
        return {}
    ahead = within.execute(ahead_of(), {"keys": wanted}, execution_options=OF_ALL_LABS).all()
    workers, running = within.execute(at_work(), execution_options=OF_ALL_LABS).one()
    return {key: Place(count, in_words(count, running, workers)) for key, count in ahead}


@once
def ahead_of() -> sa.Select[Any]:
    """Of those of the jobs `keys` that wait."""
    queue = in_turn()
    return sa.select(queue.c.id, queue.c.ahead).where(queue.c.id.in_(sa.bindparam("keys", expanding=True)))


@once
def at_work() -> sa.Select[Any]:
    """How many workers there are, and how many jobs run."""
    running = sa.select(sa.func.count()).select_from(Job).where(attended())
    workers = sa.select(sa.func.count()).select_from(WorkerLease)
    return sa.select(workers.scalar_subquery(), running.scalar_subquery())


def in_words(ahead: int, running: int, workers: int) -> str:
    if workers == 0:
        return "waiting for a worker: none is running (`exogauge work` starts one)"
    if ahead == 0:
        return "next to start" if running >= workers else "starting"
    jobs, plural = "job" if ahead == 1 else "jobs", "" if workers == 1 else "s"
    return f"{ahead} {jobs} ahead in the queue, {running} running on {workers} worker{plural}"
