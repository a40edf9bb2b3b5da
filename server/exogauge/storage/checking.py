"""Is everything there, and is it what it was: blobs against hashes, rows against blobs, rows against rows, and what
lies about. Reads, and changes nothing."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import NotFound
from exogauge.settings import Settings
from exogauge.storage import orphans
from exogauge.storage.blobs import BlobStore, chunks
from exogauge.storage.held_files import left_over
from exogauge.storage.partial_files import PartialFiles
from exogauge.storage.store import Installation
from exogauge.storage.sweeping import SHELVES, kept_uploads, left_on_shelf, left_streams, left_workers

MOST_TOLD = 100  # of each kind; the rest is counted


@final
@dataclass
class Findings:
    """corrupt: blobs that are not what their name says. missing: blobs that a row names and that are not there, with
    the row. sizes: rows that tell another size than the blob has. broken: what the database says of itself. These four
    mean a loss. orphans: blobs that no row names; left_over: what killed processes left: both go by themselves."""

    blobs: int = 0
    bytes: int = 0
    references: int = 0
    corrupt: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    sizes: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    orphans: list[str] = field(default_factory=list)
    left_over: list[str] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        return not (self.corrupt or self.missing or self.sizes or self.broken)

    def as_json(self) -> dict[str, Any]:
        """Of each kind the first ones, and how many."""
        found = asdict(self)
        lists = {name: value for name, value in found.items() if isinstance(value, list)}
        told = {name: {"count": len(value), "first": value[:MOST_TOLD]} for name, value in lists.items()}
        return {**found, **told, "sound": self.sound}


def check(
    installation: Installation,
    settings: Settings | None,
    parts: Sequence[str] = orphans.PARTS,
    said: Callable[[int, int], None] = lambda done, of: None,
) -> Findings:
    """settings: of this machine, whose left-over files are told. parts: first digits of the blobs that are read."""
    found = Findings()
    for k, digits in enumerate(parts):
        said(k, len(parts))
        _check_blobs(installation, digits, found)
    with installation.reading() as session:
        found.broken += list(broken_references(session))
    if settings is not None:
        found.left_over += [str(path) for path in left_on_machine(installation, settings)]
    found.left_over += installation.blobs.left_over()
    return found


def _check_blobs(installation: Installation, digits: str, found: Findings) -> None:
    there = set(installation.blobs.iterate(digits))  # before the rows: what comes meanwhile is no orphan …
    with installation.reading() as session:
        rows = list(naming_rows(session, digits))
    named = {sha256 for _, _, sha256, _ in rows}
    found.orphans += sorted(there - named)
    found.references += len(rows)
    sizes = dict[str, int]()
    for name in sorted(there | named):
        try:
            whole, sizes[name] = _read(installation.blobs, name)
        except NotFound:
            continue  # … and what went meanwhile is not missing, unless a row still names it
        found.blobs += 1
        found.bytes += sizes[name]
        if not whole:
            found.corrupt.append(name)
    for table, key, sha256, size in rows:
        if sha256 not in sizes and _still_names(installation, table, key):
            found.missing.append(f"{sha256}: {table} {key}")
        elif size is not None and sizes.get(sha256, size) != size and sha256 not in found.corrupt:
            found.sizes.append(f"{sha256}: {table} {key} says {size} bytes, it has {sizes[sha256]}")


def _read(blobs: BlobStore, name: str) -> tuple[bool, int]:
    digest, size = hashlib.sha256(), 0
    with blobs.stored(name) as stream:
        for chunk in chunks(stream):
            digest.update(chunk)
            size += len(chunk)
    return digest.hexdigest() == name, size


def naming_rows(session: Session, digits: str) -> Iterator[tuple[str, str, str, int | None]]:
    """Table, id, hash, and the size that the row tells of it."""
    for column in orphans.naming_columns():
        table = column.table
        size = table.c.size if column.name == "sha256" and "size" in table.c else sa.null()
        for key, sha256, told in session.execute(
            sa.select(table.c.id, column, size).where(orphans.begins_with(column, digits))
        ):
            yield str(table), key, sha256, told


def _still_names(installation: Installation, table: str, key: str) -> bool:
    with installation.reading() as session:
        return bool(
            session.scalar(sa.select(sa.func.count()).select_from(sa.table(table)).where(sa.column("id") == key))
        )


def broken_references(session: Session) -> Iterator[str]:
    """What SQLite finds in its file; PostgreSQL holds references itself and finds torn pages when it reads them."""
    if session.get_bind().dialect.name != "sqlite":
        return
    for row in session.execute(sa.text("PRAGMA foreign_key_check")):
        yield f"a row of {row[0]} names one of {row[2]} that is not there"
    for (said,) in session.execute(sa.text("PRAGMA quick_check(20)")):
        if said != "ok":
            yield str(said)


def left_on_machine(installation: Installation, settings: Settings) -> list[Path]:
    strays = PartialFiles(settings.uploads).strays(lambda keys: kept_uploads(installation, keys), 60.0)
    shelves = [path for name in SHELVES for path in left_on_shelf(settings.data_dir / name)]
    workers = left_workers(installation, settings.work)
    return [*strays, *left_over(settings.scratch), *workers, *left_streams(installation, settings.live, 60.0), *shelves]
