"""Four ways in which laboratories move a robot to identify it: (T,) position, velocity, acceleration in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Wave = tuple[Array, Array, Array]

HARMONICS = 5
FASTEST, QUICKEST = 1.5, 5.0  # of any joint [rad/s, rad/s²]
FADE_S = 2.0  # in and out, so that a motion starts and ends at rest


def fourier(rng: np.random.Generator, time: Array, reach: float) -> Wave:
    """Five harmonics of 0.06 to 0.12 Hz, the periodic excitation of most papers."""
    w = 2.0 * np.pi * rng.uniform(0.06, 0.12) * np.arange(1, HARMONICS + 1)
    a, b = rng.normal(size=(2, HARMONICS)) / np.sqrt(np.arange(1, HARMONICS + 1))
    s, c = np.sin(np.outer(time, w)), np.cos(np.outer(time, w))
    return _within(((s @ a + c @ b), (c @ (a * w) - s @ (b * w)), -(s @ (a * w**2) + c @ (b * w**2))), reach)


def point_to_point(rng: np.random.Generator, time: Array, reach: float) -> Wave:
    """Quintic moves between random postures, with a rest after each."""
    q, dq, ddq = (np.zeros_like(time) for _ in range(3))
    place, start = 0.0, 0.5 + rng.uniform()
    while start < time[-1] - 0.5:
        goal, lasts = rng.uniform(-1.0, 1.0), rng.uniform(1.2, 3.0)
        x = np.clip((time - start) / lasts, 0.0, 1.0)
        step = goal - place
        q += step * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
        dq += step / lasts * 30.0 * x**2 * (1.0 - x) ** 2
        ddq += step / lasts**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
        place, start = goal, start + lasts + rng.uniform(0.3, 1.0)
    return _within((q, dq, ddq), reach)


def chirp(rng: np.random.Generator, time: Array, reach: float) -> Wave:
    """A sweep from 0.1 to between 0.5 and 1 Hz whose amplitude falls as its frequency grows."""
    low, high, T = 0.1, rng.uniform(0.5, 1.0), time[-1]
    rate = np.log(high / low) / T
    w, phase = 2.0 * np.pi * low * np.exp(rate * time), 2.0 * np.pi * low * np.expm1(rate * time) / rate
    phase = phase + rng.uniform(0.0, 2.0 * np.pi)
    amplitude = low / (low + w / (2.0 * np.pi))
    slope = -(amplitude**2) * rate * w / (2.0 * np.pi) / low
    bend = 2.0 * slope**2 / amplitude + slope * rate
    s, c = np.sin(phase), np.cos(phase)
    dq = slope * s + amplitude * w * c
    ddq = bend * s + 2.0 * slope * w * c + amplitude * (rate * w * c - w**2 * s)
    return _within((amplitude * s, dq, ddq), reach)


def sines(rng: np.random.Generator, time: Array, reach: float) -> Wave:
    """Three incommensurate sines between 0.05 and 0.5 Hz that fade in and out."""
    w = 2.0 * np.pi * np.exp(rng.uniform(np.log(0.05), np.log(0.5), 3))
    size, shift = rng.uniform(0.5, 1.0, 3) / w, rng.uniform(0.0, 2.0 * np.pi, 3)
    s, c = np.sin(np.outer(time, w) + shift), np.cos(np.outer(time, w) + shift)
    q, dq, ddq = s @ size, c @ (size * w), -s @ (size * w**2)
    x = np.clip(np.minimum(time, time[-1] - time) / FADE_S, 0.0, 1.0)
    sign = np.where(time < 0.5 * time[-1], 1.0, -1.0) / FADE_S
    g, dg = x**3 * (10.0 - 15.0 * x + 6.0 * x**2), 30.0 * x**2 * (1.0 - x) ** 2 * sign
    ddg = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / FADE_S**2
    return _within((g * q, g * dq + dg * q, g * ddq + 2.0 * dg * dq + ddg * q), reach)


STYLES = {"fourier": fourier, "point_to_point": point_to_point, "chirp": chirp, "sines": sines}


def _within(wave: Wave, reach: float) -> Wave:
    """Scaled to a reach [rad] and to what a robot can do."""
    largest = [float(np.abs(each).max()) for each in wave]
    scale = min(reach / largest[0], FASTEST / largest[1], QUICKEST / largest[2])
    return wave[0] * scale, wave[1] * scale, wave[2] * scale
