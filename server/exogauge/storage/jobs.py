"""Jobs as the page and the API read them. What changes them is in `exogauge.jobs`: guarded updates, one per step.

Results and artifacts: what a job made. A worker writes them in the transaction that ends its job, all or none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, final

import sqlalchemy as sa

from exogauge.errors import NotFound
from exogauge.storage import tables
from exogauge.storage.records import ArtifactRecord, JobRecord, LatestJobRecord, ListedJobRecord, Page, ResultRecord
from exogauge.storage.rows import KEY, LAB, Lab, columns_in, names_of, of_lab, once
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
    ) -> Page[ListedJobRecord]:
        """owner: `study_id` or another of `tables.OWNERS`, where given."""
        asked = {"kind": kind, "state": state, **owner}
        wanted = (getattr(Job, column) == value for column, value in asked.items() if value is not None)
        return self.lab.page(ListedJobRecord, Job, after, limit, *wanted)

    def latest(self, noun: str, keys: Sequence[str]) -> dict[str, LatestJobRecord]:
        """id of one of `tables.OWNERS` -> its newest job that says where it stands."""
        return {row[0]: LatestJobRecord(*row[1:]) for row in self.lab.rows(latest_of(noun), keys=keys)}


OF: dict[str, Any] = {"study": tables.Study, "payload": tables.Payload, "motion": tables.Motion, "plan": tables.Plan}


@once
def latest_of(noun: str) -> sa.Select[Any]:
    """For `Lab.rows`: of each of the `keys` its newest job, behind the id of what it is of. The lab of jobs is asked
    for as no index knows it: SQLite would take that for the better one, and read all of the lab's."""
    job = columns_in(Job)
    of, names = job[f"{noun}_id"], (f"{noun}_id", *names_of(LatestJobRecord))
    latest_first = sa.func.row_number().over(partition_by=of, order_by=(job.created_at.desc(), job.id.desc()))
    theirs = of.in_(sa.bindparam("keys", expanding=True)), sa.func.coalesce(job.lab_id, "") == LAB
    numbered = sa.select(*(job[name] for name in names), latest_first.label("number"))
    found = numbered.where(*theirs, job.kind.not_in(ASIDE)).subquery().c
    return sa.select(*(found[name] for name in names)).where(found.number == 1)


def latest_state(noun: str) -> sa.ScalarSelect[str]:
    """The state of the newest job of a row of that table, as part of a larger query."""
    job = columns_in(Job)
    mine = sa.select(job.state).where(job[f"{noun}_id"] == columns_in(OF[noun]).id, job.kind.not_in(ASIDE))
    return mine.order_by(job.created_at.desc(), job.id.desc()).limit(1).scalar_subquery()


RESULTS = "results.json"


@once
def artifacts_of() -> sa.Select[Any]:
    """For `Lab.rows`: of the job `key`."""
    artifact = columns_in(tables.Artifact)
    return of_lab(ArtifactRecord, tables.Artifact).where(artifact.job_id == KEY).order_by(artifact.name)


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
        self.lab.must_be(Job, job_id, "job")
        return tuple(ArtifactRecord(*row) for row in self.lab.rows(artifacts_of(), key=job_id))

    def artifact(self, job_id: str, name: str) -> ArtifactRecord:
        """By its name in the database; no path is ever made of what a caller asks for."""
        query = self.lab.select(tables.Artifact).where(tables.Artifact.job_id == job_id, tables.Artifact.name == name)
        found = self.lab.one(ArtifactRecord, query)
        if found is None:
            raise NotFound(f"job {job_id} has no artifact of this name")
        return found
