"""Parts of one recording are filtered as one: what lies beside a part is kept with it, and cut off again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.model import Beside, Log

Array = NDArray[np.float64]

STEP = 0.5  # nominal steps by which the clock may be off from one part to the next


def with_beside(log: Log, parts: Sequence[Log]) -> Log:
    """The log with what the parts of its recording that lie right before and after it hold.

    parts: those of its recording that its filters may see, on one clock; in any order, with or without itself.
    """
    line = sorted([log, *(each for each in parts if each is not log)], key=lambda each: float(each.time[0]))
    own = next(k for k, each in enumerate(line) if each is log)
    after = own
    while after + 1 < len(line) and _follows(line[after], line[after + 1]):
        after += 1
    first = own
    while first > 0 and _follows(line[first - 1], line[first]):
        first -= 1
    if first == after:
        return log
    before = {name: _joined(line[first:own], name) for name in log.channels}
    beyond = {name: _joined(line[own + 1 : after + 1], name) for name in log.channels}
    return replace(log, beside=Beside(before, beyond))


def widened(log: Log) -> tuple[Log, slice]:
    """The log with what is beside it as one, and where it lies there; without it as it is."""
    if log.beside is None:
        return log, slice(0, log.samples)
    before, after = log.beside.before, log.beside.after
    channels = {name: np.concatenate([before[name], own, after[name]]) for name, own in log.channels.items()}
    first, step = len(next(iter(before.values()))), 1.0 / log.rate_hz
    samples = len(next(iter(channels.values())))
    earlier = log.time[0] - step * np.arange(first, 0, -1)
    later = log.time[-1] + step * np.arange(1, samples - first - log.samples + 1)
    time = np.concatenate([earlier, log.time, later])
    return replace(log, time=time, channels=channels, beside=None), slice(first, first + log.samples)


def _follows(one: Log, other: Log) -> bool:
    """Whether the other begins one step after the end of the one, at its rate and with its channels."""
    step = 1.0 / one.rate_hz
    late = float(other.time[0] - one.time[-1]) - step
    same_rate = abs(other.rate_hz * step - 1.0) < STEP / max(other.samples, 1)
    return abs(late) < STEP * step and same_rate and other.channels.keys() == one.channels.keys()


def _joined(parts: Sequence[Log], name: str) -> Array:
    return np.concatenate([np.zeros(0), *(each.channels[name] for each in parts)])
