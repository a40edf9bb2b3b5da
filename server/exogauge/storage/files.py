"""Files of a bundle: their paths made safe, their content pinned by hash."""

from __future__ import annotations

import hashlib
import unicodedata
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import final

from exogauge.errors import BadStudy, Fault, NotFound
from exogauge.storage.blobs import BlobStore

LONGEST_PATH = 400
LONGEST_PART = 180
DEEPEST = 16


@final
@dataclass(frozen=True)
class PinnedFile:
    """A file by its path inside the bundle and the SHA-256 of its bytes; size in bytes."""

    path: str
    sha256: str
    size: int


def safe_path(text: str) -> str:
    """`text` as a relative path with forward slashes, or BadStudy: nothing may point outside its bundle."""
    path = unicodedata.normalize("NFC", text)
    parts = path.split("/")
    fault = None
    if not path or len(path) > LONGEST_PATH or len(parts) > DEEPEST:
        fault = "its path is empty, too long or too deep"
    elif any(not character.isprintable() for character in path) or "\\" in path or ":" in path:
        fault = "its path holds a backslash, a colon or a control character"
    elif any(part in ("", ".", "..") or len(part.encode()) > LONGEST_PART for part in parts):
        fault = "its path is absolute, steps upwards, or has an empty or very long part"
    if fault:
        shown = ascii(text[:LONGEST_PATH])
        raise BadStudy(
            Fault(f"a file of the bundle is refused: {fault}", "unsafe_path", "Use plain relative paths.", value=shown)
        )
    return path


def file_at(files: Iterable[PinnedFile], path: str, what: str) -> PinnedFile:
    """The one at `path`; no path on disk is ever made of what a caller asks for. what: whose files they are."""
    found = next((file for file in files if file.path == path), None)
    if found is None:
        raise NotFound(f"{what} has no file of this path")
    return found


def content_hash(files: Iterable[PinnedFile]) -> str:
    """One hash of a set of files: of their sorted paths and hashes."""
    lines = sorted(f"{file.path}\0{file.sha256}\n" for file in files)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def keep_folder(blobs: BlobStore, folder: Path) -> tuple[PinnedFile, ...]:
    """Put every regular file below `folder` into the blob store (durable before any row names it); sorted by path."""
    return _pinned(folder, blobs.put)


def hashed_folder(folder: Path) -> tuple[PinnedFile, ...]:
    """The same of files that are not kept, or not yet."""
    return _pinned(folder, hash_of)


def hash_of(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _pinned(folder: Path, name: Callable[[Path], str]) -> tuple[PinnedFile, ...]:
    paths = sorted(path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    return tuple(
        PinnedFile(safe_path(path.relative_to(folder).as_posix()), name(path), path.stat().st_size) for path in paths
    )
