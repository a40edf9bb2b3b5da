"""Kinds of columns, and what tables have in common."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any
from uuid import uuid4

import sqlalchemy as sa
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from exogauge.storage.database import NAMING, UtcDateTime

UUID = sa.String(36)
SHA256 = sa.String(64)
NAME = sa.String(200)
PATH = sa.String(500)


def new_id() -> str:
    return str(uuid4())


def utc_now() -> datetime:
    return datetime.now(UTC)


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


class PinnedRow(Owned):
    """Columns of a file of something: its bytes are the blob of that hash."""

    path: Mapped[str] = mapped_column(PATH)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)
