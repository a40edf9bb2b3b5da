"""Files that arrive piece by piece. How much of one has arrived is how long it is on disk, or in the object store where
there is one: nothing else remembers it, so nothing can disagree with it after a kill."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, final

from exogauge.errors import NotFound
from exogauge.storage.blobs import InUse, Pieces, chunks, disk, fsync_folder
from exogauge.storage.held_files import hold, left_over

CHECKED = ".checking"  # beside a file: a piece whose checksum is not known yet


@final
@dataclass(frozen=True)
class PartialFiles:
    """pieces: where other servers see what has arrived; what lies in the folder is then a copy that is made again."""

    folder: Path
    pieces: Pieces | None = None

    def create(self, key: str) -> None:
        with disk("begin the upload"):
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            self.path(key).touch(mode=0o600, exist_ok=False)
            fsync_folder(self.folder)

    def path(self, key: str) -> Path:
        return self.folder / key

    def offset(self, key: str) -> int:
        """Bytes that have arrived."""
        if self.pieces is not None:
            return self.pieces.end(key)
        try:
            return self.path(key).stat().st_size
        except FileNotFoundError as error:
            raise NotFound(f"nothing is left of upload {key}; begin it again") from error

    def whole(self, key: str) -> tuple[Path, int]:
        """What has arrived, all of it in the folder, and its bytes."""
        if self.pieces is not None:
            with self.appending(key):
                pass
        return self.path(key), self.offset(key)

    def share(self, key: str, file: BinaryIO, begin: int) -> None:
        """What was appended since is seen by the other servers, or is gone again (InUse: one of them was quicker)."""
        if self.pieces is None:
            return
        try:
            with self.path(key).open("rb") as written:
                self.pieces.send(key, written, begin)
        except InUse:
            file.truncate(begin)
            raise

    def remove(self, key: str) -> None:
        if self.pieces is not None:
            self.pieces.drop(key)
        self.path(key).unlink(missing_ok=True)
        self.path(key + CHECKED).unlink(missing_ok=True)

    def strays(self, known: Callable[[list[str]], set[str]], young_s: float) -> list[Path]:
        """Files of no upload, and pieces whose sender is gone. known: which of these keys are uploads."""
        old = left_over(self.folder, young_s)
        kept = known([path.name.removesuffix(CHECKED) for path in old])
        return [path for path in old if path.name.removesuffix(CHECKED) not in kept or path.name.endswith(CHECKED)]

    @contextmanager
    def appending(self, key: str) -> Iterator[BinaryIO]:
        """The file's end, unbuffered, for one writer at a time (InUse), whoever was killed before. `sync` it."""
        if self.pieces is None:
            self.offset(key)
        else:
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with disk("receive the upload"), self.path(key).open("ab", buffering=0) as file:
            with one_writer():
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._make_again(key, file)
            yield file

    def _make_again(self, key: str, file: BinaryIO) -> None:
        """What other servers have taken is fetched; what was not shared before a kill is taken again."""
        if self.pieces is None:
            return
        for begin, size in self.pieces.of(key):
            there = os.fstat(file.fileno()).st_size
            if begin + size > there:
                write_all(file, self.pieces.read(key, begin)[there - begin :])
        file.truncate(self.pieces.end(key))

    @contextmanager
    def checked_piece(self, key: str) -> Iterator[BinaryIO]:
        """A file for one piece until its checksum is known; gone afterwards."""
        path = self.path(key + CHECKED)
        try:
            with disk("receive the upload"), path.open("w+b", buffering=0) as file:
                hold(file.fileno())
                yield file
        finally:
            path.unlink(missing_ok=True)


@contextmanager
def one_writer() -> Iterator[None]:
    try:
        yield
    except BlockingIOError as error:
        raise InUse from error


def write_all(file: BinaryIO, data: bytes) -> None:
    """An unbuffered write may take only a part."""
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]


def sync(file: BinaryIO) -> None:
    """What was written survives a power cut."""
    os.fsync(file.fileno())


def copy_piece(piece: BinaryIO, file: BinaryIO) -> None:
    piece.seek(0)
    for chunk in chunks(piece):
        write_all(file, chunk)
