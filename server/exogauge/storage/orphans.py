"""Blobs that no row names, and how they go without a row ever losing its bytes.

    unnamed ──noted──> waits ──condemned, an hour later and still unnamed──> bytes deleted ──> forgotten
       ^                 │
       └─────spared──────┘  by whoever adds a row that names it

A blob is written before the row that names it, so one without a name may be on its way. Whoever adds such a row spares
the blob in the same transaction; where it is condemned, or its bytes are gone, the row is refused (`Unavailable`), and
the same upload works again. Both sides change the one row of `orphans`, so its lock decides every race; no clock and no
time stamp of a file system counts. The hour has to be longer than a transaction, not than an upload.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from datetime import timedelta
from itertools import islice
from typing import Any, TypeVar

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import Unavailable
from exogauge.storage.blobs import BlobStore
from exogauge.storage.database import database_now
from exogauge.storage.row_security import sees_all
from exogauge.storage.tables import Base, Orphan

WAIT = timedelta(hours=1)
AT_ONCE = 500  # names in one statement
PARTS = tuple("0123456789abcdef")  # first digits: what is looked at in one transaction
Item = TypeVar("Item")


class BlobGone(Unavailable):
    """A row would name a blob that is gone, or about to go; put it again."""


def naming_columns() -> list[sa.Column[Any]]:
    """Every column that names a blob: `sha256`, or `…_sha256`, of any table but the one of orphans."""
    tables = (table for table in Base.metadata.sorted_tables if table is not Orphan.__table__)
    return [column for table in tables for column in table.columns if names_a_blob(column.name)]


def names_a_blob(column: str) -> bool:
    return column == "sha256" or column.endswith("_sha256")


def begins_with(column: Any, digits: str) -> sa.ColumnElement[bool]:
    """As a range, for which an index serves."""
    return sa.and_(column >= digits, column < digits + "g")


def named(session: Session, digits: str) -> set[str]:
    """Hashes with these first digits that rows of any lab name."""
    assert sees_all(session.connection())
    parts = [sa.select(column).where(begins_with(column, digits)) for column in naming_columns()]
    return set(session.scalars(sa.union(*parts)))


def spare(session: Session, blobs: BlobStore, names: Collection[str]) -> None:
    """Called in the transaction that adds rows naming these blobs. BlobGone where one is not there for long."""
    for some in batches(sorted(set(names))):
        waits = Orphan.sha256.in_(some) & Orphan.condemned_at.is_(None)
        session.execute(sa.delete(Orphan).where(waits), execution_options={"synchronize_session": False})
        if session.scalar(sa.select(sa.func.count()).where(Orphan.sha256.in_(some))):
            raise BlobGone("an equal file, which nothing needed, is just being removed; send it again")
        if blobs.lacking(some):
            raise BlobGone("an equal file, which nothing needed, was just removed; send it again")


def note(session: Session, digits: str, there: Iterable[str]) -> int:
    """Remember which of the blobs `there` (all with these first digits) nothing names; returns how many are new."""
    known = session.scalars(sa.select(Orphan.sha256).where(begins_with(Orphan.sha256, digits)))
    new = sorted(set(there) - named(session, digits) - set(known))
    now = database_now(session)
    session.add_all(Orphan(sha256=name, found_at=now) for name in new)
    return len(new)


def condemn(session: Session, waited: timedelta) -> None:
    """Doom what waits so long and is still named by nothing; forget what is named again."""
    assert sees_all(session.connection())
    has_name = sa.or_(*(sa.exists().where(column == Orphan.sha256) for column in naming_columns()))
    waits = Orphan.condemned_at.is_(None)
    quiet = {"synchronize_session": False}
    session.execute(sa.delete(Orphan).where(waits, has_name), execution_options=quiet)
    now = database_now(session)
    due = Orphan.found_at <= now - waited
    session.execute(sa.update(Orphan).where(waits, due, ~has_name).values(condemned_at=now), execution_options=quiet)


def condemned(session: Session, most: int = AT_ONCE) -> list[str]:
    return list(session.scalars(sa.select(Orphan.sha256).where(Orphan.condemned_at.is_not(None)).limit(most)))


def forget(session: Session, names: Collection[str]) -> None:
    """Their bytes are gone."""
    gone = sa.delete(Orphan).where(Orphan.sha256.in_(names), Orphan.condemned_at.is_not(None))
    session.execute(gone, execution_options={"synchronize_session": False})


def batches(items: Iterable[Item], size: int = AT_ONCE) -> Iterable[list[Item]]:
    left = iter(items)
    while some := list(islice(left, size)):
        yield some
