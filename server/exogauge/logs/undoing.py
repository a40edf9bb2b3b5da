"""Positions as they were before a low-pass stored them: when a joint turns round is told by them, not by what is left.

A low-pass moves a turn by as much as the velocity bends there, tens of milliseconds at 2 or 3 Hz. Its regularised
inverse finds that again. Positions bear it better than other channels, for they are smooth.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.derivatives import difference_response
from exogauge.logs.filtering import LowPass, StoredPass
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of

Array = NDArray[np.float64]


class StoredPositions:
    """Of a log, at the bandwidth of `finest`; names: channels."""

    def __init__(self, log: Log, names: Sequence[str], finest: LowPass) -> None:
        self._values, self._finest = log.stack(names), finest

    def before(self, stored: StoredPass | None, late: bool = False) -> Array:
        """(T, names) [rad] what went into this low-pass, each as far as its rounding allows.

        late: not when it went in, but when slow motion came out, as all else that was stored. None: nothing is undone.
        """
        values = self._values
        if stored is not None:
            values = np.column_stack([self._undone(k, stored, late) for k in range(values.shape[1])])
        return self._finest.apply(values)

    def _undone(self, k: int, stored: StoredPass, late: bool) -> Array:
        for least in LOGS.undone:
            if self._rounding[k] * _velocity_noise(stored, self._finest, least) <= LOGS.quiet * self._top[k]:
                return undone(self._values[:, k], stored, self._finest.rate_hz, least, late)
        return self._values[:, k]

    @cached_property
    def _rounding(self) -> list[float]:
        rate_hz = self._finest.rate_hz
        above_hz = LOGS.rounding_above * rate_hz
        return [each.std for each in noise_of(list(self._values.T), rate_hz, above_hz)]

    @cached_property
    def _top(self) -> Array:
        steps = np.abs(np.diff(self._finest.apply(self._values), axis=0))
        return np.asarray(steps.max(axis=0, initial=0.0) * self._finest.rate_hz)


def undone(values: Array, stored: StoredPass, rate_hz: float, least: float, late: bool = False) -> Array:
    """values: (T,) that have passed `stored` -> (T,) those that went in; late: when slow motion came out.

    least: what the low-pass leaves of an amplitude where half of it is given back; where it leaves less, less is.
    """
    beyond = stored.settle_samples(rate_hz)
    line = np.linspace(values[0], values[-1], len(values))
    extended = np.pad(values - line, beyond, mode="reflect", reflect_type="odd")
    if not late and len(values) > 1:
        line = line + (line[1] - line[0]) * rate_hz * stored.delay_s(rate_hz)
    back = np.fft.irfft(np.fft.rfft(extended) * _undoing(stored, len(extended), rate_hz, least, late), len(extended))
    return np.asarray(line + back[beyond : beyond + len(values)])


@lru_cache(maxsize=4)
def _undoing(stored: StoredPass, samples: int, rate_hz: float, least: float, late: bool) -> NDArray[np.complex128]:
    """What undoes it at every frequency of so many samples: the same for all channels of a log."""
    frequency = np.fft.rfftfreq(samples, 1.0 / rate_hz)
    response = stored.response(frequency, rate_hz)
    if late:
        response = response * np.exp(2.0j * np.pi * frequency * stored.delay_s(rate_hz))
    return _inverse(response, least)


def _inverse(response: NDArray[np.complex128], least: float) -> NDArray[np.complex128]:
    return np.asarray((1.0 + least**2) * np.conj(response) / (np.abs(response) ** 2 + least**2))


@lru_cache(maxsize=256)
def _velocity_noise(stored: StoredPass, finest: LowPass, least: float) -> float:
    """[1/s] std of the velocity that undoing makes of white noise, per unit of its std."""
    rate_hz = finest.rate_hz
    frequency = np.linspace(0.0, 0.5 * rate_hz, 2001)
    gain = np.abs(_inverse(stored.response(frequency, rate_hz), least)) * finest.gain(frequency)
    return float(np.sqrt(np.mean((gain * difference_response(frequency / rate_hz, 1)) ** 2))) * rate_hz
