"""What was computed from logs, kept for whoever asks again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import is_dataclass
from threading import Lock
from typing import Any, TypeVar, final

import numpy as np

from exogauge.logs.model import Log

V = TypeVar("V")

MOST_BYTES = 400_000_000  # of one cache: forty logs of 20 s and 34 joints, so that a study prepares each of them once


@final
class PerLog:
    """By what it is and by the log itself, never by its name; the longest unused go where there is no room for more.

    A log is kept with what was computed from it, so that no other takes its place.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes, self._bytes = most_bytes, 0
        self._kept: OrderedDict[tuple[str, int], tuple[Log, Any, int]] = OrderedDict()
        self._lock = Lock()  # of the bookkeeping: two that ask for the same at once both compute it

    def of(self, log: Log, what: str, compute: Callable[[], V]) -> V:
        """What is known of this log, else `compute()`, which is kept."""
        with self._lock:
            found = self._kept.get((what, id(log)))
            if found is not None:
                self._kept.move_to_end((what, id(log)))
        if found is None:
            return self.put(log, what, compute())
        value: V = found[1]
        return value

    def put(self, log: Log, what: str, value: V) -> V:
        """Keep it in place of what was known."""
        size = _bytes(value)
        with self._lock:
            self._drop((what, id(log)))
            self._kept[what, id(log)] = (log, value, size)
            self._bytes += size
            while self._bytes > self._most_bytes:
                self._drop(next(iter(self._kept)))
        return value

    def _drop(self, key: tuple[str, int]) -> None:
        if key in self._kept:
            self._bytes -= self._kept.pop(key)[2]

    def __len__(self) -> int:
        return len(self._kept)


def _bytes(value: object) -> int:
    """Of the arrays in a value and in its parts, each counted once; the log is there anyway."""
    found: dict[int, int] = {}
    parts = [value]
    while parts:
        part = parts.pop()
        if isinstance(part, np.ndarray):
            found[id(part)] = part.nbytes
        elif isinstance(part, tuple):
            parts += part
        elif is_dataclass(part) and not isinstance(part, Log):
            parts += vars(part).values()
    return sum(found.values())
