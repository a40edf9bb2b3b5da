"""Results and artifacts: what a job made. They appear together, once, in the transaction that ends the job."""

from __future__ import annotations

import mimetypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from exogauge.errors import Conflict, NotFound
from exogauge.storage import tables
from exogauge.storage.files import PinnedFile
from exogauge.storage.jobs import Jobs, held
from exogauge.storage.records import ArtifactRecord, ResultRecord
from exogauge.storage.rows import Lab, as_record

RESULTS = "results.json"
MEDIA_TYPES = {
    ".parquet": "application/vnd.apache.parquet",
    ".urdf": "application/xml",
    ".yaml": "application/yaml",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
}


@final
@dataclass(frozen=True)
class Results:
    lab: Lab

    def finish(self, job_id: str, worker: str, files: Sequence[PinnedFile]) -> bool:
        """End the job as succeeded with these files (`keep_folder` stored them), results.json among them.

        False, and nothing written, when the worker no longer holds the job: a result appears exactly once.
        """
        jobs = Jobs(self.lab)
        ended = {"state": "succeeded", "progress": 1.0, "finished_at": tables.utc_now()}
        if not jobs._change(ended, *held(job_id, worker)):
            return False
        study_id = jobs.get(job_id).study_id
        main = next((file for file in files if file.path == RESULTS), None)
        if main is None:
            raise Conflict(f"job {job_id} made no {RESULTS}")
        self.lab.session.add(
            tables.Result(lab_id=self.lab.lab_id, job_id=job_id, study_id=study_id, sha256=main.sha256, size=main.size)
        )
        for file in files:
            self.lab.session.add(
                tables.Artifact(
                    lab_id=self.lab.lab_id, job_id=job_id, name=file.path, sha256=file.sha256, size=file.size,
                    media_type=media_type(file.path),
                )
            )  # fmt: skip
        self.lab.session.flush()
        self.lab.audit("finish", "job", job_id, after=main.sha256)
        return True

    def of_job(self, job_id: str) -> ResultRecord:
        Jobs(self.lab).get(job_id)
        found = self.lab.one(ResultRecord, self.lab.select(tables.Result).where(tables.Result.job_id == job_id))
        if found is None:
            raise NotFound(f"job {job_id} has no results")
        return found

    def of_study(self, study_id: str) -> ResultRecord:
        """Of the study's latest job that succeeded."""
        latest = Jobs(self.lab).latest([study_id], state="succeeded").get(study_id)
        if latest is None:
            raise NotFound(f"no job of study {study_id} has succeeded yet")
        return self.of_job(latest.id)

    def artifacts(self, job_id: str) -> tuple[ArtifactRecord, ...]:
        Jobs(self.lab).get(job_id)
        query = self.lab.select(tables.Artifact).where(tables.Artifact.job_id == job_id)
        rows = self.lab.session.scalars(query.order_by(tables.Artifact.name))
        return tuple(as_record(ArtifactRecord, row) for row in rows)

    def artifact(self, job_id: str, name: str) -> ArtifactRecord:
        query = self.lab.select(tables.Artifact).where(tables.Artifact.job_id == job_id, tables.Artifact.name == name)
        found = self.lab.one(ArtifactRecord, query)
        if found is None:
            raise NotFound(f"job {job_id} has no artifact of this name")
        return found


def media_type(name: str) -> str:
    suffix = name[name.rfind(".") :].lower() if "." in name else ""
    return MEDIA_TYPES.get(suffix) or mimetypes.guess_type(name)[0] or "application/octet-stream"
