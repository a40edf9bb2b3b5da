"""Files and folders of a process that may be killed: held by a lock that ends with it, however it ends.

What nobody holds is left over. A lock is asked for, and no clock, so that what takes long is never taken for dead.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import threading
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import final

YOUNG_S = 60.0  # between the making of a file and its lock lies a moment
LOCK = ".held"


def hold(descriptor: int) -> None:
    """Until it is closed, or this process ends."""
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_held(path: Path) -> bool:
    """By a process that lives. FileNotFoundError."""
    try:
        descriptor = os.open(path, os.O_RDWR)
    except PermissionError:  # finished, and about to be renamed
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def is_left(path: Path, young_s: float = YOUNG_S) -> bool:
    """Nobody holds the file or folder, and it is not just being made."""
    with suppress(FileNotFoundError):
        if time.time() - path.stat().st_mtime < young_s:
            return False
        lock = path / LOCK if path.is_dir() else path
        return not lock.exists() or not is_held(lock)
    return False


def left_over(folder: Path, young_s: float = YOUNG_S) -> list[Path]:
    """What lies in `folder` and nobody holds."""
    if not folder.is_dir():
        return []
    return [path for path in sorted(folder.iterdir()) if is_left(path, young_s)]


def remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


@final
class OwnFolder:
    """A folder below `parent` that is this process' for as long as it lives; made when it is first asked for."""

    def __init__(self, parent: Path) -> None:
        self.parent = parent
        self._path: Path | None = None
        self._lock: int | None = None
        self._making = threading.Lock()

    @property
    def path(self) -> Path:
        with self._making:
            if self._path is None or not self._path.is_dir():
                self.close()
                self.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
                self._path = Path(mkdtemp(dir=self.parent))
                self._lock = os.open(self._path / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
                hold(self._lock)
            return self._path

    def close(self) -> None:
        """Remove it."""
        if self._lock is not None:
            os.close(self._lock)
        if self._path is not None:
            shutil.rmtree(self._path, ignore_errors=True)
        self._path = self._lock = None


@cache
def own_folder(parent: Path) -> OwnFolder:
    """That of this process."""
    return OwnFolder(parent)
