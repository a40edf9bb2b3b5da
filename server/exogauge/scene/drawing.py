"""Scenes drawn when they are first asked for, in a child process, and kept on a shelf of limited size."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, final

from exogauge.errors import BadStudy
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.scene.opening import SCENE

CHILD = "exogauge.scene.opening"
KEPT_BYTES = 512 << 20
AT_ONCE = 2  # children that draw at the same time


def draw_log(folder: Path, log: str, series: Path | None, results: Path) -> bytes:
    """folder: the study's files, results.json and the series beside it or elsewhere. Raises BadInput, Unavailable."""
    found = None if series is None else str(series)
    options = {"folder": str(folder), "log": log, "series": found, "results": str(results)}
    return _drawn("recording", options, folder, "study")


def draw_at_rest(folder: Path, robot: str, device: str | None) -> bytes:
    """robot, device: folders below `folder` that hold robot.yaml and device.yaml. Raises BadInput, Unavailable."""
    worn = None if device is None else str(folder / device)
    return _drawn("still", {"robot_folder": str(folder / robot), "device_folder": worn}, folder, "robot")


def draw_payload(folder: Path, results: Path | None, postures: Path | None) -> bytes:
    """folder: the payload's files; results.json and postures.csv elsewhere. Raises BadInput, Unavailable."""
    given = {name: None if path is None else str(path) for name, path in (("results", results), ("postures", postures))}
    return _drawn("payload", {"folder": str(folder), **given}, folder, "payload")


def draw_played(robot: Path, played: Path, figure: Path | None) -> bytes:
    """robot: folder of robot.yaml; what a job of a plan left to draw. Raises BadInput, Unavailable."""
    given = {"played": str(played), "figure": None if figure is None else str(figure)}
    return _drawn("played", {"robot_folder": str(robot), **given}, robot, "plan")


def draw_captured(folder: Path, figure: Path | None) -> bytes:
    """folder: the motion's files; figure: of a body that was fitted. Raises BadInput, Unavailable."""
    options = {"folder": str(folder), "figure": None if figure is None else str(figure)}
    return _drawn("captured", options, folder, "motion")


def _drawn(task: str, options: dict[str, Any], folder: Path, what: str) -> bytes:
    limits = Limits.for_bytes(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
    with TemporaryDirectory(prefix="exogauge-") as own:
        ask(CHILD, task, options, Path(own), limits, BadStudy, what=what)
        return (Path(own) / SCENE).read_bytes()


@final
class Shelf:
    """Files by key in a folder; the ones looked at longest ago go when it is full. Threads and processes share it."""

    def __init__(self, folder: Path, kept_bytes: int = KEPT_BYTES, suffix: str = ".scene") -> None:
        self._folder, self._kept_bytes, self._suffix = folder, kept_bytes, suffix
        self._making: dict[str, threading.Lock] = {}
        self._lock, self._at_once = threading.Lock(), threading.Semaphore(AT_ONCE)

    def get(self, key: str, make: Callable[[], bytes]) -> Path:
        """The file of this key (letters and digits); `make` is called where there is none, and may raise."""
        return self.filled(key, lambda path: path.write_bytes(make()))

    def filled(self, key: str, write: Callable[[Path], object]) -> Path:
        """As `get`, where `write` puts the content at a path on the same file system."""
        path = self._folder / f"{key}{self._suffix}"
        with self._lock:
            making = self._making.setdefault(key, threading.Lock())
        with making:
            try:
                if not self._touched(path):
                    with self._at_once:
                        self._put(path, write)
            finally:
                with self._lock:
                    self._making.pop(key, None)
        return path

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
