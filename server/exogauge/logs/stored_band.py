"""Where a channel's spectrum ends, if it ends: what was low-passed before it was stored holds no noise either."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from exogauge.logs.model import Log

Array = NDArray[np.float64]

EFFORTS = ("i.", "tau.")  # channels that a motor's noise and a joint's reversals keep busy at every frequency
SEGMENT_S = 8.0  # per spectrum
SHORTEST = 512  # samples: below, a spectrum shows no edge
RESOLVED = 5.0  # bins of the spectrum: what lies below is the window's own width
OCTAVES = 1.5  # over which a fall is seen
FALL_DB = 50.0  # in those; friction that turns round falls by 9, as it builds up over a short way by 27 at most
BIN = 1.15  # half width, as a factor, of what one level is the median of
HIGHEST = 0.1  # of the sampling rate: an edge above is the anti-aliasing that every log should have
ROUND_OFF = 1e-9  # relative; a channel that varies less does not vary
SHARE = 0.5  # of a log's varying efforts that must end alike
ALIKE = 2.0  # ratio of their edges


@final
@dataclass(frozen=True)
class Edge:
    """hz: where the steepest fall begins. fall_db: over the octave and a half above it."""

    hz: float
    fall_db: float


def stored_edge(log: Log) -> Edge | None:
    """Median edge of the efforts of a log; None unless at least half of those that vary end, and alike.

    A log made without noise ends as well: what is seen is that nothing is there, not why.
    """
    efforts = [values for name, values in log.channels.items() if name.startswith(EFFORTS) and _varies(values)]
    edges = [edge for edge in (_edge(values, log.rate_hz) for values in efforts) if edge]
    if not edges or len(edges) < SHARE * len(efforts):
        return None
    hz = float(np.median([edge.hz for edge in edges]))
    near = [edge for edge in edges if hz / ALIKE < edge.hz < hz * ALIKE]
    if len(near) < SHARE * len(efforts):
        return None
    return Edge(hz, float(np.median([edge.fall_db for edge in near])))


def _varies(values: Array) -> bool:
    finite = bool(np.isfinite(values).all()) and values.size >= SHORTEST
    return finite and bool(np.ptp(values) > ROUND_OFF * np.max(np.abs(values)))


def _edge(values: Array, rate_hz: float) -> Edge | None:
    """Of one channel (T,): where its spectrum falls by more than any friction's, over an octave and a half."""
    length = min(values.size - 1, round(SEGMENT_S * rate_hz))
    # differences, because a slow sweep would leak over all that is weak
    frequency, power = welch(np.diff(values), rate_hz, "blackmanharris", nperseg=length, detrend="constant")
    lowest, highest = RESOLVED * rate_hz / length, HIGHEST * rate_hz
    if lowest >= highest:
        return None
    gain = (2.0 * np.sin(np.pi * frequency / rate_hz)) ** 2
    level = 10.0 * np.log10(np.maximum(power / np.maximum(gain, 1e-300), 1e-300))
    starts = np.geomspace(lowest, highest, 60)
    falls = _levels(frequency, level, starts) - _levels(frequency, level, starts * 2.0**OCTAVES)
    steepest = int(np.argmax(falls))
    return Edge(float(starts[steepest]), float(falls[steepest])) if falls[steepest] > FALL_DB else None


def _levels(frequency: Array, level: Array, at: Sequence[float] | Array) -> Array:
    """[dB] medians around `at`; of the five nearest bins where fewer are near."""
    found = []
    for centre in at:
        near = (frequency > centre / BIN) & (frequency < centre * BIN)
        nearest = near if near.sum() >= 5 else np.argsort(np.abs(frequency - centre))[:5]
        found.append(np.median(level[nearest]))
    return np.array(found)
