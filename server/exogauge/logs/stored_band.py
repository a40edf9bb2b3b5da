"""Where a log's spectra end, if they end: what was low-passed before it was stored took the sensors' noise along.

A steep low-pass leaves an edge in the efforts. A gentle one does not, but it makes noise that is white fall alike in
positions and efforts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.bandwidth import varies
from exogauge.logs.model import Log
from exogauge.logs.noise import medians

Array = NDArray[np.float64]

EFFORTS = ("i.", "tau.")  # channels that a motor's noise and a joint's reversals keep busy at every frequency
POSITIONS = "q."
HELD = 500_000  # values of channels whose spectra are made at once: their segments and powers take 20 MB
NOISE_WINDOW = ("kaiser", 24.0)  # leaks less than 1e-18 of the motion's power, where encoders' noise has 1e-12 of it


@final
@dataclass(frozen=True)
class Edge:
    """hz: where the steepest fall of the efforts begins. fall_db: over the octave and a half above it.

    Not steep: the low-pass begins somewhere below hz. fall_db is what the encoders' noise loses above.
    """

    hz: float
    fall_db: float
    steep: bool = True


def stored_edges(logs: Sequence[Log]) -> dict[str, Edge]:
    """Log -> its edge, of those that end. Where more than half end, a lesser fall will do for the others."""
    spectra = {log.name: _Spectra.of(log) for log in logs}
    own = {name: each.edge(LOGS.fall_db) for name, each in spectra.items()}
    steep = {name for name, edge in own.items() if edge and edge.steep}
    if len(steep) > LOGS.alike_share * len(own):
        own |= {name: each.edge(LOGS.like_others_db) for name, each in spectra.items() if name not in steep}
    return {name: edge for name, edge in own.items() if edge}


def stored_edge(log: Log) -> Edge | None:
    """Median edge of the efforts of a log; None unless at least half of those that vary end, and alike, or unless all
    noise fades.

    A log made without noise ends as well: what is seen is that nothing is there, not why.
    """
    return _Spectra.of(log).edge(LOGS.fall_db)


@final
@dataclass(frozen=True)
class _Spectra:
    """What the spectra of one log show, whatever fall is asked for.

    steepest: per effort that varies, its steepest fall; none where the log is too short or slow for one.
    fading: what one and the same gentle low-pass does to white noise, if the efforts show it.
    """

    efforts: int
    steepest: tuple[Edge, ...]
    fading: Edge | None

    @classmethod
    def of(cls, log: Log) -> _Spectra:
        efforts = _varying(log, EFFORTS)
        return cls(
            len(efforts), _steepest(efforts, log.rate_hz), _fading(_varying(log, POSITIONS), efforts, log.rate_hz)
        )

    def edge(self, fall_db: float) -> Edge | None:
        """fall_db: asked of the efforts."""
        return self._common([each for each in self.steepest if each.fall_db > fall_db]) or self.fading

    def _common(self, edges: Sequence[Edge]) -> Edge | None:
        """What at least half of the efforts agree on."""
        if not edges or len(edges) < LOGS.alike_share * self.efforts:
            return None
        hz = float(np.median([edge.hz for edge in edges]))
        near = [edge for edge in edges if hz / LOGS.alike_edges < edge.hz < hz * LOGS.alike_edges]
        if len(near) < LOGS.alike_share * self.efforts:
            return None
        return Edge(hz, float(np.median([edge.fall_db for edge in near])))


def _varying(log: Log, kinds: str | tuple[str, ...]) -> Array:
    """(K, T)"""
    found = [values for name, values in log.channels.items() if name.startswith(kinds) and _varies(values)]
    return np.array(found).reshape(len(found), log.samples)


def _fading(positions: Array, efforts: Array, rate_hz: float) -> Edge | None:
    """What one and the same gentle low-pass does to white noise, seen in both.

    Efforts fall by no less than positions: friction's turns, which fall by themselves, have passed it as well. Where a
    motion is smooth and its encoders show no noise, positions fall by far more.
    """
    if not len(positions) or not len(efforts):
        return None
    motion = float(np.median(_noise_fall(positions, rate_hz)))
    fading = motion > LOGS.noise_fall_db and motion < float(np.median(_noise_fall(efforts, rate_hz)))
    return Edge(LOGS.noise_low[0] * rate_hz, motion, steep=False) if fading else None


def _noise_fall(values: Array, rate_hz: float) -> Array:
    """(K,) [dB] of channels (K, T), from `noise_low` to `noise_high`."""
    noise_segment_s = 4.0
    length = min(values.shape[1] - 1, round(noise_segment_s * rate_hz))
    frequency, level = _spectra(values, rate_hz, NOISE_WINDOW, length)
    low, high = (
        np.median(level[:, (frequency > a * rate_hz) & (frequency < b * rate_hz)], axis=1)
        for a, b in (LOGS.noise_low, LOGS.noise_high)
    )
    return np.asarray(low - high)


def _varies(values: Array) -> bool:
    finite = bool(np.isfinite(values).all()) and values.size >= LOGS.shortest_spectrum
    return finite and bool(varies(values[:, None])[0])


def _steepest(efforts: Array, rate_hz: float) -> tuple[Edge, ...]:
    """Of each channel (K, T): where its spectrum falls by most over an octave and a half, and by how much."""
    segment_s = 8.0  # per spectrum
    length = min(efforts.shape[1] - 1, round(segment_s * rate_hz))
    lowest, highest = LOGS.resolved * rate_hz / length, LOGS.highest_edge * rate_hz
    if not len(efforts) or lowest >= highest:
        return ()
    frequency, level = _spectra(efforts, rate_hz, "blackmanharris", length)
    starts = np.geomspace(lowest, highest, 60)
    at_start, above = np.split(
        _levels(frequency, level, np.concatenate([starts, starts * 2.0**LOGS.octaves])), 2, axis=1
    )
    falls = at_start - above
    steepest = np.argmax(falls, axis=1)
    return tuple(Edge(float(starts[k]), float(fall[k])) for k, fall in zip(steepest, falls, strict=True))


def _spectra(values: Array, rate_hz: float, window: str | tuple[str, float], length: int) -> tuple[Array, Array]:
    """(F,) frequencies [Hz] and (K, F) power density [dB] of channels (K, T), many at once."""
    together = max(1, HELD // values.shape[1])
    found = []
    for first in range(0, len(values), together):
        # differences, because a slow sweep would leak over all that is weak
        steps = np.diff(values[first : first + together])
        frequency, power = scipy.signal.welch(steps, rate_hz, window, nperseg=length, detrend="constant")
        gain = (2.0 * np.sin(np.pi * frequency / rate_hz)) ** 2
        found.append(10.0 * np.log10(np.maximum(power / np.maximum(gain, 1e-300), 1e-300)))
    return frequency, np.concatenate(found)


def _levels(frequency: Array, level: Array, at: Array) -> Array:
    """(K, len(at)) [dB] medians around `at`; of the five nearest bins where fewer are near. level: (K, F)."""
    found = np.empty((len(level), len(at)))
    first = np.searchsorted(frequency, at / LOGS.level, "right").tolist()
    stop = np.searchsorted(frequency, at * LOGS.level, "left").tolist()
    for place, near in enumerate(map(slice, first, stop)):
        enough = near.stop - near.start >= 5
        found[:, place] = medians(level[:, near if enough else _nearest(frequency, float(at[place]))])
    return found


def _nearest(frequency: Array, centre: float) -> NDArray[np.intp]:
    return np.argsort(np.abs(frequency - centre))[:5]
