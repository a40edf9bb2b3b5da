"""Moments at which a force at one link explains far more than at other moments of the same logs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from exogauge.criteria.detecting import Touching
from exogauge.detect.contact.rows import LogRows
from exogauge.logs.filtering import LowPass

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Moment:
    """gain: by which a force lowers the weighted square error around `middle` [s of the log's clock]."""

    log: int
    middle: float
    duration: float
    gain: float


def bump(low_pass: LowPass, middle: float, duration: float, power: float, time: Array) -> Array:
    """(n,) at `time`: sin^power over the duration, 0 outside, as the rows see it, low-passed."""
    rate = low_pass.rate_hz
    near = 0.5 * duration + (low_pass.settle_samples + 2) / rate
    fine = middle + np.arange(-int(near * rate) - 1, int(near * rate) + 2) / rate
    phase = (fine - middle) / duration + 0.5
    raw = np.where((phase > 0.0) & (phase < 1.0), np.sin(np.pi * np.clip(phase, 0.0, 1.0)) ** power, 0.0)
    return np.interp(time, fine, low_pass.apply(raw), left=0.0, right=0.0)


def gains(rows: LogRows, columns: Iterable[Array], criteria: Touching) -> tuple[Array, Array]:
    """(n,) gain of the best force, body and duration around each kept sample, and that duration. None near the ends of
    a log that was low-passed before it was stored: there that filter leaned on what nobody logged.

    columns: of `force_columns`.
    """
    best, lasts = np.zeros(len(rows.time)), np.full(len(rows.time), criteria.durations_s[0])
    if len(rows.time) < 3:
        return best, lasts
    step = float(np.median(np.diff(rows.time)))
    kernels = []
    for duration in criteria.durations_s:
        half = int(np.ceil(duration / step)) + 2
        kernels.append(bump(rows.prepared.low_pass, 0.0, duration, 1.0, np.arange(-half, half + 1.0) * step))
    for own in columns:
        touched = np.any(own[:, :, :3] != 0.0, axis=(0, 2))
        C, w, e = own[:, touched, :3], rows.weight[:, touched], rows.e[:, touched]
        square = np.einsum("nki,nk,nkj->nij", C, w, C)
        both = np.einsum("nki,nk,nk->ni", C, w, e)
        for duration, kernel in zip(criteria.durations_s, kernels, strict=True):
            S = correlate1d(square, kernel**2, axis=0, mode="constant") + np.eye(3) / criteria.usual_n**2
            g = correlate1d(both, kernel, axis=0, mode="constant")
            gain = np.einsum("ni,ni->n", g, np.linalg.solve(S, g[:, :, None])[:, :, 0])
            better = gain > best
            best[better], lasts[better] = gain[better], duration
    best[_near_ends(rows, criteria)] = 0.0
    return best, lasts


def _near_ends(rows: LogRows, criteria: Touching) -> NDArray[np.bool_]:
    stored, log = rows.prepared.log.stored, rows.prepared.log
    half = 0.5 * criteria.durations_s[-1]
    ends = 0.0 if stored is None else stored.settle_samples(log.rate_hz) / log.rate_hz + half
    return np.asarray((rows.time < log.time[0] + ends) | (rows.time > log.time[-1] - ends))


def bursts(
    logs: Sequence[LogRows], found: Sequence[tuple[Array, Array]], bar: float, criteria: Touching
) -> tuple[list[Moment], float]:
    """Largest first, and the gain of the next moment that is none. found: of `gains`, log by log. bar: of `level`."""
    peaks = [moment for log, rows in enumerate(logs) for moment in _peaks(log, rows.time, *found[log], criteria)]
    peaks.sort(key=lambda each: -each.gain)
    high = [each for each in peaks if np.sqrt(each.gain) > bar]
    for count in range(min(len(high), criteria.most_bursts), 0, -1):
        left = peaks[count].gain if len(peaks) > count else 0.0
        if np.sqrt(high[count - 1].gain) > criteria.above_next * np.sqrt(left):
            return high[:count], left
    return [], 0.0


def level(times: Sequence[Array], every: Sequence[Array], block_s: float, criteria: Touching) -> float:
    """What the root of the gain reaches by chance: an exponential tail through the usual blocks."""
    tops: list[float] = []
    for time, gain in zip(times, every, strict=True):
        block = np.floor((time - time[0]) / block_s).astype(np.intp) if len(time) else np.zeros(0, np.intp)
        top = np.zeros(int(block[-1]) + 1 if len(block) else 0)
        np.maximum.at(top, block, gain)
        tops += list(np.sqrt(top))
    if len(tops) < 10:
        return float("inf")
    middle, high = np.quantile(tops, [0.5, 0.9])
    return float(middle + (high - middle) * np.log(0.5 * len(tops) / criteria.false_alarm) / np.log(5.0))


def _peaks(log: int, time: Array, gain: Array, duration: Array, criteria: Touching) -> list[Moment]:
    """Moments that are the best within `contact.apart_s`, a few of each log."""
    left, found = gain.copy(), list[Moment]()
    while len(found) <= criteria.most_bursts and left.max(initial=0.0) > 0.0:
        at = int(np.argmax(left))
        found.append(Moment(log, float(time[at]), float(duration[at]), float(left[at])))
        left[np.abs(time - time[at]) < criteria.apart_s] = 0.0
    return found
