"""How much of a channel is noise: its high-frequency part, and the steps of its converter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.filtering import LowPass, StoredPass

Array = NDArray[np.float64]

MAD_TO_STD = 1.4826  # of a Gaussian


def white_noise_std(values: Array, rate_hz: float, above_hz: float) -> float:
    """Std of the white noise in values (T,), in their unit, over the whole band from 0 to rate_hz / 2.

    Takes what lies above above_hz (choose it above all motion), the median absolute deviation of each short segment
    and the median of those, so that impacts and half a log of standing still do no harm; then scales up by the part
    of a white spectrum that lies there. Never less than step / sqrt(12), what rounding alone costs a moving channel.
    """
    return noise_of([values], rate_hz, above_hz)[0].std


@final
@dataclass(frozen=True)
class ChannelNoise:
    """std: as `white_noise_std`. step: as `quantisation_step`."""

    std: float
    step: float | None


def noise_of(channels: Sequence[Array], rate_hz: float, above_hz: float) -> list[ChannelNoise]:
    """Of each of many channels (T,)."""
    segment = 200  # samples per robust estimate
    at_once = 16  # channels
    low_pass, found = LowPass(above_hz, rate_hz), list[ChannelNoise]()
    for first in range(0, len(channels), at_once):
        some = channels[first : first + at_once]
        values = np.column_stack(some)
        rest = np.ascontiguousarray((values - low_pass.apply(values)).T)
        spreads = medians(_spreads(rest, max(1, rest.shape[1] // segment))) / _seen_share(low_pass)
        for spread, each in zip(spreads.tolist(), some, strict=True):
            step = quantisation_step(each)
            found.append(ChannelNoise(max(spread, step / math.sqrt(12.0) if step else 0.0), step))
    return found


def noise_before_stored(
    values: Array, rate_hz: float, stored: StoredPass, without_jumps: NDArray[np.bool_]
) -> float | None:
    """Std of the white noise that was in values (T,) before they passed `stored`, from what lies beyond its band.

    None where rounding hides it, or where something jumps all the time: a jump, of friction say, leaves more there than
    noise does. Of several frequencies what says least, for motion reaches the first. without_jumps: (T,)
    """
    if np.count_nonzero(without_jumps) < LOGS.least_s * rate_hz:
        return None
    step = quantisation_step(values)
    rounding = step / math.sqrt(12.0) if step else 0.0
    found = []
    for share in LOGS.fallen:
        low_pass = LowPass(min(stored.falls_to(share, rate_hz), 0.4 * rate_hz), rate_hz)
        rest = (values - low_pass.apply(values))[without_jumps]
        spread = MAD_TO_STD * float(np.median(np.abs(rest - np.median(rest))))
        if spread > LOGS.rounded * rounding * _seen_share(low_pass):
            found.append(spread / _seen_share(low_pass, stored))
    return min(found, default=None)


def quantisation_step(values: Array) -> float | None:
    """The spacing of the lattice on which all values (T,) lie, in their unit; None where there is none to be seen.

    Decimals of a text file are a lattice too: they limit the log just as a converter does.
    """
    many = 50_000  # values show a lattice as well as all do, and sort faster
    values = np.sort(values[:: 1 + values.size // many])
    if values.size == 0:
        return None
    largest = max(abs(values[0]), abs(values[-1]))
    with np.errstate(over="ignore", invalid="ignore"):
        single, apart = np.array_equal(values.astype(np.float32), values), np.diff(values)
    spacing = apart[apart > (1e-6 if single else 1e-11) * largest]
    if not spacing.size or (spacing.size < LOGS.few_levels and values.size < 4 * (1 + np.count_nonzero(apart))):
        return None
    step = float(medians(spacing[spacing < 1.5 * spacing.min()]))
    multiples = spacing / step
    multiples = multiples[multiples < 100.0]  # further ones sum up the rounding of the representation
    met = np.abs(multiples - np.round(multiples)) < 0.02 * np.maximum(1.0, multiples / 10.0)
    return step if np.count_nonzero(met) > 0.95 * met.size else None


def _spreads(values: Array, segments: int) -> Array:
    """(K, segments) robust std of consecutive stretches of (almost) equal length of values (K, T): the first may be one
    sample longer."""
    K, (length, longer) = len(values), divmod(values.shape[1], segments)
    cut = longer * (length + 1)
    parts = (values[:, :cut].reshape(K, longer, length + 1), values[:, cut:].reshape(K, segments - longer, length))
    centred = (np.abs(part - medians(part)[..., None]) for part in parts if part.size)
    return MAD_TO_STD * np.concatenate([medians(part) for part in centred], axis=1)


def medians(rows: Array) -> Array:
    """(...,) of each row (..., n) of numbers: `numpy.median`, which also looks for NaN."""
    middle = rows.shape[-1] // 2
    if rows.shape[-1] % 2:
        return np.asarray(np.partition(rows, middle, axis=-1)[..., middle])
    near = np.partition(rows, (middle - 1, middle), axis=-1)
    return np.asarray(0.5 * (near[..., middle - 1] + near[..., middle]))


@lru_cache(maxsize=64)
def _seen_share(low_pass: LowPass, stored: StoredPass | None = None) -> float:
    """Of the std of white noise, that has passed `stored`, what the low-pass takes away."""
    frequency = np.linspace(0.0, 0.5 * low_pass.rate_hz, 2001)
    taken = 1.0 - low_pass.gain(frequency)
    if stored is not None:
        taken = taken * stored.gain(frequency, low_pass.rate_hz)
    return math.sqrt(float(np.mean(taken**2)))
