"""What is independent, such as logs, on several processors: threads, as what costs leaves the interpreter alone.

Results come in the order of the items, and whoever adds them up does so in that order: no bit depends on how many
processors there were. Linear algebra keeps to one thread (`blas_threads`). NumPy holds the interpreter through `@`, of
whatever size, and not through `np.dot`: large products of what runs here are the latter.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import ContextVar, copy_context
from itertools import islice
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

CORES = "EXOGAUGE_CORES"  # how many one evaluation may use; those that there are
_inside: ContextVar[bool] = ContextVar("inside", default=False)


def cores() -> int:
    asked = os.environ.get(CORES, "")
    there = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, int(asked)) if asked.isdecimal() else there


def each(function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
    """`map`, of which as many as there are cores run at once, and no more wait than that. Within itself it is `map`.

    The first that fails raises in its turn; those that have not begun are not begun.
    """
    at_once = 1 if _inside.get() else cores()
    if at_once == 1:
        yield from map(function, items)
        return

    def run(item: T) -> R:
        _inside.set(True)
        return function(item)

    waiting = iter(items)
    with ThreadPoolExecutor(at_once) as pool:
        running = list[Future[R]]()
        try:
            for item in islice(waiting, at_once):
                running.append(pool.submit(copy_context().run, run, item))
            while running:
                result = running.pop(0).result()
                for item in islice(waiting, 1):
                    running.append(pool.submit(copy_context().run, run, item))
                yield result
        finally:
            for future in running:
                future.cancel()
