"""Results and artifacts: what a job made. A worker writes them in the transaction that ends its job, all or none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import sqlalchemy as sa

from exogauge.errors import NotFound
from exogauge.storage import tables
from exogauge.storage.jobs import Jobs
from exogauge.storage.records import ArtifactRecord, ResultRecord
from exogauge.storage.rows import Lab, as_record

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
