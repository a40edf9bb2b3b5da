"""What the service needs for itself: uploads on their way, keys of requests, workers, what is swept, who did what."""

from __future__ import annotations

from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Mapped, mapped_column

from exogauge.storage.database import UtcDateTime
from exogauge.storage.table_kinds import PATH, SHA256, UUID, Base, Owned


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
