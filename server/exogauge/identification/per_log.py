"""What was computed from logs, kept for whoever asks again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from threading import RLock
from typing import Any, TypeVar, final
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.model import Log

V = TypeVar("V")

MOST_BYTES = 120_000_000  # of all that share a room: six logs of 50 s and 34 joints; to prepare one takes 40 ms


@final
class PerLog:
    """By what it is and by the log itself, never by its name; where there is no room for more some go (`_Room`).

    A log is kept with what was computed from it, so that no other takes its place. Threads may share it. All have one
    room, so that a model that is asked no more has nothing there after a while; most_bytes: in one of its own.
    """

    def __init__(self, most_bytes: int | None = None) -> None:
        self._room = COMMON_ROOM if most_bytes is None else _Room(most_bytes)
        finalize(self, self._room.leave, id(self))

    def of(self, log: Log, what: str, compute: Callable[[], V]) -> V:
        """What is known of this log, else `compute()`, which is kept."""
        found = self._room.known((id(self), what, id(log)))
        if found is None:
            return self.put(log, what, compute())
        value: V = found[1]
        return value

    def put(self, log: Log, what: str, value: V) -> V:
        """Keep it in place of what was known."""
        self._room.keep((id(self), what, id(log)), (log, value, _bytes(value)))
        return value

    def __len__(self) -> int:
        return self._room.count(id(self))


Key = tuple[int, str, int]  # whose, what, of which log


@final
class _Room:
    """Who takes much goes before who takes little, and of the same size the longest unused: passes over all logs again
    and again would find nothing where the longest unused alone went (GreedyDual-Size: Cao and Irani, USENIX 1997).

    Two threads that ask for the same at once both compute it.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes, self._bytes = most_bytes, 0
        self._kept: OrderedDict[Key, tuple[Log, Any, int]] = OrderedDict()
        self._turn: dict[Key, float] = {}  # who goes next has the least
        self._gone = 0.0  # the turn of who went last
        self._lock = RLock()  # who leaves may do so while something is put here

    def known(self, key: Key) -> tuple[Log, Any, int] | None:
        with self._lock:
            found = self._kept.get(key)
            if found is not None:
                self._kept.move_to_end(key)
                self._turn[key] = self._gone + 1.0 / max(found[2], 1)
            return found

    def keep(self, key: Key, entry: tuple[Log, Any, int]) -> None:
        with self._lock:
            self._drop(key)
            if entry[2] > self._most_bytes:
                return
            self._kept[key] = entry
            self._bytes += entry[2]
            self._turn[key] = self._gone + 1.0 / max(entry[2], 1)
            while self._bytes > self._most_bytes:
                next_one = min(self._kept, key=self._turn.__getitem__)
                self._gone = self._turn[next_one]
                self._drop(next_one)

    def leave(self, who: int) -> None:
        with self._lock:
            for key in [key for key in self._kept if key[0] == who]:
                self._drop(key)

    def count(self, who: int) -> int:
        with self._lock:
            return sum(key[0] == who for key in self._kept)

    def _drop(self, key: Key) -> None:
        if key in self._kept:
            self._bytes -= self._kept.pop(key)[2]
            del self._turn[key]


COMMON_ROOM = _Room(MOST_BYTES)


def _owner(array: NDArray[Any]) -> NDArray[Any]:
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


def _bytes(value: object) -> int:
    """Of the arrays in a value and in its parts, each counted once; the log is there anyway."""
    found: dict[int, int] = {}
    parts = [value]
    while parts:
        part = parts.pop()
        if isinstance(part, np.ndarray):
            held = _owner(part)  # several arrays may show the same numbers
            found[id(held)] = held.nbytes if any(held.strides) else held.itemsize
        elif isinstance(part, tuple):
            parts += part
        elif isinstance(part, Mapping):
            parts += part.values()
        elif is_dataclass(part) and not isinstance(part, Log):
            parts += vars(part).values()
    return sum(found.values())
