"""What can be made, or fetched, again: files of this machine in a folder of limited size."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import final

from exogauge.errors import Unavailable

MOST_WAITING = 12  # judgement: of a server's 40 threads for one slow thing (two shelves, an object store)


@final
class Shelf:
    """Files by key in a folder; the ones looked at longest ago go when it is full. Threads and processes share it."""

    def __init__(
        self, folder: Path, kept_bytes: int, suffix: str, at_once: int = 2, most: float = MOST_WAITING
    ) -> None:
        """at_once: how many may be made at the same time. most: how many may ask for what is still to be made; others
        are sent away (Unavailable), as who waits holds a thread."""
        self._folder, self._kept_bytes, self._suffix = folder, kept_bytes, suffix
        self._making: dict[str, threading.Lock] = {}
        self._lock, self._at_once = threading.Lock(), threading.Semaphore(at_once)
        self._most, self._inside = most, 0

    def get(self, key: str, make: Callable[[], bytes]) -> Path:
        """The file of this key (letters and digits); `make` is called where there is none, and may raise."""
        return self.filled(key, lambda path: path.write_bytes(make()))

    def filled(self, key: str, write: Callable[[Path], object]) -> Path:
        """As `get`, where `write` puts the content at a path on the same file system."""
        if (there := self.found(key)) is not None:
            return there
        path = self._path(key)
        with self._lock:
            if self._inside >= self._most:
                raise Unavailable("too much is asked for at once that has to be made first; try again in a moment")
            self._inside += 1
            making = self._making.setdefault(key, threading.Lock())
        try:
            with making:
                try:
                    if not self._touched(path):
                        with self._at_once:
                            self._put(path, write)
                finally:
                    with self._lock:
                        self._making.pop(key, None)
        finally:
            with self._lock:
                self._inside -= 1
        return path

    def found(self, key: str) -> Path | None:
        """The file of this key, if it is there now."""
        path = self._path(key)
        return path if self._touched(path) else None

    def drop(self, key: str) -> None:
        self._path(key).unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self._folder / f"{key}{self._suffix}"

    def _touched(self, path: Path) -> bool:
        try:
            os.utime(path)
        except FileNotFoundError:
            return False
        return True

    def _put(self, path: Path, write: Callable[[Path], object]) -> None:
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        temporary = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}")
        try:
            write(temporary)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
        self._make_room(path)

    def _make_room(self, kept: Path) -> None:
        with suppress(FileNotFoundError):  # another process made room as well
            files = sorted(self._folder.glob(f"*{self._suffix}"), key=lambda path: path.stat().st_mtime, reverse=True)
            total = 0
            for path in files:
                total += path.stat().st_size
                if total > self._kept_bytes and path != kept:
                    path.unlink(missing_ok=True)
