"""Power spectra by Welch's method, and correlations by way of them: what SciPy's `signal` gives, to rounding, without
the half second that it takes to load.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.special import i0

Array = NDArray[np.float64]
Window = Literal["blackmanharris", "kaiser24"]


def welch(values: Array, rate_hz: float, window: Window, length: int) -> tuple[Array, Array]:
    """(F,) frequencies [Hz] and (K, F) power density [unit²/Hz] of channels (K, T), one-sided: mean of segments of
    `length` samples that overlap by half, each without its mean."""
    w = _window(window, length)
    segments = np.lib.stride_tricks.sliding_window_view(values, length, axis=-1)[..., :: length - length // 2, :]
    wave = rfft((segments - segments.mean(axis=-1, keepdims=True)) * w)
    power = np.mean(wave.real**2 + wave.imag**2, axis=-2) / (rate_hz * np.sum(w**2))
    power[..., 1 : None if length % 2 else -1] *= 2.0
    return np.asarray(rfftfreq(length, 1.0 / rate_hz)), np.asarray(power)


def correlations(one: Array, other: Array) -> Array:
    """(K, N + M - 1) sums over n of one[n + lag] other[n], for channels (K, N) and (K, M); lags from 1 - M on."""
    full = one.shape[-1] + other.shape[-1] - 1
    size = next_fast_len(full, real=True)
    return np.asarray(irfft(rfft(one, size) * rfft(other[..., ::-1], size), size)[..., :full])


@lru_cache(maxsize=16)
def _window(window: Window, length: int) -> Array:
    """(length,) as one period of it."""
    harris = (0.35875, -0.48829, 0.14128, -0.01168)  # of cosines
    beta = 24.0
    turn = 2.0 * np.pi * np.arange(length) / length
    if window == "blackmanharris":
        return np.asarray(np.sum([share * np.cos(k * turn) for k, share in enumerate(harris)], axis=0))
    return np.asarray(i0(beta * np.sqrt(1.0 - (2.0 * np.arange(length) / length - 1.0) ** 2)) / i0(beta))
