"""CPU seconds of rivals, taken in turns so that a busy machine is unfair to nobody."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping


def seconds_of(call: Callable[[], object]) -> Callable[[], float]:
    """The same call, returning its CPU seconds in this process."""

    def timed() -> float:
        start = time.process_time()
        call()
        return time.process_time() - start

    return timed


def in_turns(rivals: Mapping[str, Callable[[], float]], repeats: int) -> dict[str, float]:
    """Median of the CPU seconds that each call returns; each is called once beforehand (compilation, caches)."""
    for call in rivals.values():
        call()
    seconds: dict[str, list[float]] = {name: [] for name in rivals}
    for _ in range(repeats):
        for name, call in rivals.items():
            seconds[name].append(call())
    return {name: statistics.median(values) for name, values in seconds.items()}
