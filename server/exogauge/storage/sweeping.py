"""What nothing needs any more goes: of the installation blobs without a row, and of this machine what killed processes
left in the data folder. Safe beside uploads and jobs: `orphans` and `held_files` say why."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import timedelta
from pathlib import Path
from typing import final

import sqlalchemy as sa

from exogauge.settings import Settings
from exogauge.storage import orphans
from exogauge.storage.held_files import YOUNG_S, left_over, remove
from exogauge.storage.partial_files import PartialFiles
from exogauge.storage.store import Installation
from exogauge.storage.tables import LiveStream, Orphan, Upload, WorkerLease
from exogauge.storage.uploads import take_expired

SHELVES = (
    "scenes",
    "raw-series",
    "blob-copies",
)  # of what can be made again; how much is kept while it is used, `scene.drawing` says
SHELF_DAYS = 30.0  # after which what nobody looked at goes
FINISHED = (".scene", ".parquet", ".blob")  # on a shelf; other names are being written
UNFINISHED_S = 3600.0  # for which nobody writes at one picture: twenty times what the child that makes it may take


@final
@dataclass(frozen=True)
class Swept:
    """orphans_found: blobs that nothing names, seen for the first time. orphans_waiting: those that wait for their end.
    blobs, incoming: removed, of the store and half written. uploads, scratch, live, shelves: files and folders removed
    on this machine."""

    orphans_found: int = 0
    orphans_waiting: int = 0
    blobs: int = 0
    incoming: int = 0
    uploads: int = 0
    scratch: int = 0
    live: int = 0
    shelves: int = 0

    def __add__(self, other: Swept) -> Swept:
        theirs = asdict(other)
        return Swept(**{name: value + theirs[name] for name, value in asdict(self).items()})

    @property
    def removed(self) -> int:
        return self.blobs + self.incoming + self.uploads + self.scratch + self.live + self.shelves


def nothing_more() -> None:
    pass


def sweep_installation(
    installation: Installation, waited: timedelta = orphans.WAIT, still: Callable[[], None] = nothing_more
) -> Swept:
    """still: called now and then; raises to stop. waited: how long a blob must have been without a row; it may be less
    than `orphans.WAIT` only where no server and no worker runs."""
    found, blobs = 0, _remove_condemned(installation, still)  # what a killed sweep left
    for digits in orphans.PARTS:
        if not (there := list(installation.blobs.iterate(digits))):
            continue
        with installation.session() as session:
            found += orphans.note(session, digits, there)
        still()
    with installation.session() as session:
        orphans.condemn(session, waited)
    blobs += _remove_condemned(installation, still)
    _drop_pieces(installation)
    half = installation.blobs.left_over()
    for name in half:
        installation.blobs.remove_left_over(name)
    return Swept(found, waiting(installation), blobs, len(half))


def _drop_pieces(installation: Installation) -> None:
    """Of uploads that are no more: a row is there before its first piece."""
    if (pieces := installation.blobs.pieces) is not None:
        there = pieces.keys()
        for key in set(there) - kept_uploads(installation, there):
            pieces.drop(key)


def waiting(installation: Installation) -> int:
    with installation.session() as session:
        return session.scalar(sa.select(sa.func.count(Orphan.sha256))) or 0


def _remove_condemned(installation: Installation, still: Callable[[], None]) -> int:
    count = 0
    while True:
        with installation.session() as session:
            names = orphans.condemned(session)
        if not names:
            return count
        for name in names:
            installation.blobs.delete(name)
        with installation.session() as session:
            orphans.forget(session, names)
        count += len(names)
        still()


def sweep_machine(installation: Installation, settings: Settings, young_s: float = YOUNG_S) -> Swept:
    """young_s: what was touched so lately stays, held or not."""
    with installation.session() as session:
        expired = take_expired(session)
    files = PartialFiles(settings.uploads, installation.blobs.pieces)
    for key in expired:
        files.remove(key)
    strays = files.strays(lambda keys: kept_uploads(installation, keys), young_s)
    scratch = [*left_over(settings.scratch, young_s), *left_workers(installation, settings.work)]
    live = left_streams(installation, settings.live, young_s)
    stale = [path for name in SHELVES for path in left_on_shelf(settings.data_dir / name)]
    for path in (*strays, *scratch, *live, *stale):
        remove(path)
    return Swept(uploads=len(expired) + len(strays), scratch=len(scratch), live=len(live), shelves=len(stale))


def kept_uploads(installation: Installation, keys: list[str]) -> set[str]:
    found = set[str]()
    with installation.session() as session:
        for some in orphans.batches(keys):
            found.update(session.scalars(sa.select(Upload.id).where(Upload.id.in_(some))))
    return found


def left_workers(installation: Installation, folder: Path) -> list[Path]:
    """Folders of workers without a lease. A worker takes its lease before it makes its folder."""
    folders = sorted(folder.iterdir()) if folder.is_dir() else []
    with installation.session() as session:
        alive = set(session.scalars(sa.select(WorkerLease.worker_id)))
    return [each for each in folders if each.name not in alive]


def left_streams(installation: Installation, folder: Path, young_s: float) -> list[Path]:
    """Folders of live streams that ended, or were never written down."""
    folders = sorted(folder.iterdir()) if folder.is_dir() else []
    with installation.session() as session:
        of = [each.name for each in folders]
        still = LiveStream.state == "open"
        is_open = {
            key
            for some in orphans.batches(of)
            for key in session.scalars(sa.select(LiveStream.id).where(LiveStream.id.in_(some), still))
        }
    return [each for each in folders if each.name not in is_open and untouched(each, max(young_s, YOUNG_S))]


def left_on_shelf(folder: Path) -> list[Path]:
    """What nobody looked at for long, and what a killed process was writing."""
    files = sorted(folder.iterdir()) if folder.is_dir() else []
    patience = {True: SHELF_DAYS * 86_400.0, False: UNFINISHED_S}
    return [path for path in files if untouched(path, patience[path.suffix in FINISHED])]


def untouched(path: Path, for_s: float) -> bool:
    with suppress(FileNotFoundError):
        return time.time() - path.stat().st_mtime > for_s
    return False
