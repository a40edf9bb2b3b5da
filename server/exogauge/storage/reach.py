"""The way to an object store: what it says when it fails, and how many wait for one that says nothing."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import final

from obstore.exceptions import AlreadyExistsError, BaseError

from exogauge.errors import Away, NotFound
from exogauge.storage.shelf import MOST_WAITING

SILENT_S = 3.0  # judgement: for which nobody was answered; longer than a store stumbles


@final
class Reach:
    """Of one process. However many may ask a store that answers; of one that does not, so many wait, and all others
    are told at once, as are those who ask right after one has waited in vain. `reached(what, sha256)` is about one
    call."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._lock = clock, threading.Lock()
        self._inside, self._busy_since = 0, 0.0
        self._answered = self._in_vain = -math.inf  # when somebody was last answered; when one last waited for nothing
        self._mine = threading.local()

    @contextmanager
    def room(self, what: str) -> Iterator[None]:
        """For what may wait for the store, or for others who do. Away where too many wait for nothing."""
        if getattr(self._mine, "has", False):
            yield
            return
        with self._lock:
            now = self._clock()
            if self._inside == 0:
                self._busy_since = now
            elif self._inside >= MOST_WAITING and now - max(self._busy_since, self._answered) > SILENT_S:
                raise Away(f"cannot {what} now: the object store does not answer")
            self._inside += 1
        self._mine.has = True
        try:
            yield
        finally:
            self._mine.has = False
            with self._lock:
                self._inside -= 1

    @contextmanager
    def __call__(self, what: str, sha256: str | None = None) -> Iterator[None]:
        """A store that cannot be reached, or refuses, is `Away`. sha256: of what it may lack, which is NotFound."""
        with self.room(what):
            began = self._clock()
            if began - SILENT_S < self._in_vain and self._answered < self._in_vain:
                raise Away(f"cannot {what} now: the object store does not answer")
            try:
                yield
            except (AlreadyExistsError, FileNotFoundError) as error:
                self._answered = self._clock()
                if isinstance(error, AlreadyExistsError):
                    raise
                if sha256 is not None:
                    raise NotFound(f"no blob {sha256}") from error
                raise Away(f"cannot {what} now: the object store has no such bucket") from error
            except (BaseError, OSError) as error:
                if self._clock() - began > SILENT_S:
                    self._in_vain = self._clock()
                why = "has no such bucket" if "NoSuchBucket" in str(error) else "does not answer, or refuses"
                raise Away(f"cannot {what} now: the object store {why}") from error
            self._answered = self._clock()
