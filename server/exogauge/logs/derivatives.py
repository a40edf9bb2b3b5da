"""Velocities and accelerations from positions: central differences of 6th order, and what they do to noise."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from exogauge.logs.filtering import LowPass

Array = NDArray[np.float64]

WIDTH = 7  # samples per difference; 6th order in the interior


def differentiate(values: Array, rate_hz: float) -> Array:
    """values: (T,) or (T, K), evenly sampled at rate_hz -> their time derivative, same shape.

    Exact for polynomials up to degree 6; 1 % too small at 0.175 x rate, useless near half the rate: low-pass first.
    The first and last three samples use one-sided formulas, which pass far more noise.
    """
    return _difference(values, 1) * rate_hz


def differentiate_twice(values: Array, rate_hz: float) -> Array:
    """values: (T,) or (T, K), evenly sampled at rate_hz -> the second derivative, same shape.

    1 % too small at 0.223 x rate. One formula, because `differentiate` twice would be 1 % too small already
    at 0.155 x rate.
    """
    return _difference(values, 2) * rate_hz**2


def difference_response(fraction: ArrayLike, order: int) -> Array:
    """What the interior formula makes of a unit sine, per (1/rate)^order; fraction: frequency / rate.

    Ideal is (2 pi fraction)^order; order 0 is 1.
    """
    angle = 2.0 * np.pi * np.asarray(fraction, dtype=np.float64)
    if order == 0:
        return np.ones_like(angle)
    offsets = np.arange(WIDTH) - WIDTH // 2
    waves = np.sin(np.multiply.outer(angle, offsets)) if order == 1 else -np.cos(np.multiply.outer(angle, offsets))
    return np.asarray(waves @ _weights(WIDTH, order)[WIDTH // 2])


def derivative_noise_gain(low_pass: LowPass, order: int) -> float:
    """Std of the order-th derivative of low-passed white noise, per unit of its own std.

    order: 0, 1 or 2; unit 1/s^order. Multiply by the std of a sensor to get the std of what a fit sees.
    """
    nyquist = 0.5 * low_pass.rate_hz
    passed = np.linspace(0.0, min(nyquist, 8.0 * low_pass.cutoff_hz), 4001)
    stopped = np.linspace(passed[-1], nyquist, 4001)[1:] if passed[-1] < nyquist else np.empty(0)
    frequency = np.concatenate([passed, stopped])
    amplitude = low_pass.gain(frequency) * difference_response(frequency / low_pass.rate_hz, order)
    return float(np.sqrt(np.trapezoid(amplitude**2, frequency) / nyquist)) * low_pass.rate_hz**order


def _difference(values: Array, order: int) -> Array:
    samples = values.shape[0]
    if samples <= order:
        raise ValueError(f"derivative {order} needs more than {order} samples, the log has {samples}")
    if samples <= WIDTH:
        return np.asarray(_weights(samples, order) @ values)
    weights, half = _weights(WIDTH, order), WIDTH // 2
    derivative = np.zeros(values.shape)
    interior, at_once = derivative[half:-half], 256  # samples: what is worked on stays in the cache
    for start in range(0, len(interior), at_once):
        part = interior[start : start + at_once]
        for offset, weight in enumerate(weights[half], start):
            part += weight * values[offset : offset + len(part)]
    derivative[:half] = weights[:half] @ values[:WIDTH]
    derivative[-half:] = weights[-half:] @ values[-WIDTH:]
    return derivative


@cache
def _weights(points: int, order: int) -> Array:
    """(points, points): row i holds the weights of the order-th derivative at sample i, unit spacing.

    Row i solves sum_j w_j (j - i)^k = k! [k = order] for k < points: exact for polynomials below that degree.
    """
    wanted = np.zeros(points)
    wanted[order] = math.factorial(order)
    rows = [np.linalg.solve(np.vander(np.arange(points) - float(i), increasing=True).T, wanted) for i in range(points)]
    return np.array(rows)
