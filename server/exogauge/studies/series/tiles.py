"""Minimum and maximum of a series over as many stretches of time as a screen has columns: to draw, not to compute with.

A series is first reduced to blocks of 100 samples, which are kept: a view of the whole then reads nothing, and a
narrow view reads the row groups that it shows.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.studies.series.file import TIME, SeriesFile

Array = NDArray[np.float64]
BLOCK = 100  # samples; row groups are 12 000 long, so none is cut
BLOCKS_PER_TILE = 2  # from which blocks are fine enough
GROUPS_AT_ONCE = 16
KEPT_BYTES = 128 << 20


@final
@dataclass(frozen=True)
class Tiles:
    """t: (N,) [s] first sample of each stretch. low, high: channel -> (N,), NaN where there is no value.

    samples: how many the stretches hold; a stretch of one sample has low = high.
    """

    t: Array
    low: dict[str, Array]
    high: dict[str, Array]
    samples: int


@final
@dataclass
class Blocks:
    """rows: (B+1,) first row of each block, and the end. time: (B,) [s] of it. low, high: channel -> (B,)."""

    rows: NDArray[np.int64]
    time: Array
    low: dict[str, Array] = field(default_factory=dict)
    high: dict[str, Array] = field(default_factory=dict)

    @property
    def nbytes(self) -> int:
        return self.rows.nbytes + self.time.nbytes * (1 + 2 * len(self.low))


@final
class BlockCache:
    """Blocks of the series looked at last, by the hash of their file. Threads share it."""

    def __init__(self, kept_bytes: int = KEPT_BYTES) -> None:
        self._kept_bytes = kept_bytes
        self._kept: OrderedDict[str, Blocks] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: str, make: Callable[[], Blocks]) -> Blocks:
        with self._lock:
            if (kept := self._kept.get(key)) is not None:
                self._kept.move_to_end(key)
                return kept
        made = make()
        with self._lock:
            kept = self._kept.setdefault(key, made)
            while len(self._kept) > 1 and sum(each.nbytes for each in self._kept.values()) > self._kept_bytes:
                self._kept.popitem(last=False)
        return kept

    def __len__(self) -> int:
        return len(self._kept)


def make_blocks(series: SeriesFile) -> Blocks:
    """The blocks of the time alone; channels follow when they are asked for."""
    parts = [
        np.arange(first, stop, BLOCK, dtype=np.int64)
        for first, stop in zip(series.groups[:-1], series.groups[1:], strict=True)
    ]
    rows = np.concatenate([*parts, [series.samples]])
    time = np.concatenate([_at_starts(series, first, stop, rows) for first, stop in _portions(series)] or [np.empty(0)])
    return Blocks(rows, time)


def _at_starts(series: SeriesFile, first: int, stop: int, rows: NDArray[np.int64]) -> Array:
    begin, end = series.groups[first], series.groups[stop]
    here = rows[:-1][(rows[:-1] >= begin) & (rows[:-1] < end)]
    starts: Array = series.read(TIME, first, stop)[here - begin]
    return starts


def _portions(series: SeriesFile) -> list[tuple[int, int]]:
    """Row groups in portions, so that no column need be in memory whole."""
    count = len(series.groups) - 1
    return [(first, min(first + GROUPS_AT_ONCE, count)) for first in range(0, count, GROUPS_AT_ONCE)]


def _add_channel(blocks: Blocks, series: SeriesFile, channel: str) -> None:
    low, high = list[Array](), list[Array]()
    for first, stop in _portions(series):
        begin, end = series.groups[first], series.groups[stop]
        values = series.read(channel, first, stop)
        starts = blocks.rows[:-1][(blocks.rows[:-1] >= begin) & (blocks.rows[:-1] < end)] - begin
        low.append(np.fmin.reduceat(values, starts))
        high.append(np.fmax.reduceat(values, starts))
    blocks.high[channel] = np.concatenate(high)
    blocks.low[channel] = np.concatenate(low)


def tiles(
    series: SeriesFile,
    blocks: Blocks,
    channels: Sequence[str],
    start: float,
    end: float,
    width: int,
) -> Tiles:
    """At most `width` stretches of [start, end] [s] that hold samples, and one sample beyond each end, if there is one.

    Of few samples (up to two per column) each is given. A view wider than twice `width` blocks ends on whole blocks.
    """
    first = max(int(np.searchsorted(blocks.time, start, "left")) - 1, 0)
    stop = int(np.searchsorted(blocks.time, end, "right"))
    if first >= stop:
        return Tiles(np.empty(0), {name: np.empty(0) for name in channels}, {name: np.empty(0) for name in channels}, 0)
    if stop - first >= BLOCKS_PER_TILE * width:
        for name in channels:
            if name not in blocks.low:
                _add_channel(blocks, series, name)
        shown = slice(first, stop)
        low = {name: blocks.low[name][shown] for name in channels}
        high = {name: blocks.high[name][shown] for name in channels}
        return _stretched(blocks.time[shown], low, high, width, int(blocks.rows[stop] - blocks.rows[first]))
    t, values = _samples(series, channels, start, end, int(blocks.rows[first]), int(blocks.rows[stop]))
    if t.size <= 2 * width:
        return Tiles(t, values, values, t.size)
    return _stretched(t, values, values, width, t.size)


def _samples(
    series: SeriesFile, channels: Sequence[str], start: float, end: float, row: int, stop_row: int
) -> tuple[Array, dict[str, Array]]:
    """Every sample of the view, read from the row groups that hold rows `row` … `stop_row` and the one after."""
    count = len(series.groups) - 1
    first = int(np.searchsorted(series.groups, row, "right")) - 1
    stop = min(int(np.searchsorted(series.groups, stop_row, "right")), count)
    read = series.read_all([TIME, *channels], first, stop)
    t = read.pop(TIME)
    inside = slice(
        max(int(np.searchsorted(t, start, "left")) - 1, 0), min(int(np.searchsorted(t, end, "right")) + 1, t.size)
    )
    return t[inside], {name: values[inside] for name, values in read.items()}


def _stretched(t: Array, low: dict[str, Array], high: dict[str, Array], width: int, samples: int) -> Tiles:
    """Stretches of equal duration; one that holds nothing is left out."""
    edges = np.linspace(t[0], t[-1], width + 1)[:-1]
    starts = np.unique(np.searchsorted(t, edges, "left"))
    return Tiles(
        t[starts],
        {name: np.fmin.reduceat(values, starts) for name, values in low.items()},
        {name: np.fmax.reduceat(values, starts) for name, values in high.items()},
        samples,
    )
