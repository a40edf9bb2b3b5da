"""An installation in a folder, and back: rows as JSON lines, blobs under their hashes, a manifest over both.

    manifest.json      revision of the schema, tables with rows and hash, written last
    rows/<table>.jsonl one row per line, as it stands in the database
    blobs/ab/cdef…     every blob that a row names

What is read is one moment's state, beside a service that runs. It goes into either kind of database, whichever it came
from, at the revision it was written at, and is then brought to that of this code. The queue's own tables are not in it:
workers write an entry for every job that waits. Neither are uploads on their way, which lie on one machine.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from exogauge import __version__
from exogauge.errors import BadInput, Conflict, Fault, Unavailable
from exogauge.settings import Settings
from exogauge.storage import chores, migrate, orphans
from exogauge.storage.blobs import BlobStore, FolderBlobs, disk, fsync_folder
from exogauge.storage.database import READONLY, make_engine, serving
from exogauge.storage.row_security import ALL, see
from exogauge.storage.store import Installation
from exogauge.storage.tables import Base, Chore
from exogauge.upkeep.hourly import EVERY, SWEEP

FORMAT = 1  # of a backup's folder
MANIFEST, ROWS, BLOBS = "manifest.json", "rows", "blobs"
OF_THIS_RUN = (  # what processes that run, and browsers that are signed in, have, and no data
    "uploads", "worker_leases", "orphans", "chores", "sessions", "sign_in_tries",
)  # fmt: skip
AT_ONCE = 500  # rows in one piece
Said = Callable[[int, int], None]


@final
@dataclass(frozen=True)
class BackedUp:
    """bytes: of all blobs; copied: how many of them were not in the folder before."""

    rows: int
    blobs: int
    bytes: int
    copied: int


def quiet(_done: int, _of: int) -> None:
    pass


def back_up(installation: Installation, folder: Path, holder: str, said: Said = quiet) -> BackedUp:
    """Into a new folder, or over the backup that it holds: blobs that are there already are not copied again.

    No sweep begins while it runs, so that what the rows name stays. Conflict where one runs now.
    """
    if folder.is_dir() and any(folder.iterdir()) and not (folder / MANIFEST).is_file():
        raise Conflict(f"{folder} holds something that is no backup; name another folder")
    known = 0
    with without_sweeps(installation, holder) as still, disk("write the backup"):
        folder.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(folder / f"{ROWS}.new", ignore_errors=True)
        (folder / f"{ROWS}.new").mkdir()
        with reading_all(installation.engine) as (connection, tables):
            revision = migrate.revision_of(connection)
            if revision is None:
                raise Conflict("there is nothing of exogauge in this database: its address may be another's")
            names, counts = set[str](), dict[str, dict[str, Any]]()
            for table in tables:
                counts[table.name] = write_rows(connection, table, folder / f"{ROWS}.new", names)
        kept, copied, size = FolderBlobs(folder / BLOBS), 0, 0
        for known, name in enumerate(sorted(names), 1):
            said(known, len(names))
            if not kept.exists(name):
                copy(installation.blobs, kept, name)
                copied += 1
            size += kept.size(name)
            if known % AT_ONCE == 0:
                still()
        manifest = {
            "format": FORMAT, "exogauge": __version__, "revision": revision, "made_at": datetime.now(UTC).isoformat(),
            "tables": counts, "blobs": len(names), "bytes": size,
        }  # fmt: skip
        finish(folder, manifest)
    return BackedUp(sum(each["rows"] for each in counts.values()), len(names), size, copied)


def finish(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Put the new rows in the place of the old ones; whoever is killed meanwhile leaves no manifest, or a right one."""
    (folder / MANIFEST).unlink(missing_ok=True)
    fsync_folder(folder)
    shutil.rmtree(folder / ROWS, ignore_errors=True)
    (folder / f"{ROWS}.new").rename(folder / ROWS)
    with (folder / f"{MANIFEST}.new").open("w") as file:
        json.dump(manifest, file, indent=1)
        file.flush()
        os.fsync(file.fileno())
    (folder / f"{MANIFEST}.new").rename(folder / MANIFEST)
    fsync_folder(folder)


@contextmanager
def without_sweeps(installation: Installation, holder: str) -> Iterator[Callable[[], None]]:
    """Hold that chore; yields what puts the end of the lease off. Of an older schema there is none that sweeps."""
    if not sa.inspect(installation.engine).has_table(Chore.__tablename__):
        yield lambda: None
        return
    with installation.session() as session:
        if not chores.take(session, SWEEP, holder, now_due=True):
            raise Conflict("a sweep runs now; try again in a few minutes")

    def still() -> None:
        with installation.session() as session:
            if not chores.hold_on(session, SWEEP, holder):
                raise Unavailable("the backup took so long that a sweep began beside it; begin it again")

    try:
        yield still
    finally:
        with installation.session() as session:
            chores.done(session, SWEEP, holder, EVERY, None)


@contextmanager
def reading_all(engine: sa.Engine) -> Iterator[tuple[Connection, list[sa.Table]]]:
    """One moment's state of the tables that hold data, each after those that it refers to."""
    options = {
        READONLY: True,
        **(
            {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
            if engine.dialect.name == "postgresql"
            else {}
        ),
    }
    with serving("be backed up"), engine.connect().execution_options(**options) as connection:
        see(connection, ALL)
        yield connection, tables_in(connection)


def tables_in(connection: Connection) -> list[sa.Table]:
    """As the database has them, whatever its revision."""
    found = sa.MetaData()
    found.reflect(connection, only=lambda name, _: name in Base.metadata.tables and name not in OF_THIS_RUN)
    for table in found.sorted_tables:
        for column in table.columns:
            if isinstance(column.type, sa.JSON):
                column.type = sa.JSON(none_as_null=True)
    return found.sorted_tables


def write_rows(connection: Connection, table: sa.Table, folder: Path, names: set[str]) -> dict[str, Any]:
    """names: gets the blobs that the rows name."""
    digest, count = hashlib.sha256(), 0
    naming = [column.name for column in table.columns if orphans.names_a_blob(column.name)]
    path = folder / f"{table.name}.jsonl"
    with path.open("wb") as file:
        rows = connection.execution_options(yield_per=AT_ONCE).execute(
            sa.select(table).order_by(*table.primary_key.columns)
        )
        for row in rows.mappings():
            line = json.dumps({key: plain(value) for key, value in row.items()}, allow_nan=False).encode() + b"\n"
            file.write(line)
            digest.update(line)
            count += 1
            names.update(row[name] for name in naming if row[name] is not None)
        file.flush()
        os.fsync(file.fileno())
    return {"rows": count, "sha256": digest.hexdigest()}


def plain(value: Any) -> Any:
    """A time is {"at": ISO, in UTC}; JSON in a column is {"json": …}."""
    if isinstance(value, datetime):
        aware = value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)
        return {"at": aware.isoformat()}
    return {"json": value} if isinstance(value, dict | list) else value


def unplain(value: Any, dialect: str) -> Any:
    if not isinstance(value, dict):
        return value
    if "json" in value:
        return value["json"]
    at = datetime.fromisoformat(value["at"])
    return at.replace(tzinfo=None) if dialect == "sqlite" else at


def copy(source: BlobStore, target: BlobStore, name: str) -> None:
    with source.stored(name) as stream:
        if (made := target.put(stream)) != name:
            target.delete(made)
            fault = Fault("its bytes are not what its name says", "corrupt_blob", "`exogauge check` tells more.", name)
            raise BadInput(fault)


def restore(folder: Path, settings: Settings, blobs: BlobStore, said: Said = quiet) -> BackedUp:
    """Into an empty database and a blob store. BadInput: the backup is not whole. Conflict: something is there.

    Blobs first, then all rows in one transaction, then the schema's way up to this code.
    """
    manifest = read_manifest(folder)
    kept, size, copied = FolderBlobs(folder / BLOBS), 0, 0
    refuse_what_is_there(settings.database_url)
    names = names_in(folder, manifest)
    for done, name in enumerate(names, 1):
        said(done, len(names))
        if not kept.exists(name):
            raise BadInput(Fault("a blob that a row names is missing", "missing_blob", "Take another backup.", name))
        size += kept.size(name)
        if not blobs.exists(name):
            copy(kept, blobs, name)
            copied += 1
    migrate.upgrade(settings.database_url, manifest["revision"])
    rows = read_rows(folder, manifest, settings.database_url)
    migrate.upgrade(settings.database_url)
    return BackedUp(rows, len(names), size, copied)


def read_manifest(folder: Path) -> dict[str, Any]:
    try:
        manifest: dict[str, Any] = json.loads((folder / MANIFEST).read_text())
    except (OSError, ValueError) as error:
        advice = "Name the folder that `exogauge backup` wrote to its end."
        raise BadInput(
            Fault("there is no backup here, or not a whole one", "no_backup", advice, str(folder))
        ) from error
    if manifest["format"] != FORMAT:
        fault = Fault("a newer version of exogauge wrote it", "newer_backup", "Restore it with that one.", str(folder))
        raise BadInput(fault)
    for name, table in manifest["tables"].items():
        path = folder / ROWS / f"{name}.jsonl"
        if not path.is_file() or hashlib.sha256(path.read_bytes()).hexdigest() != table["sha256"]:
            fault = Fault("the rows are not those that were written", "damaged_rows", "Take another backup.", str(path))
            raise BadInput(fault)
    return manifest


def refuse_what_is_there(database_url: str) -> None:
    engine = make_engine(database_url, migrating=True)
    try:
        with serving("answer"), engine.connect() as connection:
            there = sa.inspect(connection).get_table_names()
            full = [
                name
                for name in there
                if name in Base.metadata.tables
                and name not in OF_THIS_RUN
                and connection.scalar(sa.select(sa.literal(1)).select_from(sa.table(name)).limit(1))
            ]
            if full:
                advice = "Restore into an empty database: name another in EXOGAUGE_DATABASE_URL."
                raise Conflict(f"the database holds rows ({', '.join(sorted(full))}). {advice}")
            if "alembic_version" in there:  # empty, at whatever revision
                connection.rollback()
    finally:
        engine.dispose()
    if migrate.current(database_url) is not None:
        migrate.downgrade(database_url, "base")


def names_in(folder: Path, manifest: Mapping[str, Any]) -> list[str]:
    names = set[str]()
    for name in manifest["tables"]:
        for row in lines_of(folder, name):
            names.update(value for key, value in row.items() if value is not None and orphans.names_a_blob(key))
    return sorted(names)


def lines_of(folder: Path, table: str) -> Iterator[dict[str, Any]]:
    with (folder / ROWS / f"{table}.jsonl").open("rb") as file:
        for line in file:
            yield json.loads(line)


def read_rows(folder: Path, manifest: Mapping[str, Any], database_url: str) -> int:
    """All or none."""
    engine, count = make_engine(database_url, migrating=True), 0
    try:
        with serving("be restored"), engine.begin() as connection:
            for table in tables_in(connection):
                for some in orphans.batches(lines_of(folder, table.name), AT_ONCE):
                    rows = [{key: unplain(value, engine.dialect.name) for key, value in row.items()} for row in some]
                    connection.execute(sa.insert(table), [told_as_lost(table.name, row) for row in rows])
                    count += len(rows)
            if (wanted := sum(each["rows"] for each in manifest["tables"].values())) != count:
                raise Conflict(f"{count} of {wanted} rows could be read: this version lacks a table")
    finally:
        engine.dispose()
    return count


def told_as_lost(table: str, row: dict[str, Any]) -> dict[str, Any]:
    """A live stream that was open is over: its samples lay on the machine that took them."""
    if table == "live_streams" and row["state"] == "open":
        return {**row, "state": "lost", "ended_at": row["started_at"] + timedelta(0)}
    return row
