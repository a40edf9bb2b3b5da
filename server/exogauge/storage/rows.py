"""What every noun of the store shares: rows of one lab, turned into records, newest first in pages."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from datetime import datetime
from typing import Any, TypeVar, final

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, NotFound
from exogauge.storage import tables
from exogauge.storage.records import Page
from exogauge.storage.scope import actor_of

Record = TypeVar("Record")
RACES = 5
UUID_TEXT = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")


@final
@dataclass(frozen=True)
class Lab:
    """One lab's rows inside one transaction."""

    session: Session
    lab_id: str

    def select(self, table: type[tables.Owned]) -> sa.Select[Any]:
        return sa.select(table).where(table.lab_id == self.lab_id).execution_options(populate_existing=True)

    def one(self, record: type[Record], query: sa.Select[Any]) -> Record | None:
        row = self.session.execute(columns_of(record, query).limit(1)).first()
        return None if row is None else record(*row)

    def get(self, record: type[Record], table: type[tables.Owned], key: str, noun: str) -> Record:
        found = self.one(record, self.select(table).where(table.id == key)) if UUID_TEXT.fullmatch(key) else None
        if found is None:
            raise NotFound(f"there is no {noun} {key[:64]!a}")
        return found

    def page(
        self,
        record: type[Record],
        table: type[tables.Owned],
        query: sa.Select[Any],
        after: tuple[datetime, str] | None,
        limit: int,
    ) -> Page[Record]:
        if after is not None:
            when, key = after
            older = sa.and_(table.created_at == when, table.id < key)
            query = query.where(sa.or_(table.created_at < when, older))
        newest = query.order_by(table.created_at.desc(), table.id.desc()).limit(limit + 1)
        rows = self.session.execute(columns_of(record, newest)).all()
        shown = rows[:limit]
        end = (shown[-1].created_at, shown[-1].id) if len(rows) > limit else None
        return Page(tuple(record(*row) for row in shown), end)

    def find_or_add(
        self, find: Callable[[], Record | None], make: Callable[[], list[tables.Base]], noun: str
    ) -> tuple[Record, bool]:
        """The record that `find` finds, or one made of the rows of `make`; a unique constraint decides any race."""
        for _ in range(RACES):
            if (found := find()) is not None:
                return found, False
            try:
                with self.session.begin_nested():
                    first, *rest = make()
                    self.session.add(first)  # what the others refer to
                    self.session.flush()
                    self.session.add_all(rest)
            except IntegrityError:
                continue
            if (made := find()) is not None:
                return made, True
        raise Conflict(f"this {noun} is being changed by someone else; try again")

    def audit(
        self, action: str, kind: str, key: str, before: str | None = None, after: str | None = None, said: str = ""
    ) -> None:
        """Record who did what, in the transaction that does it."""
        record(self.session, self.lab_id, actor_of(self.session), action, kind, key, before, after, said)


def record(
    session: Session,
    lab_id: str,
    actor: str,
    action: str,
    kind: str,
    key: str,
    before: str | None = None,
    after: str | None = None,
    said: str = "",
) -> None:
    """A row of the lab's audit."""
    entry = tables.AuditEntry(
        lab_id=lab_id, actor=actor, action=action, subject_kind=kind, subject_id=key,
        before_hash=before, after_hash=after, said=said,
    )  # fmt: skip
    session.add(entry)


def columns_of(record: type[Record], query: sa.Select[Any]) -> sa.Select[Any]:
    """The same rows, of each only what the record has, in its order: no object of the mapper is made of it."""
    table = query.column_descriptions[0]["entity"]
    return query.with_only_columns(*(getattr(table, name) for name in names_of(record)))


def names_of(record: Any) -> tuple[str, ...]:
    """Fields of a record, in order."""
    return tuple(field.name for field in fields(record))


def as_record(record: type[Record], row: Any) -> Record:
    """What leaves `storage` of a row that the mapper has made: by equal names."""
    return record(*(getattr(row, name) for name in names_of(record)))
