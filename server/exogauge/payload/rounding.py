"""What a converter's steps leave: in the mean of a posture, and in what motion says.

Of x = w + noise, what rounding takes off has the Fourier series Σ step / (π k) sin(2π k x / step), up to sign; noise of
std σ leaves exp(-2 (π k σ / step)²) of each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rounded_mean(step: float, noise: float) -> float:
    """Std of the error that rounding to steps leaves in the mean of many samples: all of it where the noise before it,
    of this std, is small against a step; none where it is as large as one."""
    if step == 0.0:
        return 0.0
    return float(np.sqrt(np.sum(_waves(step, noise) ** 2) / 2.0))


def _waves(step: float, noise: float) -> Array:
    """(50,) sizes of what is left of the series."""
    k = np.arange(1, 51)
    return np.asarray(step / (np.pi * k) * np.exp(-2.0 * (np.pi * k * noise / step) ** 2))


@final
@dataclass(frozen=True)
class Rounding:
    """step: (6,) [N, N·m] of the converter, 0 where it is finer than the noise before it, noise: (6,)."""

    step: Array
    noise: Array

    @staticmethod
    def of(step: Array, noise: Array) -> Rounding | None:
        """None where noise hides every step."""
        coarse = step > noise
        return Rounding(np.where(coarse, step, 0.0), noise) if coarse.any() else None

    def spread(self, A: Array, reading: Array) -> Array:
        """(n, n) covariance of Aᵀ of what rounding takes off a reading (T, 6) [N, N·m], wherever the steps lie. A:
        (T, 6, n) in units of what is read. It goes with the motion, as noise does not: where few steps are passed it
        looks like a gain."""
        out = np.zeros((A.shape[2], A.shape[2]))
        for i in np.flatnonzero(self.step):
            for k, size in enumerate(_waves(self.step[i], self.noise[i]), 1):
                if size < 1e-3 * self.step[i]:
                    break
                wave = A[:, i].T @ np.exp(2j * np.pi * k / self.step[i] * reading[:, i])
                out += 0.5 * size**2 * (np.outer(wave.real, wave.real) + np.outer(wave.imag, wave.imag))
        return out
