"""Bytes, kept under the SHA-256 of what they are. A blob never changes; writing one twice changes nothing."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO, BinaryIO, Protocol, final

from exogauge.errors import DiskFull, Fault, NotFound, TooLarge, Unavailable, no_room
from exogauge.storage.held_files import hold, left_over, remove


@final
class InUse(Exception):
    """Another request writes to the file, at this server or another."""


class Pieces(Protocol):
    """Of all uploads."""

    def of(self, key: str) -> list[tuple[int, int]]:
        """Begin and size of each, from the file's begin on, without a gap."""
        ...

    def end(self, key: str) -> int:
        """Bytes that have arrived."""
        ...

    def send(self, key: str, file: BinaryIO, begin: int) -> None:
        """All of the file from there on. InUse where another was quicker."""
        ...

    def read(self, key: str, begin: int) -> bytes: ...
    def drop(self, key: str) -> None: ...

    def keys(self) -> list[str]:
        """Of uploads of which anything is there."""
        ...


CHUNK = 1024 * 1024
SHA256_HEX = re.compile(r"[0-9a-f]{64}")


class BlobStore(Protocol):
    """What the rest asks of a place that keeps bytes; an object store can fill it too."""

    @property
    def pieces(self) -> Pieces | None:
        """Where several servers see what arrives piece by piece; None: each on its own disk."""
        ...

    def put(self, source: bytes | Path | BinaryIO, limit: int | None = None) -> str:
        """Keep all of `source`, durably, and return its SHA-256 in hex. More than `limit` bytes raise TooLarge."""
        ...

    def open(self, sha256: str) -> BinaryIO: ...

    def stored(self, sha256: str) -> BinaryIO:
        """What the place itself holds: no copy that is nearer."""
        ...

    def size(self, sha256: str) -> int: ...
    def exists(self, sha256: str) -> bool: ...

    def lacking(self, names: Collection[str]) -> set[str]:
        """Which of them do not exist."""
        ...

    def delete(self, sha256: str) -> None: ...

    def refuse_if_full(self) -> None:
        """Unavailable where nothing could be kept now; writes nothing."""
        ...

    def iterate(self, prefix: str = "") -> Iterator[str]:
        """Hashes that begin with up to two hex digits, sorted."""
        ...

    def left_over(self) -> list[str]:
        """What killed writers left, by names that `remove_left_over` takes."""
        ...

    def remove_left_over(self, name: str) -> None: ...

    def path_for(self, sha256: str) -> Path | None:
        """A local, read-only path of the blob where the store has one; None where it has not."""
        ...


@final
class FolderBlobs:
    """Blobs in a folder: `ab/cdef…`. A write is temp file -> fsync -> rename -> fsync of the folder, so that a hash
    that is there holds all its bytes, whenever the process or the machine was killed."""

    pieces: Pieces | None = None

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.incoming = folder / "incoming"
        with disk("prepare the blob folder"):
            self.incoming.mkdir(parents=True, exist_ok=True)

    def put(self, source: bytes | Path | BinaryIO, limit: int | None = None) -> str:
        with disk("store the file"), NamedTemporaryFile(dir=self.incoming, delete=False) as temporary:
            try:
                hold(temporary.fileno())
                sha256 = copy_hashed(source, temporary, limit)
                temporary.flush()
                os.fsync(temporary.fileno())
                self._publish(Path(temporary.name), sha256)
            finally:
                Path(temporary.name).unlink(missing_ok=True)
        return sha256

    def _publish(self, temporary: Path, sha256: str) -> None:
        target = self._path(sha256)
        if target.exists():
            fsync_folder(target.parent)  # whoever renamed it may have been killed before this
            return
        if not target.parent.exists():
            target.parent.mkdir(exist_ok=True)
            fsync_folder(self.folder)
        temporary.chmod(0o444)
        temporary.replace(target)
        fsync_folder(target.parent)

    def open(self, sha256: str) -> BinaryIO:
        try:
            return self._path(sha256).open("rb")
        except FileNotFoundError as error:
            raise NotFound(f"no blob {sha256}") from error

    def stored(self, sha256: str) -> BinaryIO:
        return self.open(sha256)

    def size(self, sha256: str) -> int:
        try:
            return self._path(sha256).stat().st_size
        except FileNotFoundError as error:
            raise NotFound(f"no blob {sha256}") from error

    def exists(self, sha256: str) -> bool:
        return self._path(sha256).is_file()

    def lacking(self, names: Collection[str]) -> set[str]:
        return {name for name in names if not self.exists(name)}

    def delete(self, sha256: str) -> None:
        self._path(sha256).unlink(missing_ok=True)

    def refuse_if_full(self) -> None:
        refuse_full(self.incoming)

    def iterate(self, prefix: str = "") -> Iterator[str]:
        for folder in sorted(self.folder.glob(prefix + "[0-9a-f]" * (2 - len(prefix)))):
            yield from sorted(folder.name + path.name for path in folder.iterdir())

    def left_over(self) -> list[str]:
        return [path.name for path in left_over(self.incoming)]

    def remove_left_over(self, name: str) -> None:
        remove(self.incoming / name)

    def path_for(self, sha256: str) -> Path | None:
        path = self._path(sha256)
        if not path.is_file():
            raise NotFound(f"no blob {sha256}")
        return path

    def _path(self, sha256: str) -> Path:
        if not SHA256_HEX.fullmatch(sha256):
            raise NotFound("not the name of a blob")
        return self.folder / sha256[:2] / sha256[2:]


def refuse_full(folder: Path) -> None:
    """Unavailable where nothing could be written into it."""
    with disk("store files"):
        if not os.access(folder, os.W_OK):
            folder.stat()  # says it better, where it is gone
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        if shutil.disk_usage(folder).free == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def copy_hashed(source: bytes | Path | BinaryIO, target: IO[bytes], limit: int | None = None) -> str:
    """Copy `source` to `target` in chunks and return the SHA-256 of what was copied."""
    digest, written = hashlib.sha256(), 0
    for chunk in chunks(source):
        written += len(chunk)
        if limit is not None and written > limit:
            raise TooLarge(Fault(f"more than {limit} bytes", "file_too_large", "Split it, or ask for a higher limit."))
        digest.update(chunk)
        target.write(chunk)
    return digest.hexdigest()


def chunks(source: bytes | Path | BinaryIO) -> Iterator[bytes]:
    if isinstance(source, bytes):
        yield source
    elif isinstance(source, Path):
        with source.open("rb") as stream:
            yield from chunks(stream)
    else:
        while chunk := source.read(CHUNK):
            yield chunk


def copy_out(blobs: BlobStore, sha256: str, target: Path) -> None:
    """Write a blob to `target` (a copy: whoever changes it does not change the store)."""
    with disk("lay out the files"), blobs.open(sha256) as source:
        target.parent.mkdir(parents=True, exist_ok=True)
        with target.open("wb") as out:
            shutil.copyfileobj(source, out, CHUNK)


def fsync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def disk(what: str) -> Iterator[None]:
    """A disk that is full becomes `DiskFull`, one that is read-only or broken `Unavailable`."""
    try:
        yield
    except OSError as error:
        if no_room(error):
            raise DiskFull(f"cannot {what} now: the disk is full") from error
        raise Unavailable(f"cannot {what} now: {error.strerror or type(error).__name__}") from error
