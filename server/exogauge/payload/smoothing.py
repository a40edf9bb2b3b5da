"""Position, velocity and acceleration of each channel from its noisy positions: Kalman filter, smoothers, their noise.

State [q, q̇, q̈], white noise as jerk: [Payload] takes a Kalman filter and does not say which.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.loops.jerk_filter import WARM, backward, forward, gains

Array = NDArray[np.float64]
Kind = Literal["smoother", "fixed_lag", "causal"]

LAG_S = 0.1  # of the fixed-lag smoother: at 250 Hz it leaves what the full smoother leaves
RATIOS = (-14.0, 4.0)  # log10 of jerk density x period⁵ / variance: straight lines; noise that is all motion
MEMORY = 8.0  # time constants of the smoother after which nothing of an impulse is left (e⁻⁸)


@final
@dataclass(frozen=True)
class Smoothed:
    """state: (T, J, 3) position, velocity, acceleration. density: (J,) jerk density [rad²/s⁵]. noise: (J, 3, 3) root
    with C = noise noiseᵀ, the covariance of the state's error by the noise of the positions alone.
    edge: samples at either end where the state is worse than that. std: (J,) [rad or m] noise of the positions: as
    stated, or what they show where that is clearly more."""

    state: Array
    density: Array
    noise: Array
    edge: int
    std: Array


def smooth(
    time: Array, positions: Array, std: float, *, density: float | None = None, kind: Kind = "smoother",
    criteria: Moving = USUAL,
) -> Smoothed:  # fmt: skip
    """positions: (T, J) [rad or m] at time (T,) [s], with errors of `std`.

    density: None chooses each channel's by the likelihood of its innovations, which is done for still channels anyway.
    Noise that is more than stated would be taken for motion: where innovations say so, it is taken as found.
    kind: `smoother` uses all samples (Rauch-Tung-Striebel), `fixed_lag` those up to 100 ms later, `causal` none later.
    """
    period = float(np.median(np.diff(time)))
    step = np.concatenate([[1.0], np.diff(time)]) / period
    lag = {"smoother": -1, "fixed_lag": max(round(LAG_S / period), 1), "causal": 0}[kind]
    channels = positions.shape[1]
    state, noise, densities = np.empty((len(time), channels, 3)), np.empty((channels, 3, 3)), np.empty(channels)
    units = period ** -np.arange(3.0)
    edge, stds = 0, np.full(channels, float(std))
    for j in range(channels):
        from_first = positions[:, j] - positions[0, j]
        moves = float(np.ptp(from_first)) >= criteria.still_noises * std
        if moves:
            stds[j] = shown_std(from_first, step, std, criteria)
        z = from_first / stds[j]
        ratio = density * period**5 / stds[j] ** 2 if density is not None and moves else likeliest(z, step)
        states = _pass(z, step, ratio, lag) * stds[j] * units
        state[:, j] = states
        state[:, j, 0] += positions[0, j]
        densities[j] = ratio * stds[j] ** 2 / period**5
        noise[j] = error_root(ratio, lag) * stds[j] * units[:, None]
        edge = max(edge, min(memory(ratio), len(time) // 4) if moves else 0)
    return Smoothed(state, densities, noise, edge, stds)


def at_times(smoothed: Smoothed, time: Array, at: Array) -> Smoothed:
    """The same at (n,) times within the samples that are known: positions and velocities by cubics through both and
    their slopes, accelerations by straight lines, whose errors are no larger than those of the samples.
    time: (T,) of the samples."""
    return replace(smoothed, state=states_at(smoothed.state, time, at), edge=0)


def states_at(states: Array, time: Array, at: Array) -> Array:
    """(n, J, 3) of states (T, J, 3) at time (T,), as above."""
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    h = (time[k + 1] - time[k])[:, None]
    s = (at - time[k])[:, None] / h
    first, last = states[k], states[k + 1]
    state = np.empty((len(at), *states.shape[1:]))
    for order in (0, 1):
        a, b, slope_a, slope_b = (each[:, :, order + up] for up in (0, 1) for each in (first, last))
        state[:, :, order] = (
            (1 + 2 * s) * (1 - s) ** 2 * a + s**2 * (3 - 2 * s) * b
            + h * s * (1 - s) * ((1 - s) * slope_a - s * slope_b)
        )  # fmt: skip
    state[:, :, 2] = (1 - s) * first[:, :, 2] + s * last[:, :, 2]
    return state


def likeliest(z: Array, step: Array) -> float:
    """Density in units of variance and period, by the likelihood of the innovations. z: (T,) in units of its noise."""
    x, P = np.empty((len(z), 3)), np.empty((len(z), 3, 3))

    def cost(exponent: float) -> float:
        logs, squares = forward(z, step, 10.0**exponent, x, P)
        return logs + squares

    found = scipy.optimize.minimize_scalar(cost, bounds=RATIOS, method="bounded", options={"xatol": 0.02})
    return float(10.0**found.x)


def shown_std(positions: Array, step: Array, stated: float, criteria: Moving = USUAL) -> float:
    """Noise of positions (T,) that move, in their unit: as stated, or where their innovations say clearly more, what
    these say, its size and the density chosen together. step: (T,) in periods."""
    z = np.ascontiguousarray(positions / stated)
    x, P = np.empty((len(z), 3)), np.empty((len(z), 3, 3))
    count = max(len(z) - WARM, 1)

    def cost(exponent: float) -> float:
        logs, squares = forward(z, step, 10.0**exponent, x, P)
        return float(logs + count * np.log(max(squares, 1e-300) / count))

    found = scipy.optimize.minimize_scalar(cost, bounds=RATIOS, method="bounded", options={"xatol": 0.02})
    shown = float(np.sqrt(innovation_variance(z, step, 10.0**found.x)))
    return stated * shown if shown > criteria.noisier else stated


def innovation_variance(z: Array, step: Array, ratio: float) -> float:
    """Mean of ν²/s: 1 where the stated noise is right. z: (T,) in units of its noise."""
    x, P = np.empty((len(z), 3)), np.empty((len(z), 3, 3))
    return forward(z, step, ratio, x, P)[1] / max(len(z) - WARM, 1)


def impulse_responses(ratio: float, lag: int) -> Array:
    """(N, 3) what the settled filter makes of a unit error in one sample, in periods."""
    half = memory(ratio)
    z = np.zeros(4 * half + 1)
    z[2 * half] = 1.0
    return _pass(z, np.ones(len(z)), ratio, lag)


def error_root(ratio: float, lag: int) -> Array:
    """(3, 3) root of the covariance of the state's error by the noise of the positions alone, in periods."""
    h = impulse_responses(ratio, lag)
    return _root(h.T @ h)


def _pass(z: Array, step: Array, ratio: float, lag: int) -> Array:
    x, P = np.empty((len(z), 3)), np.empty((len(z), 3, 3))
    forward(z, step, ratio, x, P)
    if lag == 0:
        return x
    C, out = np.empty((len(z) - 1, 3, 3)), np.empty_like(x)
    gains(step, ratio, P, C)
    backward(step, x, C, lag, out)
    return out


def memory(ratio: float) -> int:
    """Samples after which an impulse is forgotten: the poles lie at ratio^(1/6) per period."""
    return int(np.clip(MEMORY / ratio ** (1 / 6), 20, 5000))


def _root(C: Array) -> Array:
    """Lower triangular root of a covariance that may be singular in its last digits."""
    scale = np.sqrt(np.diag(C))
    value, vectors = np.linalg.eigh(C / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(value, 0.0)))
