"""The tables. Every row of a lab carries `lab_id`; keys are random UUIDs; times are aware UTC; arrays live in blobs."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any, final
from uuid import uuid4

import sqlalchemy as sa
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from exogauge.storage.database import NAMING, FiniteFloat, UtcDateTime

UUID = sa.String(36)
SHA256 = sa.String(64)
NAME = sa.String(200)
PATH = sa.String(500)
STATES = ("queued", "running", "succeeded", "failed", "cancelled")
LIVE_STATES = ("queued", "running", "succeeded")  # what makes an equal request the same job
DELIVERY_STATES = ("waiting", "delivered", "failed")
STREAM_STATES = ("open", "ended", "lost")  # lost: whoever sent or took it went without a word
OWNERS = ("study", "payload", "motion", "plan")  # what a job can be of
ONE_OWNER = " + ".join(f"(CASE WHEN {noun}_id IS NULL THEN 0 ELSE 1 END)" for noun in OWNERS) + " = 1"


def new_id() -> str:
    return str(uuid4())


def utc_now() -> datetime:
    return datetime.now(UTC)


def owner_of(row: Any) -> tuple[str, str]:
    """What a job or a result is of: one of `OWNERS`, and its id."""
    named = ((noun, getattr(row, f"{noun}_id")) for noun in OWNERS)
    return next((noun, key) for noun, key in named if key is not None)


def one_of(column: str, values: tuple[str, ...]) -> str:
    return f"{column} IN ({', '.join(repr(value) for value in values)})"


class Base(DeclarativeBase):
    metadata = sa.MetaData(naming_convention=NAMING)


class Owned:
    """Columns of every row that belongs to a lab."""

    id: Mapped[str] = mapped_column(UUID, primary_key=True, default=new_id)
    lab_id: Mapped[str] = mapped_column(sa.String(64))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class Named(Owned):
    """Columns of what has a name and is found by words. content_hash: over the paths and hashes of its files."""

    name: Mapped[str] = mapped_column(NAME)
    content_hash: Mapped[str] = mapped_column(SHA256)
    summary: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    words: Mapped[str] = mapped_column(sa.Text, server_default=sa.text("''"))


def referred() -> sa.UniqueConstraint:
    """What rows of the same lab may refer to, with `within_lab`."""
    return sa.UniqueConstraint("lab_id", "id")


def within_lab(column: str, table: str, ondelete: str | None = "CASCADE") -> sa.ForeignKeyConstraint:
    """The row that `column` names is one of `table`, of the same lab; the row goes when that one goes."""
    return sa.ForeignKeyConstraint(["lab_id", column], [f"{table}.lab_id", f"{table}.id"], ondelete=ondelete)


class Remembered(Owned):
    """Columns of what is kept one to a key and may change. content_hash: of the canonical JSON of content."""

    content: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    content_hash: Mapped[str] = mapped_column(SHA256)
    changed_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


@final
class Robot(Named, Base):
    """One version of a robot bundle."""

    __tablename__ = "robots"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]


@final
class RobotFile(Owned, Base):
    """One file of a robot bundle."""

    __tablename__ = "robot_files"
    __table_args__ = (
        sa.UniqueConstraint("robot_id", "path"),
        within_lab("robot_id", "robots"),
    )
    robot_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class Device(Named, Base):
    """One version of a device bundle, checked against one robot.

    The same files checked against another robot are another version: what the check found belongs to both.
    """

    __tablename__ = "devices"
    __table_args__ = (
        within_lab("robot_id", "robots", None),
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "robot_id", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]
    robot_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class DeviceFile(Owned, Base):
    """One file of a device bundle: device.yaml, bench tests."""

    __tablename__ = "device_files"
    __table_args__ = (
        sa.UniqueConstraint("device_id", "path"),
        within_lab("device_id", "devices"),
    )
    device_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class Log(Owned, Base):
    """An uploaded log, byte for byte, with what its reading said of it. mapping_sha256: the mapping it is read with."""

    __tablename__ = "logs"
    __table_args__ = (
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    name: Mapped[str] = mapped_column(NAME)
    content_hash: Mapped[str] = mapped_column(SHA256)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)
    mapping_sha256: Mapped[str | None] = mapped_column(SHA256, index=True)
    summary: Mapped[dict[str, Any]] = mapped_column(sa.JSON)


@final
class Study(Named, Base):
    """A study as it was handed in; its files are pinned by hash and never change."""

    __tablename__ = "studies"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )


@final
class StudyFile(Owned, Base):
    """One pinned file of a study: study.yaml, the robot bundle, logs, mappings, device."""

    __tablename__ = "study_files"
    __table_args__ = (
        sa.UniqueConstraint("study_id", "path"),
        within_lab("study_id", "studies"),
    )
    study_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class Payload(Named, Base):
    """One version of what hangs on a wrist sensor, as it was handed in; its files are pinned by hash."""

    __tablename__ = "payloads"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]


@final
class PayloadFile(Owned, Base):
    """One file of a payload: payload.yaml, the URDF, logs."""

    __tablename__ = "payload_files"
    __table_args__ = (
        sa.UniqueConstraint("payload_id", "path"),
        within_lab("payload_id", "payloads"),
    )
    payload_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class Motion(Named, Base):
    """One version of what was captured of a person, as it was handed in: motion.yaml and the files that it names."""

    __tablename__ = "motions"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]


@final
class MotionFile(Owned, Base):
    """One file of a motion: motion.yaml, the capture, its skeleton, a static trial."""

    __tablename__ = "motion_files"
    __table_args__ = (
        sa.UniqueConstraint("motion_id", "path"),
        within_lab("motion_id", "motions"),
    )
    motion_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class MotionContacts(Remembered, Base):
    """When each foot of a motion stands, as somebody said it. content: {left, right: [[begin, end] [s]]}."""

    __tablename__ = "motion_contacts"
    __table_args__ = (
        sa.UniqueConstraint("motion_id"),
        within_lab("motion_id", "motions"),
    )
    motion_id: Mapped[str] = mapped_column(UUID)


@final
class MotionMap(Remembered, Base):
    """What a lab's own labels or bones are called elsewhere. content: {own name: known name}."""

    __tablename__ = "motion_maps"
    __table_args__ = (sa.UniqueConstraint("lab_id", "name"), sa.Index(None, "lab_id", "created_at", "id"))
    name: Mapped[str] = mapped_column(NAME)


@final
class Plan(Named, Base):
    """A motion that was asked for of a robot: plan.yaml says how. motion_id: what is retargeted; study_id: whose logs
    are known already. What they name stays as long as the plan does."""

    __tablename__ = "plans"
    __table_args__ = (
        within_lab("robot_id", "robots", None),
        within_lab("motion_id", "motions", None),
        within_lab("study_id", "studies", None),
        referred(),
        sa.UniqueConstraint("lab_id", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    robot_id: Mapped[str] = mapped_column(UUID, index=True)
    motion_id: Mapped[str | None] = mapped_column(UUID, index=True)
    study_id: Mapped[str | None] = mapped_column(UUID, index=True)


@final
class PlanFile(Owned, Base):
    """One file of a plan: plan.yaml."""

    __tablename__ = "plan_files"
    __table_args__ = (
        sa.UniqueConstraint("plan_id", "path"),
        within_lab("plan_id", "plans"),
    )
    plan_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)


@final
class LiveStream(Owned, Base):
    """What arrived live from the sensor of a payload.

    job_id: whose results compensated it, and stay as long as it does. samples: taken; dropped: refused or never
    arrived; late: taken, behind their time. last_sequence: number of the last sample taken, None before the first.
    sha256, size: of the raw stream, kept as a blob, None while it is open.
    """

    __tablename__ = "live_streams"
    __table_args__ = (
        within_lab("payload_id", "payloads"),
        within_lab("job_id", "jobs", None),
        sa.CheckConstraint(one_of("state", STREAM_STATES), name="state"),
        sa.CheckConstraint("samples >= 0 AND dropped >= 0 AND late >= 0", name="counts"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    payload_id: Mapped[str] = mapped_column(UUID, index=True)
    job_id: Mapped[str | None] = mapped_column(UUID, index=True)
    state: Mapped[str] = mapped_column(sa.String(16), default="open")
    started_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    ended_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    samples: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    dropped: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    late: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    last_sequence: Mapped[int | None] = mapped_column(sa.BigInteger)
    summary: Mapped[dict[str, Any]] = mapped_column(sa.JSON, default=dict)
    sha256: Mapped[str | None] = mapped_column(SHA256, index=True)
    size: Mapped[int | None] = mapped_column(sa.BigInteger)


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


@final
class Publication(Owned, Base):
    """A snapshot of what a job found, which anybody may read; the database refuses to change or delete it.

    key: of its address. series_id: the id of its first version. study_id, job_id: where it came from, which may be
    gone. content_hash: over `manifest`, [{path, sha256, size, media_type}], which stays when its files go. about: as
    whoever published it said. lab_name: the publisher's, then. revoked_at: since when its files are gone.
    """

    __tablename__ = "publications"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("key"),
        sa.UniqueConstraint("series_id", "version"),
        sa.Index(None, "lab_id", "created_at", "id"),
        sa.Index(None, "study_id"),
    )
    key: Mapped[str] = mapped_column(sa.String(16))
    series_id: Mapped[str] = mapped_column(UUID)
    version: Mapped[int]
    study_id: Mapped[str] = mapped_column(UUID)
    job_id: Mapped[str] = mapped_column(UUID)
    content_hash: Mapped[str] = mapped_column(SHA256)
    manifest: Mapped[list[dict[str, Any]]] = mapped_column(sa.JSON)
    about: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    lab_name: Mapped[str] = mapped_column(NAME)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    revoked_because: Mapped[str | None] = mapped_column(sa.Text)


@final
class PublicationFile(Owned, Base):
    """A file of a publication; it goes when that is revoked."""

    __tablename__ = "publication_files"
    __table_args__ = (
        sa.UniqueConstraint("publication_id", "path"),
        within_lab("publication_id", "publications"),
    )
    publication_id: Mapped[str] = mapped_column(UUID, index=True)
    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)
    media_type: Mapped[str] = mapped_column(sa.String(100))


@final
class Webhook(Owned, Base):
    """An address that is told what happens in the lab. secret: with which each delivery is signed."""

    __tablename__ = "webhooks"
    __table_args__ = (referred(), sa.Index(None, "lab_id", "created_at", "id"))
    url: Mapped[str] = mapped_column(sa.String(2000))
    events: Mapped[list[str]] = mapped_column(sa.JSON)
    secret: Mapped[str] = mapped_column(sa.String(100))
    disabled_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    disabled_because: Mapped[str | None] = mapped_column(sa.String(500))


@final
class Delivery(Owned, Base):
    """What a webhook is to be told, or was. due_at: of the next try; status, said: of the last one."""

    __tablename__ = "deliveries"
    __table_args__ = (
        within_lab("webhook_id", "webhooks"),
        sa.CheckConstraint(one_of("state", DELIVERY_STATES), name="state"),
        sa.Index(None, "state", "due_at"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    webhook_id: Mapped[str] = mapped_column(UUID, index=True)
    event: Mapped[str] = mapped_column(sa.String(64))
    data: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    state: Mapped[str] = mapped_column(sa.String(16))
    attempts: Mapped[int]
    due_at: Mapped[datetime] = mapped_column(UtcDateTime)
    ended_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    status: Mapped[int | None]
    said: Mapped[str] = mapped_column(sa.String(500), default="")


@final
class Upload(Owned, Base):
    """A file that is being received. size: bytes it will have; those that arrived are on disk and nowhere else."""

    __tablename__ = "uploads"
    __table_args__ = (sa.Index(None, "expires_at"),)
    name: Mapped[str] = mapped_column(PATH)
    size: Mapped[int] = mapped_column(sa.BigInteger)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)


@final
class RobotMapping(Remembered, Base):
    """How the logs of a robot are read, remembered from the last import. content: as in mapping.yaml."""

    __tablename__ = "robot_mappings"
    __table_args__ = (
        sa.UniqueConstraint("robot_id"),
        within_lab("robot_id", "robots"),
    )
    robot_id: Mapped[str] = mapped_column(UUID)


@final
class IdempotencyKey(Owned, Base):
    """A POST that was made with a key. answer: None while it is in flight; owner: the one request that serves it.
    expires_at: on the database's clock; of one in flight, until when it is held, and of an answer, is kept."""

    __tablename__ = "idempotency_keys"
    __table_args__ = (sa.UniqueConstraint("lab_id", "key"), sa.Index(None, "lab_id", "expires_at"))
    key: Mapped[str] = mapped_column(sa.String(255))
    owner: Mapped[str] = mapped_column(UUID)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    request_hash: Mapped[str | None] = mapped_column(SHA256)
    answer: Mapped[dict[str, Any] | None] = mapped_column(sa.JSON(none_as_null=True))


@final
class WorkerLease(Base):
    """A worker process that is alive as long as beat_at is recent on the database's clock."""

    __tablename__ = "worker_leases"
    worker_id: Mapped[str] = mapped_column(sa.String(200), primary_key=True)
    beat_at: Mapped[datetime] = mapped_column(UtcDateTime)
    started_at: Mapped[datetime] = mapped_column(UtcDateTime)
    host: Mapped[str] = mapped_column(sa.String(255))
    pid: Mapped[int] = mapped_column(sa.BigInteger)


@final
class Orphan(Base):
    """A blob of the installation that no row named (`storage.orphans`). condemned_at: since when it is to go."""

    __tablename__ = "orphans"
    sha256: Mapped[str] = mapped_column(SHA256, primary_key=True)
    found_at: Mapped[datetime] = mapped_column(UtcDateTime)
    condemned_at: Mapped[datetime | None] = mapped_column(UtcDateTime, index=True)


@final
class Chore(Base):
    """What is done for the whole installation now and then, by one process at a time (`storage.chores`)."""

    __tablename__ = "chores"
    name: Mapped[str] = mapped_column(sa.String(64), primary_key=True)
    holder: Mapped[str | None] = mapped_column(sa.String(200))
    held_until: Mapped[datetime | None] = mapped_column(UtcDateTime)
    due_at: Mapped[datetime] = mapped_column(UtcDateTime)
    outcome: Mapped[dict[str, Any] | None] = mapped_column(sa.JSON(none_as_null=True))


@final
class AuditEntry(Owned, Base):
    """Who did what to what; the database refuses to change or delete a row. actor: `account:ID`, `token:ID`, `worker`,
    or `local` where there are no accounts. said: in words, where hashes do not say it."""

    __tablename__ = "audit"
    __table_args__ = (sa.Index(None, "lab_id", "created_at"),)
    actor: Mapped[str] = mapped_column(sa.String(200))
    action: Mapped[str] = mapped_column(sa.String(64))
    subject_kind: Mapped[str] = mapped_column(sa.String(64))
    subject_id: Mapped[str] = mapped_column(UUID)
    before_hash: Mapped[str | None] = mapped_column(SHA256)
    after_hash: Mapped[str | None] = mapped_column(SHA256)
    said: Mapped[str] = mapped_column(sa.Text, default="", server_default=sa.text("''"))
