"""What a lab tells others: publications, and addresses that hear of events."""

from __future__ import annotations

from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Mapped, mapped_column

from exogauge.storage.database import UtcDateTime
from exogauge.storage.table_kinds import NAME, SHA256, UUID, Base, Owned, PinnedRow, one_of, referred, within_lab

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
