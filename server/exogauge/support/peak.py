"""The peak of a motion without the bias of a maximum: where it lies is read from other data than how large it is.

The largest of many noisy samples is too large. Repetitions tell where the peak is, each time without the one that is
read; of a single run the band model tells. Only where there is neither, or where the run is larger elsewhere than the
largest of as many means by chance, the run tells itself. A twist goes both ways,
hardly further to one side than to the other: all runs are read on the side on which they are larger together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

FULL = 0.5  # share of a mean's samples that have to be there


Moments = Mapping[int, tuple[NDArray[np.intp], BoolArray]]
"""Another run -> its sample of the same posture at each of a run's samples, and whether it has that moment: (T_k,)."""


def same_moments(times: Sequence[Array], shifts: Sequence[float]) -> list[Moments]:
    """Of every run. times: (T_k,) [s] from each start. shifts: [s] time in run k minus time in the first, at the same
    posture."""

    def of(wanted: Array, time: Array) -> tuple[NDArray[np.intp], BoolArray]:
        nearest = np.clip(np.round(np.interp(wanted, time, np.arange(len(time)))).astype(np.intp), 0, len(time) - 1)
        return nearest, (wanted >= time[0]) & (wanted <= time[-1])

    return [
        {j: of(own - shifts[k] + shifts[j], time) for j, time in enumerate(times) if j != k}
        for k, own in enumerate(times)
    ]


def peak_places(
    times: Sequence[Array],
    moments: Sequence[Moments],
    lines: Sequence[Array],
    models: Sequence[Array | None],
    used: Sequence[BoolArray],
    seconds: float,
    noise: Sequence[Array] | None = None,
) -> list[tuple[int, float] | None]:
    """Of every run its sample of the peak and the mean there, None where nothing is used; K runs of one motion.

    times: (T_k,) [s] from each start. moments: of every run, by `same_moments`. lines, models: (T_k,) [N·m]. used:
    (T_k,). seconds: that a mean lasts. noise: (T_k,) [N·m] of such a mean; without, what the model tells counts.
    """
    smooth = [_smooth(t, line, own, seconds) for t, line, own in zip(times, lines, used, strict=True)]
    tells = list[Array | None]()
    for k, (time, own) in enumerate(zip(times, smooth, strict=True)):
        others = [np.where(there, smooth[j][nearest], np.nan) for j, (nearest, there) in moments[k].items()]
        model = models[k]
        where = _mean(others) if others else own if model is None else _smooth(time, model, used[k], seconds)
        both = np.where(np.isfinite(own), where, np.nan)
        both = both if np.isfinite(both).any() else own
        tells.append(both if np.isfinite(both).any() else None)
    known = [each for each in tells if each is not None]
    side = 1.0 if sum(float(np.nanmax(each) + np.nanmin(each)) for each in known) >= 0.0 else -1.0
    places: list[tuple[int, float] | None] = []
    for each, own in zip(tells, smooth, strict=True):
        top = None if each is None else int(np.nanargmax(side * each))
        if top is not None and noise is not None and len(times) == 1:
            top = _unless_refuted(top, side, own, noise[0], float(times[0][-1] - times[0][0]) / seconds)
        places.append(None if top is None else (top, float(own[top])))
    return places


def _unless_refuted(top: int, side: float, own: Array, noise: Array, means: float) -> int:
    """Or where a run is surely larger than there: √(2 ln n) deviations are the largest of n means by chance."""
    known = np.isfinite(own)
    largest = int(np.argmax(np.where(known, np.abs(own), -np.inf)))
    apart = np.abs(own[largest]) - side * own[top]
    chance = np.sqrt(2.0 * np.log(max(float(np.mean(known)) * means, 2.0))) * np.hypot(noise[largest], noise[top])
    return largest if apart > chance else top


def _smooth(time: Array, line: Array, used: BoolArray, seconds: float) -> Array:
    """(T,) mean over what is used about each used sample; NaN elsewhere."""
    counts = used & np.isfinite(line)
    width = max(1, round(seconds * (len(time) - 1) / max(float(time[-1] - time[0]), 1e-9)))
    share = scipy.ndimage.uniform_filter1d(counts.astype(np.float64), width, mode="nearest")
    total = scipy.ndimage.uniform_filter1d(np.where(counts, line, 0.0), width, mode="nearest")
    whole = counts & (share >= min(FULL, float(share.max(initial=0.0))))
    return np.where(whole, total / np.maximum(share, 1e-12), np.nan)


def _mean(lines: Sequence[Array]) -> Array:
    stack = np.array(lines)
    known = np.isfinite(stack)
    count = known.sum(axis=0)
    total = np.sum(np.where(known, stack, 0.0), axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
