"""Butterworth low-passes as second-order sections, as SciPy designs them: of an even order, to the last bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def poles_of(order: int, cutoff_hz: float, rate_hz: float) -> tuple[NDArray[np.complex128], float]:
    """(order,) poles, and the gain before as many zeros at -1: the bilinear image of poles on a circle."""
    fast = 4.0  # twice the rate, in units in which half the rate is 1
    warped = fast * np.tan(np.pi * (2.0 * cutoff_hz / rate_hz) / 2.0)
    circle = warped * -np.exp(1j * np.pi * np.arange(-order + 1, order, 2) / (2 * order))
    gain = warped**order * np.real(1.0 / np.prod(fast - circle))
    return (fast + circle) / (fast - circle), float(gain)


def sections_of(order: int, cutoff_hz: float, rate_hz: float) -> Array:
    """(S, 6) b_0, b_1, b_2, 1, a_1, a_2 of each section, those nearest the unit circle last."""
    poles, gain = poles_of(order, cutoff_hz, rate_hz)
    upper = poles[poles.imag > 1e-14 * np.abs(poles)]
    sections = [(abs(p), [1.0, 2.0, 1.0, 1.0, -2.0 * p.real, (p * p.conjugate()).real]) for p in upper]
    if order % 2:
        alone = float(poles[order // 2].real)
        sections.append((abs(alone), [1.0, 1.0, 0.0, 1.0, -alone, 0.0]))
    sections.sort(key=lambda each: each[0])
    found = np.array([each for _, each in sections])
    found[0, :3] *= gain
    return found


def steady_states(sections: Array) -> Array:
    """(S, 2) the state in which each section leaves a constant 1, as those before it pass it on, as it is."""
    found, scale = np.empty((len(sections), 2)), 1.0
    for k, (b_0, b_1, b_2, _, a_1, a_2) in enumerate(sections.tolist()):
        given = np.array([b_1 - a_1 * b_0, b_2 - a_2 * b_0])
        found[k] = scale * np.linalg.solve(np.array([[1.0 + a_1, -1.0], [a_2, 1.0]]), given)
        scale *= ((b_0 + b_1) + b_2) / ((1.0 + a_1) + a_2)
    return found
