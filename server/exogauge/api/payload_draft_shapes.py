"""What the API is told and answers of a payload that is put together."""

from __future__ import annotations

from typing import Any, Literal, Self, final
from uuid import UUID

from pydantic import BaseModel, Field, model_validator

from exogauge.api.from_uploads import FilePath
from exogauge.api.imports import ColumnOut
from exogauge.api.problems import ProblemError
from exogauge.api.shapes import Part


@final
class PayloadDraft(Part):
    """A payload as it is put together, before it is kept. base_id: a stored one; keep: which of its files are taken
    over. upload_ids, paths: files that were uploaded, and what they are called here. text: payload.yaml."""

    base_id: UUID | None = None
    keep: list[FilePath] = Field(default=[], max_length=200)
    upload_ids: list[UUID] = Field(default=[], max_length=200)
    paths: list[FilePath] = Field(default=[], max_length=200)
    text: str | None = Field(default=None, max_length=100_000)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.paths) != len(self.upload_ids):
            raise ValueError("one path for each upload")
        return self


@final
class UrdfJointOut(BaseModel):
    """lower, upper [rad or m]; velocity; effort [N·m or N]; null where the URDF states none."""

    name: str
    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None


@final
class UrdfOut(BaseModel):
    """frames: links and fixed joints; fixed: those that no joint moves."""

    file: str
    joints: list[UrdfJointOut]
    frames: list[str]
    fixed: list[str]


@final
class LogColumnsOut(BaseModel):
    """Suggestions call a wrench's components ft.sensor.fx …, a joint's angle q.NAME, the time t."""

    file: str
    rows: int
    columns: list[ColumnOut]


@final
class PayloadFindingOut(BaseModel):
    """log: its name, `postures` for all of that role, or `all`. row counts from 1."""

    log: str
    severity: Literal["error", "warning", "note"]
    channel: str
    rule: str
    detail: str
    advice: str
    row: int | None
    value: float | None


@final
class PayloadLookOut(BaseModel):
    """errors: files that cannot be read."""

    robots: list[UrdfOut]
    logs: list[LogColumnsOut]
    errors: list[ProblemError]


@final
class PayloadVerdictOut(BaseModel):
    """errors: why it is no payload yet. summary: what it would be, and null until there are none. findings: of the
    doctor, where it was asked."""

    errors: list[ProblemError]
    summary: dict[str, Any] | None
    findings: list[PayloadFindingOut] | None
