"""What the service needs for itself: uploads on their way, keys of requests, workers, what is swept, who did what;
and what a lab tells others: publications, and addresses that hear of events.
"""

from __future__ import annotations

from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Mapped, mapped_column

from exogauge.storage.database import UtcDateTime
from exogauge.storage.table_kinds import NAME, PATH, SHA256, UUID, Base, Owned, PinnedRow, one_of, referred, within_lab


@final
class Upload(Owned, Base):
    """A file that is being received. size: bytes it will have; those that arrived are on disk and nowhere else."""

    __tablename__ = "uploads"
    __table_args__ = (sa.Index(None, "expires_at"),)
    name: Mapped[str] = mapped_column(PATH)
    size: Mapped[int] = mapped_column(sa.BigInteger)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)


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


DELIVERY_STATES = ("waiting", "delivered", "failed")


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
class PublicationFile(PinnedRow, Base):
    """A file of a publication; it goes when that is revoked."""

    __tablename__ = "publication_files"
    __table_args__ = (
        sa.UniqueConstraint("publication_id", "path"),
        within_lab("publication_id", "publications"),
    )
    publication_id: Mapped[str] = mapped_column(UUID, index=True)
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
