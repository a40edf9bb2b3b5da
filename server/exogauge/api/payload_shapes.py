"""What the API answers of payloads and their plans."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any, Literal, Self, final

from pydantic import BaseModel

from exogauge.api.jobs import JobOut
from exogauge.api.shapes import Answer, ArtifactOut, FileOut, LatestJob, ListOf, Part
from exogauge.payload.schema import Found
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import ArtifactRecord, JobRecord, PayloadRecord


@final
class PayloadOut(Answer):
    """One version of a payload. summary: sensor, pose, logs, what may be planned. content_hash covers every file; files
    are given when one payload is asked for."""

    id: str
    name: str
    version: int
    created_at: datetime
    content_hash: str
    summary: dict[str, Any]
    latest_job: LatestJob | None = None
    files: list[FileOut] | None = None

    @classmethod
    def of(cls, payload: PayloadRecord, job: JobRecord | None, files: Sequence[PinnedFile] | None = None) -> Self:
        answer = cls.model_validate(payload)
        answer.latest_job = None if job is None else LatestJob.of(job)
        answer.files = None if files is None else [FileOut.model_validate(file) for file in files]
        return answer


@final
class PayloadList(ListOf):
    items: list[PayloadOut]


@final
class PlanRequest(Part):
    """What to plan: postures at rest, or the motion that excites."""

    what: Literal["postures", "excitation"]


@final
class PlanOut(BaseModel):
    """job: that made it; `settings.what` is what is planned. found: what the plan will tell; null until it is made."""

    job: JobOut
    found: Found | None
    files: list[ArtifactOut]

    @classmethod
    def of(cls, job: JobOut, content: bytes, files: Sequence[ArtifactRecord]) -> Self:
        return cls(job=job, found=Found.model_validate_json(content), files=[ArtifactOut.of(file) for file in files])


@final
class PlanList(BaseModel):
    """Newest first."""

    items: list[PlanOut]
