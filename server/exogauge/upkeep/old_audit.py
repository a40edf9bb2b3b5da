"""Old entries of the audit: written to a file, and taken from the database where whoever runs the installation says so.

The service cannot do it: what it works as may delete no entry. Here the tables' owner lifts the guard inside one
transaction, which no other transaction sees, and the audit of each lab tells what went, and by which file.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.engine import Connection
from sqlalchemy.exc import ProgrammingError
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, Unavailable
from exogauge.storage.blobs import disk, fsync_folder
from exogauge.storage.database import READONLY, database_now, make_engine, serving
from exogauge.storage.orphans import AT_ONCE, batches
from exogauge.storage.rows import record
from exogauge.storage.tables import AuditEntry

ACTOR = "operator"
LEAST = timedelta(days=30)  # judgement: a lab's admin looks on the page first for what happened lately
TABLE: sa.Table = AuditEntry.__table__  # type: ignore[assignment]
COLUMNS = tuple(column.name for column in TABLE.columns)


@final
@dataclass(frozen=True)
class Archived:
    """entries: lab -> how many are in the file. sha256: of its bytes. file: None where there was nothing to write."""

    before: datetime
    file: Path | None
    entries: dict[str, int]
    sha256: str
    removed: bool

    @property
    def count(self) -> int:
        return sum(self.entries.values())


def archive_audit(database_url: str, folder: Path, age: timedelta, *, remove: bool = False) -> Archived:
    """Entries older than `age`, one JSON object a line, oldest first, into a new file of `folder`; they stay in the
    database unless `remove`. Conflict: a file of that day is there, or the age is under `LEAST`."""
    if age < LEAST:
        raise Conflict(f"entries of the last {LEAST.days} days stay: name an age of {LEAST.days} days or more")
    engine = make_engine(database_url, migrating=True)
    try:
        with serving("tell its audit"), Session(engine.execution_options(**{READONLY: True})) as session:
            before = database_now(session) - age
            path = folder / f"audit-before-{before:%Y-%m-%d}.jsonl"
            keys, entries, sha256 = _written(session, before, path)
        if not keys:
            return Archived(before, None, {}, sha256, False)
        if remove:
            with serving("be freed of its old audit"), Session(engine) as session, session.begin():
                _remove(
                    session, keys, {lab: _words(count, before, path.name, sha256) for lab, count in entries.items()}
                )
    finally:
        engine.dispose()
    return Archived(before, path, entries, sha256, remove)


def _words(count: int, before: datetime, name: str, sha256: str) -> str:
    return f"{count} entries from before {before:%Y-%m-%d %H:%M} UTC, written to {name}, SHA-256 {sha256}"


def _written(session: Session, before: datetime, path: Path) -> tuple[list[str], dict[str, int], str]:
    """Ids of the rows in the file, lab -> rows, SHA-256. The file is there as a whole or not at all."""
    old = sa.select(TABLE).where(TABLE.c.created_at < before).order_by(TABLE.c.created_at, TABLE.c.id)
    keys, entries, digest = list[str](), dict[str, int](), hashlib.sha256()
    with disk("write the audit"):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            raise Conflict(f"{path} is there already; name another folder, or move it away")
        partial = path.with_suffix(".part")
        with partial.open("wb") as file:
            for row in session.execute(old, execution_options={"yield_per": AT_ONCE}).mappings():
                line = json.dumps({name: _plain(row[name]) for name in COLUMNS}).encode() + b"\n"
                file.write(line)
                digest.update(line)
                keys.append(row["id"])
                entries[row["lab_id"]] = entries.get(row["lab_id"], 0) + 1
            file.flush()
            os.fsync(file.fileno())
        if not keys:
            partial.unlink()
        elif hashlib.sha256(partial.read_bytes()).hexdigest() != digest.hexdigest():
            raise Unavailable(f"{partial} does not hold what was written to it; nothing was removed")
        else:
            partial.rename(path)
        fsync_folder(path.parent)
    return keys, entries, digest.hexdigest()


def _plain(value: Any) -> Any:
    return value.isoformat() if isinstance(value, datetime) else value


def _remove(session: Session, keys: list[str], told: dict[str, str]) -> None:
    """Those rows, all or none. told: lab -> what its audit says of it."""
    gone = 0
    with unguarded(session.connection()):
        for some in batches(keys):
            done = session.connection().execute(sa.delete(TABLE).where(TABLE.c.id.in_(some)))
            gone += done.rowcount
    if gone != len(keys):
        raise Conflict(
            f"{len(keys)} entries were written and {gone} are there to be removed: somebody else does it, too"
        )
    for lab, said in told.items():
        record(session, lab, ACTOR, "archive", "audit", lab[:36], said=said)


@contextmanager
def unguarded(connection: Connection) -> Iterator[None]:
    """Until the end of the block entries can be deleted, by this transaction alone."""
    if connection.dialect.name == "postgresql":
        try:
            connection.exec_driver_sql("ALTER TABLE audit DISABLE TRIGGER audit_refuses_change")
        except ProgrammingError as error:
            raise Conflict(
                "this login may not do that: name that of the tables' owner, as `exogauge migrate` has it"
            ) from error
        yield
        connection.exec_driver_sql("ALTER TABLE audit ENABLE TRIGGER audit_refuses_change")
        return
    named = sa.text("SELECT sql FROM sqlite_master WHERE type = 'trigger' AND name = 'audit_refuses_delete'")
    guard = connection.execute(named).scalar_one()
    connection.exec_driver_sql("DROP TRIGGER audit_refuses_delete")
    yield
    connection.exec_driver_sql(guard)
