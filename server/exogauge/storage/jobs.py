"""Jobs as the page and the API read them. What changes them is in `exogauge.jobs`: guarded updates, one per step.

Results and artifacts: what a job made. A worker writes them in the transaction that ends its job, all or none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import InstrumentedAttribute

from exogauge.errors import NotFound
from exogauge.storage import tables
from exogauge.storage.records import ArtifactRecord, JobRecord, LatestJobRecord, Page, ResultRecord
from exogauge.storage.rows import Lab, as_record, names_of
from exogauge.storage.tables import Job

ASIDE = ("whatif", "payload_plan")  # kinds that answer a question about a study or a payload and do not evaluate it


@final
@dataclass(frozen=True)
class Jobs:
    lab: Lab

    def get(self, key: str) -> JobRecord:
        return self.lab.get(JobRecord, Job, key, "job")

    def page(
        self,
        after: tuple[datetime, str] | None,
        limit: int,
        *,
        kind: str | None = None,
        state: str | None = None,
        **owner: str | None,
    ) -> Page[JobRecord]:
        """owner: `study_id` or another of `tables.OWNERS`, where given."""
        query = self.lab.select(Job)
        for column, key in owner.items():
            if key is not None:
                query = query.where(getattr(Job, column) == key)
        if kind is not None:
            query = query.where(Job.kind == kind)
        if state is not None:
            query = query.where(Job.state == state)
        return self.lab.page(JobRecord, Job, query, after, limit)

    def latest(self, noun: str, keys: Sequence[str]) -> dict[str, LatestJobRecord]:
        """id of one of `tables.OWNERS` -> its newest job that says where it stands."""
        owner = getattr(Job, f"{noun}_id")
        rank = sa.func.row_number().over(partition_by=owner, order_by=(Job.created_at.desc(), Job.id.desc()))
        columns = [getattr(Job, name) for name in names_of(LatestJobRecord)]
        query = sa.select(owner.label("owner"), *columns, rank.label("rank"))
        ranked = query.where(Job.lab_id == self.lab.lab_id, owner.in_(keys), Job.kind.not_in(ASIDE)).subquery()
        newest = self.lab.session.execute(sa.select(ranked).where(ranked.c.rank == 1))
        return {row[0]: LatestJobRecord(*row[1:-1]) for row in newest}


def latest_state(key: InstrumentedAttribute[str], owner: Any = Job.study_id) -> sa.ScalarSelect[str]:
    """The state of the newest job of a row, by default a study, as part of a larger query."""
    mine = sa.select(Job.state).where(owner == key, Job.kind.not_in(ASIDE))
    return mine.order_by(Job.created_at.desc(), Job.id.desc()).limit(1).scalar_subquery()


RESULTS = "results.json"


@final
@dataclass(frozen=True)
class Results:
    lab: Lab

    def of_job(self, job_id: str) -> ResultRecord:
        state = Jobs(self.lab).get(job_id).state
        found = self.lab.one(ResultRecord, self.lab.select(tables.Result).where(tables.Result.job_id == job_id))
        if found is None:
            raise NotFound(f"job {job_id} has no results: it is {state}")
        return found

    def of_study(self, study_id: str) -> ResultRecord:
        """results.json of the study's latest job that made one."""
        return self._latest(tables.Result.study_id == study_id, f"study {study_id}")

    def newest(self, noun: str, key: str) -> ResultRecord:
        """The result, whatever its file, of the newest job that succeeded of one of `tables.OWNERS`."""
        theirs = getattr(tables.Job, f"{noun}_id") == key
        query = self.lab.select(tables.Result).join(tables.Job, tables.Job.id == tables.Result.job_id)
        query = query.where(theirs, tables.Job.state == "succeeded")
        found = self.lab.one(ResultRecord, query.order_by(tables.Job.created_at.desc(), tables.Job.id.desc()))
        if found is None:
            raise NotFound(f"no job of {noun} {key} has succeeded yet")
        return found

    def of_payload(self, payload_id: str) -> ResultRecord:
        """results.json of the payload's latest job that made one; no plan."""
        return self._latest(tables.Result.payload_id == payload_id, f"payload {payload_id}")

    def _latest(self, theirs: sa.ColumnElement[bool], whose: str) -> ResultRecord:
        result, job, artifact = tables.Result, tables.Job, tables.Artifact
        evaluated = sa.select(artifact.job_id).where(artifact.name == RESULTS)
        query = self.lab.select(result).join(job, job.id == result.job_id)
        query = query.where(theirs, job.state == "succeeded", job.id.in_(evaluated))
        latest = self.lab.one(ResultRecord, query.order_by(job.created_at.desc(), job.id.desc()))
        if latest is None:
            raise NotFound(f"no job of {whose} has succeeded yet")
        return latest

    def artifacts(self, job_id: str) -> tuple[ArtifactRecord, ...]:
        """Sorted by name."""
        Jobs(self.lab).get(job_id)
        query = self.lab.select(tables.Artifact).where(tables.Artifact.job_id == job_id)
        rows = self.lab.session.scalars(query.order_by(tables.Artifact.name))
        return tuple(as_record(ArtifactRecord, row) for row in rows)

    def artifact(self, job_id: str, name: str) -> ArtifactRecord:
        """By its name in the database; no path is ever made of what a caller asks for."""
        query = self.lab.select(tables.Artifact).where(tables.Artifact.job_id == job_id, tables.Artifact.name == name)
        found = self.lab.one(ArtifactRecord, query)
        if found is None:
            raise NotFound(f"job {job_id} has no artifact of this name")
        return found
