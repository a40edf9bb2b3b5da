"""One low-pass for both sides of the equation: Butterworth, forwards and backwards, then every n-th sample.

The same linear filter on every regressor column and on the measurement leaves the parameters unchanged; a filter
on one side only does not. So there is one `LowPass` per evaluation and everything goes through it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, Literal, final

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from exogauge.errors import BadLog, Fault

Array = NDArray[np.float64]

MANY = 20_000  # values from which loading numba pays, for a process that has not yet


@final
@dataclass(frozen=True)
class StoredPass:
    """The low-pass that all channels of a log have passed before they were stored.

    hz: where one pass leaves 0.71 of an amplitude. order, kind: of one pass. late: it was passed once, as values came
    in, so that all of them are late; else forwards and backwards, afterwards.
    """

    hz: float
    order: int = 4
    late: bool = False
    kind: Literal["butterworth", "bessel"] = "butterworth"

    def apply(self, values: Array, rate_hz: float) -> Array:
        """values: (T,) or (T, K), computed from positions that have passed it -> the same shape.

        What is computed from late positions is as late as these, by the delay of slow motion. So a late pass acts
        that much earlier: the smear of a step begins before it, and what is slow stays where it is.
        """
        return self._passed(values, rate_hz, _stored_sections(self, rate_hz)[3])

    def let_through(self, values: Array, rate_hz: float) -> Array:
        """values: (T,) or (T, K), computed from what went in (`undoing`) -> what came out, when it came out."""
        return self._passed(values, rate_hz, 0.0)

    def _passed(self, values: Array, rate_hz: float, earlier: float) -> Array:
        """earlier: samples."""
        if len(values) < 2:
            return values.copy()
        flat, beyond = values.reshape(len(values), -1), self.settle_samples(rate_hz)
        sections, steady, _, delay = _stored_sections(self, rate_hz)
        line = np.linspace(flat[0], flat[-1], len(flat))
        extended = np.pad(flat - line, ((beyond, beyond), (0, 0)), mode="reflect", reflect_type="odd")
        if self.late:
            passed = scipy.signal.sosfilt(sections, extended, axis=0, zi=steady[:, :, None] * extended[0])[0]
        else:
            (_compiled_both_ways() if _worth_it(extended.size) else both_ways_by_scipy)(sections, steady, extended)
            passed = extended
        line = line + (earlier - delay) * (flat[-1] - flat[0]) / (len(flat) - 1)
        whole, part = int(earlier), earlier % 1.0
        at = np.minimum(beyond + whole + np.arange(len(flat) + 1), len(extended) - 1)
        return np.asarray((line + (1.0 - part) * passed[at[:-1]] + part * passed[at[1:]]).reshape(values.shape))

    def delay_s(self, rate_hz: float) -> float:
        """By which slow motion is late [s]."""
        return _stored_sections(self, rate_hz)[3] / rate_hz

    def half_hz(self, rate_hz: float) -> float:
        """Where half of an amplitude is left in all: much the same for every shape that would do."""
        return self.falls_to(0.5, rate_hz)

    def falls_to(self, share: float, rate_hz: float) -> float:
        """[Hz] where this share of an amplitude is left in all."""
        return _falls_to(self, share, rate_hz)

    def gain(self, frequency_hz: ArrayLike, rate_hz: float) -> Array:
        """What it leaves of an amplitude at each frequency, in all."""
        return np.abs(self.response(frequency_hz, rate_hz))

    def response(self, frequency_hz: ArrayLike, rate_hz: float) -> NDArray[np.complex128]:
        """What it makes of a unit wave at each frequency."""
        _, left = scipy.signal.sosfreqz(_stored_sections(self, rate_hz)[0], np.asarray(frequency_hz), fs=rate_hz)
        return np.asarray(left if self.late else np.abs(left) ** 2 + 0.0j)

    def settle_samples(self, rate_hz: float) -> int:
        """As `LowPass.settle_samples`."""
        return _stored_sections(self, rate_hz)[2]


@lru_cache(maxsize=64)
def _stored_sections(stored: StoredPass, rate_hz: float) -> tuple[Array, Array, int, float]:
    """Second-order sections of one pass, the state in which they leave a constant 1 as it is, samples until they have
    settled, and by how many what is slow comes out late."""
    order, hz = stored.order, stored.hz
    if stored.kind == "bessel":
        designed: Any = scipy.signal.bessel(order, hz, fs=rate_hz, output="zpk", norm="mag")
    else:
        designed = scipy.signal.butter(order, hz, fs=rate_hz, output="zpk")
    zeros, poles, scale = designed
    sections = scipy.signal.zpk2sos(zeros, poles, scale)  # as SciPy's designs do themselves
    late = float(np.sum(poles / (1.0 - poles)).real - np.sum(zeros / (1.0 - zeros)).real) if stored.late else 0.0
    return sections, scipy.signal.sosfilt_zi(sections), _settled_after(poles), late


@lru_cache(maxsize=64)
def _falls_to(stored: StoredPass, share: float, rate_hz: float) -> float:
    frequencies = 20_000  # at which a gain is computed, to be read off
    frequency = np.linspace(0.0, 0.5 * rate_hz, frequencies)
    return float(np.interp(share, stored.gain(frequency, rate_hz)[::-1], frequency[::-1]))


@final
@dataclass(frozen=True)
class LowPass:
    """Zero-phase Butterworth.

    cutoff_hz: where one pass leaves 0.71 of an amplitude and both passes 0.5. rate_hz: of the samples to be filtered.
    order: of one pass; both together fall off with twice that.
    stored: the one before it, None for none: what was measured has passed that before it was stored, so what is
    computed from it must pass both (`Log.stored`).
    """

    cutoff_hz: float
    rate_hz: float
    order: int = 4
    stored: StoredPass | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.cutoff_hz < 0.5 * self.rate_hz:
            raise ValueError(f"a cut-off of {self.cutoff_hz:g} Hz is not between 0 and half of {self.rate_hz:g} Hz")
        if self.order < 1:
            raise ValueError(f"a filter of order {self.order} does not filter")

    def apply(self, values: Array) -> Array:
        """values: (T,) or (T, K), any unit, evenly sampled -> the same shape, C order.

        The line from the first to the last sample is set aside (it passes unchanged) and the rest continued by point
        reflection until a transient is over, however short the log. `settle_samples` at each end still deserve doubt:
        they lean on values that were never measured.
        """
        at_once = 16  # channels: what is worked on stays in the cache
        if self.stored is not None:
            values = self.stored.apply(values, self.rate_hz)
        if not np.isfinite(values).all():
            raise BadLog(_not_finite(values, np.argwhere(~np.isfinite(values))[0]))
        if values.shape[0] < 2:
            return values.copy()
        beyond = self.settle_samples
        flat = values.reshape(len(values), -1)
        filtered = np.empty(flat.shape)
        zero_phase = _zero_phase(values.size) if beyond < len(flat) else zero_phase_by_scipy
        for start in range(0, flat.shape[1], at_once):
            channels = np.ascontiguousarray(flat[:, start : start + at_once], dtype=np.float64)
            zero_phase(*_sections(self), channels, beyond, filtered[:, start : start + at_once])
        return filtered.reshape(values.shape)

    def gain(self, frequency_hz: ArrayLike) -> Array:
        """What both passes leave of an amplitude at each frequency: 1 / (1 + (tan(pi f/r) / tan(pi f_c/r))^2n).

        Without what is left by `stored`.
        """
        angle = np.pi * np.asarray(frequency_hz, dtype=np.float64) / self.rate_hz
        with np.errstate(over="ignore"):
            warped = np.abs(np.tan(angle)) / math.tan(math.pi * self.cutoff_hz / self.rate_hz)
            return np.asarray(1.0 / (1.0 + warped ** (2 * self.order)))

    @property
    def settle_samples(self) -> int:
        """Samples to leave out of a fit at each end: the slowest pole has lost 99 % of its transient by then."""
        return _settle_samples(self)

    def decimation(self, keep_factor: float = 2.5) -> int:
        """Keep every n-th filtered sample; n is the largest that leaves at least keep_factor x cut-off as the rate.

        2.5: what folds back below the cut-off lay above 1.5 x cut-off and has at most 3.8 % of its amplitude left
        (order 4). 2 is as good for a fit (every kept sample is a valid equation, aliased or not) but the kept series
        is then no longer fit to be plotted as a spectrum. Differentiate before decimating, never after.
        """
        return max(1, math.floor(self.rate_hz / (keep_factor * self.cutoff_hz) + 1e-9))


def _zero_phase(size: int) -> Callable[[Array, Array, Array, int, Array], None]:
    return _compiled_zero_phase() if _worth_it(size) else zero_phase_by_scipy


def _worth_it(size: int) -> bool:
    """For little, what is there already: to load compiled passes takes longer; not for little again and again."""
    often = 1000  # times: half a second
    loaded = any(each.cache_info().currsize for each in (_compiled_zero_phase, _compiled_both_ways))
    return loaded or size >= MANY or _sections.cache_info().hits >= often


@cache
def _compiled_zero_phase() -> Callable[[Array, Array, Array, int, Array], None]:
    """To the last bit what SciPy's give, all channels of a sample side by side."""
    from exogauge.loops.passes import zero_phase

    return zero_phase


@cache
def _compiled_both_ways() -> Callable[[Array, Array, Array], None]:
    from exogauge.loops.passes import both_ways

    return both_ways


def zero_phase_by_scipy(sections: Array, steady: Array, values: Array, beyond: int, out: Array) -> None:
    """See `loops.passes.zero_phase`; shorter than `beyond`, values are turned about their ends again and again."""
    line = np.linspace(values[0], values[-1], len(values))
    extended = np.pad(values - line, ((beyond, beyond), (0, 0)), mode="reflect", reflect_type="odd")
    both_ways_by_scipy(sections, steady, extended)
    np.add(line, extended[beyond : beyond + len(values)], out=out)


def both_ways_by_scipy(sections: Array, steady: Array, values: Array) -> None:
    """See `loops.passes.both_ways`."""
    channels = np.ascontiguousarray(values.T)
    for _ in range(2):  # forwards, and again from the other end
        state = steady[:, None, :] * channels[None, :, :1]
        channels = scipy.signal.sosfilt(sections, channels, axis=1, zi=state)[0][:, ::-1]
    values[...] = channels.T


@lru_cache(maxsize=64)
def _sections(low_pass: LowPass) -> tuple[Array, Array]:
    """Second-order sections of one pass, and the state in which they leave a constant 1 as it is."""
    sections = scipy.signal.butter(low_pass.order, low_pass.cutoff_hz, fs=low_pass.rate_hz, output="sos")
    return sections, scipy.signal.sosfilt_zi(sections)


@lru_cache(maxsize=64)
def _settle_samples(low_pass: LowPass) -> int:
    _, poles, _ = scipy.signal.butter(low_pass.order, low_pass.cutoff_hz, fs=low_pass.rate_hz, output="zpk")
    return _settled_after(poles)


def _settled_after(poles: NDArray[np.complex128]) -> int:
    """Samples until the slowest has lost 99 % of its transient."""
    settled = 0.01  # what is left of a filter transient when it counts as gone
    return math.ceil(math.log(settled) / math.log(float(np.max(np.abs(poles)))))


def _not_finite(values: Array, place: Array) -> Fault:
    return Fault(
        detail="a filter would spread this value over the whole channel",
        rule="not_finite",
        advice="cut the log there, or leave the channel out",
        row=int(place[0]) + 1,
        column=str(int(place[1]) + 1) if place.size > 1 else None,
        value=str(values[tuple(place)]),
    )


IntArray = NDArray[np.intp]


def low_passed_at(low_pass: LowPass, channels: Array, samples: IntArray) -> Array:
    """channels: (K, T), one after the other. samples: (n,) -> (n, K) `low_pass.apply(channels.T)[samples]`.

    The same steps in the same order; nothing between the wanted samples is written down.
    """
    from exogauge.loops.passes import both_ways, extended, picked

    lanes = 16  # channels that are filtered side by side: what is worked on stays in the cache
    beyond, length = low_pass.settle_samples, channels.shape[1]
    if low_pass.stored is not None or beyond >= length:
        return low_pass.apply(np.ascontiguousarray(channels.T))[samples]
    out = np.empty((len(samples), len(channels)))
    sections, steady = _sections(low_pass)
    for start in range(0, len(channels), lanes):
        some = channels[start : start + lanes]
        if not start or len(some) < lanes:
            buffer = np.empty((length + 2 * beyond, len(some)))
        extended(some, beyond, buffer)
        both_ways(sections, steady, buffer)
        picked(some, beyond, buffer, samples, out[:, start : start + lanes])
    if not np.isfinite(out).all():
        return low_pass.apply(np.ascontiguousarray(channels.T))[samples]  # says which value is none
    return out
