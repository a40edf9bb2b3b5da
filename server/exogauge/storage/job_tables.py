"""What is computed, and what comes of it."""

from __future__ import annotations

from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Mapped, mapped_column

from exogauge.storage.database import FiniteFloat, UtcDateTime
from exogauge.storage.table_kinds import PATH, SHA256, UUID, Base, Owned, one_of, referred, within_lab

ENDED = ("succeeded", "failed", "cancelled")
STATES = ("queued", "running", *ENDED)
LIVE_STATES = ("queued", "running", "succeeded")  # what makes an equal request the same job
OWNERS = ("study", "payload", "motion", "plan")  # what a job can be of
ONE_OWNER = " + ".join(f"(CASE WHEN {noun}_id IS NULL THEN 0 ELSE 1 END)" for noun in OWNERS) + " = 1"


def owner_of(row: Any) -> tuple[str, str]:
    """What a job or a result is of: one of `OWNERS`, and its id."""
    named = ((noun, getattr(row, f"{noun}_id")) for noun in OWNERS)
    return next((noun, key) for noun, key in named if key is not None)


@final
class Job(Owned, Base):
    """What the page and the API read about a job of one of `OWNERS`; the engine keeps its own tables.

    Change it only with guarded updates (`store.jobs.move`). revision grows with every update: an event id.
    request_hash is unique among the jobs that are not failed or cancelled, so that an equal request runs once.
    requested_code_version: of the server that took the request; code_version: of the worker that took the job, None
    while none has.
    failure: {class, faults, defect} of the error that ended it; defect: not what was handed in is to blame.
    stage: what an evaluation is at (`exogauge.progress.Stage`).
    crashes: attempts in which what computed it died and its worker lived to tell.
    cpu_s: what all its attempts have computed, in CPU seconds, as far as a worker lived to tell.
    steps: what the present attempt has done, {message, progress, stage, at}, in order.
    """

    __tablename__ = "jobs"
    __table_args__ = (
        within_lab("study_id", "studies"),
        within_lab("payload_id", "payloads"),
        within_lab("motion_id", "motions"),
        within_lab("plan_id", "plans"),
        referred(),
        sa.CheckConstraint(one_of("state", STATES), name="state"),
        sa.CheckConstraint("progress >= 0 AND progress <= 1", name="progress"),
        sa.CheckConstraint(ONE_OWNER, name="one_owner"),
        sa.Index(
            "uq_jobs_live_request_hash",
            "lab_id",
            "request_hash",
            unique=True,
            sqlite_where=sa.text(one_of("state", LIVE_STATES)),
            postgresql_where=sa.text(one_of("state", LIVE_STATES)),
        ),
        sa.Index(None, "lab_id", "created_at", "id"),
        sa.Index(None, "lab_id", "started_at"),
        sa.Index(None, "state"),
    )
    kind: Mapped[str] = mapped_column(sa.String(64))
    study_id: Mapped[str | None] = mapped_column(UUID, index=True)
    payload_id: Mapped[str | None] = mapped_column(UUID, index=True)
    motion_id: Mapped[str | None] = mapped_column(UUID, index=True)
    plan_id: Mapped[str | None] = mapped_column(UUID, index=True)
    request_hash: Mapped[str] = mapped_column(SHA256)
    settings: Mapped[dict[str, Any]] = mapped_column(sa.JSON, default=dict)
    requested_code_version: Mapped[str] = mapped_column(sa.String(64), default="")
    code_version: Mapped[str | None] = mapped_column(sa.String(64))
    state: Mapped[str] = mapped_column(sa.String(16), default="queued")
    progress: Mapped[float] = mapped_column(FiniteFloat, default=0.0)
    message: Mapped[str] = mapped_column(sa.Text, default="")
    stage: Mapped[str | None] = mapped_column(sa.String(16))
    reason: Mapped[str | None] = mapped_column(sa.Text)
    failure: Mapped[dict[str, Any] | None] = mapped_column(sa.JSON(none_as_null=True))
    steps: Mapped[list[dict[str, Any]] | None] = mapped_column(sa.JSON(none_as_null=True))
    attempts: Mapped[int] = mapped_column(default=0)
    crashes: Mapped[int] = mapped_column(default=0, server_default=sa.text("0"))
    cpu_s: Mapped[float] = mapped_column(FiniteFloat, default=0.0, server_default=sa.text("0"))
    cancel_requested: Mapped[bool] = mapped_column(default=False)
    started_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    finished_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    worker: Mapped[str | None] = mapped_column(sa.String(200))
    log: Mapped[str] = mapped_column(sa.Text, default="")
    revision: Mapped[int] = mapped_column(default=0, onupdate=sa.text("revision + 1"))


@final
class Result(Owned, Base):
    """results.json of a job, or its plan; at most one per job, of what the job is of."""

    __tablename__ = "results"
    __table_args__ = (
        sa.UniqueConstraint("job_id"),
        sa.CheckConstraint(ONE_OWNER, name="one_owner"),
        within_lab("job_id", "jobs"),
        within_lab("study_id", "studies"),
        within_lab("payload_id", "payloads"),
        within_lab("motion_id", "motions"),
        within_lab("plan_id", "plans"),
    )
    job_id: Mapped[str] = mapped_column(UUID)
    study_id: Mapped[str | None] = mapped_column(UUID, index=True)
    payload_id: Mapped[str | None] = mapped_column(UUID, index=True)
    motion_id: Mapped[str | None] = mapped_column(UUID, index=True)
    plan_id: Mapped[str | None] = mapped_column(UUID, index=True)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class Artifact(Owned, Base):
    """A file that a job made; name is its path below the job's output folder."""

    __tablename__ = "artifacts"
    __table_args__ = (
        sa.UniqueConstraint("job_id", "name"),
        within_lab("job_id", "jobs"),
    )
    job_id: Mapped[str] = mapped_column(UUID, index=True)
    name: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)
    media_type: Mapped[str] = mapped_column(sa.String(100))
