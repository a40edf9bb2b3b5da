"""What every noun of the store shares: rows of one lab, turned into records, newest first in pages."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from functools import cache
from typing import Any, TypeVar, cast, final

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, NotFound
from exogauge.storage import tables
from exogauge.storage.database import UtcDateTime
from exogauge.storage.records import Page
from exogauge.storage.scope import actor_of

Record = TypeVar("Record")
Make = TypeVar("Make", bound=Callable[..., Any])
RACES = 5
LAB, KEY = sa.bindparam("lab", type_=sa.String()), sa.bindparam("key", type_=sa.String())
BEFORE, MOST = sa.bindparam("before", type_=UtcDateTime()), sa.bindparam("most", type_=sa.Integer())
UUID_TEXT = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")


def once(make: Make) -> Make:
    """`functools.cache`, which keeps the types."""
    return cast(Make, cache(make))


@final
@dataclass(frozen=True)
class Marked:
    """Of a row only which it is."""

    id: str


@final
@dataclass(frozen=True)
class Lab:
    """One lab's rows inside one transaction."""

    session: Session
    lab_id: str

    def select(self, table: type[tables.Owned]) -> sa.Select[Any]:
        return sa.select(table).where(table.lab_id == self.lab_id).execution_options(populate_existing=True)

    def rows(self, statement: sa.Select[Any], **given: Any) -> Sequence[Any]:
        """Of a statement that was made once, and names its lab as `lab`. What was added before is seen. It is asked of
        the connection: what the mapper does for its own statements took as long as a short one."""
        self.session.flush()
        return self.session.connection().execute(statement, {"lab": self.lab_id, **given}).all()

    def one(self, record: type[Record], query: sa.Select[Any]) -> Record | None:
        row = self.session.execute(columns_of(record, query).limit(1)).first()
        return None if row is None else record(*row)

    def get(self, record: type[Record], table: type[tables.Owned], key: str, noun: str) -> Record:
        found = self.rows(by_id(record, table), key=key) if UUID_TEXT.fullmatch(key) else ()
        if not found:
            raise NotFound(f"there is no {noun} {key[:64]!a}")
        return record(*found[0])

    def must_be(self, table: type[tables.Owned], key: str, noun: str) -> None:
        """Raises NotFound where there is none."""
        self.get(Marked, table, key, noun)

    def page(
        self,
        record: type[Record],
        table: type[tables.Owned],
        after: tuple[datetime, str] | None,
        limit: int,
        *wanted: sa.ColumnElement[bool],
    ) -> Page[Record]:
        """wanted: what holds for each of them, beside that it is the lab's."""
        given: dict[str, Any] = {"most": limit + 1}
        if after is not None:
            given["before"], given["key"] = after
        query = newest(record, table, after is not None)
        rows = self.rows(query.where(*wanted) if wanted else query, **given)
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


# Statements made once, by what is asked for alone: the lab and all else comes with each request. Most of what a short
# request costs is what is made anew for it.


@once
def of_lab(record: Any, table: type[tables.Owned]) -> sa.Select[Any]:
    """A lab's rows, of each what the record has, in its order; for `Lab.rows`."""
    columns = columns_in(table)
    return sa.select(*(columns[name] for name in names_of(record))).where(columns.lab_id == LAB)


@once
def by_id(record: Any, table: type[tables.Owned]) -> sa.Select[Any]:
    """The one whose id is `key`."""
    return of_lab(record, table).where(columns_in(table).id == KEY)


@once
def newest(record: Any, table: type[tables.Owned], goes_on: bool) -> sa.Select[Any]:
    """`most` of them at most, newest first; goes_on: those after the one of id `key` at the time `before`."""
    columns, query = columns_in(table), of_lab(record, table)
    if goes_on:
        older = sa.and_(columns.created_at == BEFORE, columns.id < KEY)
        query = query.where(sa.or_(columns.created_at < BEFORE, older))
    return query.order_by(columns.created_at.desc(), columns.id.desc()).limit(MOST)


def columns_in(table: type[tables.Owned]) -> Any:
    return sa.inspect(table).local_table.c


def columns_of(record: type[Record], query: sa.Select[Any]) -> sa.Select[Any]:
    """The same rows, of each only what the record has, in its order: no object of the mapper is made of it."""
    table = query.column_descriptions[0]["entity"]
    return query.with_only_columns(*(getattr(table, name) for name in names_of(record)))


@once
def names_of(record: Any) -> tuple[str, ...]:
    """Fields of a record, in order."""
    return tuple(field.name for field in fields(record))


def as_record(record: type[Record], row: Any) -> Record:
    """What leaves `storage` of a row that the mapper has made: by equal names."""
    return record(*(getattr(row, name) for name in names_of(record)))
