"""Where to cut: the frequency above which differentiating yields more noise than motion."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.logs.derivatives import difference_response, differentiate
from exogauge.logs.filtering import LowPass

Array = NDArray[np.float64]

SEGMENT_S = 8.0  # per spectrum: resolves 0.5 Hz


def suggest_cutoff(values: Array, rate_hz: float, order: int = 2) -> float:
    """values: (T, K), evenly sampled -> cut-off [Hz] of an order-4 `LowPass`.

    order: of the derivative that is wanted, 2 for positions, 1 for angular velocities.

    Per joint, the cut-off with the least expected error of that derivative,
        E(f_c) = sum_f (2 pi f)^(2 order) [ (1 - G)^2 S_motion + G^2 S_noise ],
    S_noise: the white floor seen at 0.3-0.45 x rate; S_motion: the spectrum less the floor where it stands out of it.
    Then the upper quartile over the joints that move (a few slow ones must not blur a fast one), between 1 Hz and
    0.2 x rate. A joint that moves less than it is noisy has no say; if none moves the answer is 1 Hz. What was
    low-passed before it was stored shows too low a floor and so gets too high a cut-off: bounded, but look at the
    spectrum.
    """
    fastest = LOGS.fastest * rate_hz
    slowest = min(LOGS.slowest_hz, fastest)
    if values.shape[0] < 32:
        return slowest
    frequency, motion, noise = _spectra(values, rate_hz)
    moving = np.flatnonzero(motion.sum(axis=0) > noise * frequency.size)  # more motion than noise, over the whole band
    if moving.size == 0:
        return slowest
    candidates = np.geomspace(slowest, fastest, 80)
    gain = np.array([LowPass(float(cutoff), rate_hz).gain(frequency) for cutoff in candidates])  # (C, F)
    weight = (2.0 * np.pi * frequency)[:, None] ** (2 * order)
    error = (1.0 - gain) ** 2 @ (weight * motion[:, moving]) + gain**2 @ (weight * noise[moving])
    return float(np.quantile(candidates[np.argmin(error, axis=0)], LOGS.fast_joints))


def varies(values: Array) -> NDArray[np.bool_]:
    """values: (T, K) -> (K,) whether each does more than round."""
    return np.asarray(np.ptp(values, axis=0) > LOGS.round_off * np.max(np.abs(values), axis=0))


def _spectra(values: Array, rate_hz: float) -> tuple[Array, Array, Array]:
    """frequency (F,), motion (F, K) and noise floor (K,): power spectra of position [unit^2/Hz].

    Taken from the velocity with a Blackman-Harris window: a position's slow sweep is 100 dB above its noise and
    would leak over all of it.
    """
    velocity = differentiate(values, rate_hz)[3:-3]
    length = min(velocity.shape[0], round(SEGMENT_S * rate_hz))
    frequency, power = scipy.signal.welch(
        velocity, rate_hz, "blackmanharris", nperseg=length, detrend="constant", axis=0
    )
    response = difference_response(frequency / rate_hz, 1) * rate_hz
    kept = (frequency > 0.0) & (frequency < LOGS.floor_band[1] * rate_hz)
    frequency, spectrum = frequency[kept], power[kept] / response[kept, None] ** 2
    freedom = 2.0 * max(1, 2 * velocity.shape[0] // length - 1)  # neighbours overlap by half and are nearly independent
    in_floor = frequency > LOGS.floor_band[0] * rate_hz
    half = 0.5 * freedom  # chi square of so many degrees: its median, and what noise exceeds so seldom
    noise = np.median(spectrum[in_floor], axis=0) / (scipy.special.gammaincinv(half, 0.5) / half)
    stands_out = scipy.special.gammainccinv(half, LOGS.false_alarm / frequency.size) / half
    motion = np.where(varies(values) & (spectrum > stands_out * noise), spectrum - noise, 0.0)
    return frequency, motion, noise
