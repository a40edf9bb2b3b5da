"""Jobs as the page and the API see them. Every change of state is one guarded UPDATE: what must still hold is in its
WHERE, and its row count says whether it did. A worker that was taken over can therefore change nothing any more."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, cast, final

import sqlalchemy as sa

from exogauge.storage import tables
from exogauge.storage.database import UtcDateTime
from exogauge.storage.records import JobRecord, Page
from exogauge.storage.rows import Lab, as_record
from exogauge.storage.tables import Job

LOG_TAIL = 64 * 1024
OPEN_STATES = ("queued", "running")


def request_hash(study_hash: str, kind: str, settings: Mapping[str, Any], code_version: str) -> str:
    """What makes two requests the same: study content, kind, settings and code version."""
    text = json.dumps([study_hash, kind, settings, code_version], sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


@final
@dataclass(frozen=True)
class Jobs:
    lab: Lab

    def add(
        self, study_id: str, study_hash: str, kind: str, settings: Mapping[str, Any], code_version: str
    ) -> tuple[JobRecord, bool]:
        """The live job of this request, and whether it is new; a failed or cancelled one does not count."""
        asked = request_hash(study_hash, kind, settings, code_version)
        same = self.lab.select(Job).where(Job.request_hash == asked, Job.state.in_(tables.LIVE_STATES))

        def make() -> list[tables.Base]:
            return [
                Job(lab_id=self.lab.lab_id, kind=kind, study_id=study_id, request_hash=asked, settings=dict(settings),
                    code_version=code_version)
            ]  # fmt: skip

        job, new = self.lab.find_or_add(lambda: self.lab.one(JobRecord, same), make, "job")
        if new:
            self.lab.audit("add", "job", job.id, after=asked)
        return job, new

    def get(self, key: str) -> JobRecord:
        return self.lab.get(JobRecord, Job, key, "job")

    def page(
        self, after: tuple[datetime, str] | None, limit: int, *, study_id: str | None = None, state: str | None = None
    ) -> Page[JobRecord]:
        query = self.lab.select(Job)
        if study_id is not None:
            query = query.where(Job.study_id == study_id)
        if state is not None:
            query = query.where(Job.state == state)
        return self.lab.page(JobRecord, Job, query, after, limit)

    def latest(self, study_ids: Sequence[str], state: str | None = None) -> dict[str, JobRecord]:
        """study id -> its newest job (in `state`, where given)."""
        mine = sa.and_(Job.lab_id == self.lab.lab_id, Job.study_id.in_(study_ids))
        rank = sa.func.row_number().over(partition_by=Job.study_id, order_by=(Job.created_at.desc(), Job.id.desc()))
        chosen = mine if state is None else sa.and_(mine, Job.state == state)
        ranked = sa.select(Job.id, rank.label("rank")).where(chosen).subquery()
        newest = sa.select(ranked.c.id).where(ranked.c.rank == 1)
        rows = self.lab.session.scalars(self.lab.select(Job).where(Job.id.in_(newest)))
        return {row.study_id: as_record(JobRecord, row) for row in rows}

    def start(self, key: str, worker: str) -> bool:
        """Take a queued job, or take over a running one whose worker is gone; counts as one attempt."""
        first = sa.func.coalesce(Job.started_at, sa.literal(tables.utc_now(), UtcDateTime()))
        taken = {"state": "running", "worker": worker, "attempts": Job.attempts + 1, "started_at": first}
        return self._change(taken, Job.id == key, Job.state.in_(OPEN_STATES), Job.cancel_requested.is_(False))

    def report(self, key: str, worker: str, progress: float, message: str) -> bool:
        """Say how far the job is; False when the worker no longer holds it."""
        said = {"progress": min(max(progress, 0.0), 1.0), "message": printable(message)}
        return self._change(said, *held(key, worker))

    def append_log(self, key: str, worker: str, text: str) -> bool:
        """Add to the job's log; its last 64 KiB stay."""
        added = printable(text)[-LOG_TAIL:]
        surplus = sa.func.length(Job.log) + len(added) - LOG_TAIL
        tail = sa.func.substr(Job.log, sa.case((surplus > 0, surplus + 1), else_=1)).concat(added)
        return self._change({"log": tail}, *held(key, worker))

    def fail(self, key: str, worker: str | None, reason: str) -> bool:
        """End a job with the reason why. worker None: an open job that nobody holds any more."""
        guard = held(key, worker) if worker is not None else (Job.id == key, Job.state.in_(OPEN_STATES))
        return self._change({"state": "failed", "reason": printable(reason), "finished_at": tables.utc_now()}, *guard)

    def end_cancelled(self, key: str) -> bool:
        """End a running job that was asked to stop."""
        ended = {"state": "cancelled", "finished_at": tables.utc_now()}
        return self._change(ended, Job.id == key, Job.state == "running", Job.cancel_requested.is_(True))

    def request_cancel(self, key: str) -> JobRecord:
        """Ask a job to stop: a queued one ends at once, a running one is asked, an ended one stays as it is."""
        ended = {"state": "cancelled", "cancel_requested": True, "finished_at": tables.utc_now()}
        if not self._change(ended, Job.id == key, Job.state == "queued"):
            self._change({"cancel_requested": True}, Job.id == key, Job.state == "running")
        return self.get(key)

    def change(self, key: str, *, since: Collection[str], worker: str | None = None, **values: Any) -> bool:
        """Set `values` if the job is in one of the states `since` (and held by `worker`, where given)."""
        guard = [Job.id == key, Job.state.in_(since)]
        return self._change(values, *guard, *([] if worker is None else [Job.worker == worker]))

    def _change(self, values: Mapping[str, Any], *guard: sa.ColumnElement[bool]) -> bool:
        statement = sa.update(Job).where(Job.lab_id == self.lab.lab_id, *guard).values(**values)
        done = self.lab.session.execute(statement, execution_options={"synchronize_session": False})
        return cast("sa.CursorResult[Any]", done).rowcount == 1


def held(key: str, worker: str) -> tuple[sa.ColumnElement[bool], ...]:
    return Job.id == key, Job.state == "running", Job.worker == worker


def printable(text: str) -> str:
    """Without what PostgreSQL cannot keep: NUL and lone surrogates."""
    return text.replace("\0", "\ufffd").encode("utf-8", "replace").decode()
