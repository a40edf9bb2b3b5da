"""How one run of a planned motion differs from the plan: smoothly, in amplitude, in time, or by a constant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.synthetic.random_streams import stream

Array = NDArray[np.float64]

LOWEST_HZ, HIGHEST_HZ, _WAVES = 0.05, 0.4, 5  # of what differs smoothly
_TWO = np.sqrt(2.0)  # two runs differ by this times what one departs from the plan


@final
@dataclass(frozen=True)
class Variation:
    """One run's. smooth, offset: rms [rad] between two runs; amplitude_std: relative; timing: rms [s].

    A translation in metres counts half of an angle in radians. run: the log's name.
    """

    smooth: float
    offset: float
    amplitude_std: float
    timing: float
    seed: int
    run: str

    @property
    def amplitude(self) -> float:
        """Of this run's motion, of the plan's."""
        return 1.0 + self.amplitude_std * float(self._stream("amplitude").standard_normal())

    def profile(self, planned: Array, rate_hz: float) -> Array:
        """(K,) the motion's course, larger or smaller, ahead or behind."""
        if self.timing:
            t = np.arange(len(planned)) / rate_hz
            late = self.timing * _waves(self._stream("timing"), t, 1)[:, 0]
            planned = CubicSpline(t, planned)(np.clip(t - late, t[0], t[-1]))
        return np.asarray(self.amplitude * planned)

    def added(self, knots: int, channels: int, rate_hz: float) -> Array:
        """(K, channels) [rad] what this run does beside the plan."""
        t = np.arange(knots) / rate_hz
        smooth = self.smooth / _TWO * _waves(self._stream("smooth"), t, channels)
        return np.asarray(smooth + self.offset / _TWO * self._stream("offset").standard_normal(channels))

    def _stream(self, what: str) -> np.random.Generator:
        return stream(self.seed, f"run {what} {self.run}")


def _waves(rng: np.random.Generator, t: Array, channels: int) -> Array:
    """(K, channels) sums of slow sines at random phases, of rms 1 over the run."""
    frequency = rng.uniform(LOWEST_HZ, HIGHEST_HZ, (channels, _WAVES))
    phase = rng.uniform(0.0, 2 * np.pi, (channels, _WAVES))
    wave = np.sin(2 * np.pi * t[:, None, None] * frequency + phase).sum(axis=2)
    return np.asarray(wave / np.sqrt(np.mean(np.square(wave), axis=0)))
