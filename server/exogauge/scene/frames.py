"""Which moments of a log are shown: evenly spaced, as many as a screen needs and a browser can hold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SMOOTH_HZ = 30.0
MOST_FRAMES = 2700  # 90 s at 30 Hz; a longer log is shown at fewer frames per second


@final
@dataclass(frozen=True)
class Frames:
    """count frames from start to end [s] of the log's own time; frame k is at start + k / fps."""

    start: float
    end: float
    fps: float
    count: int

    @classmethod
    def of(cls, start: float, end: float, samples: int) -> Frames:
        """samples: of the log; no more frames than that."""
        duration = max(end - start, 0.0)
        count = min(math.floor(duration * SMOOTH_HZ) + 1, MOST_FRAMES, max(samples, 1))
        return cls(start, end, (count - 1) / duration if count > 1 else SMOOTH_HZ, count)

    @property
    def times(self) -> Array:
        """(F,) [s]"""
        return self.start + np.arange(self.count) / self.fps

    @property
    def said(self) -> str:
        """How much of the log a frame stands for, in words."""
        return f"{self.fps:.3g} frames per second, each one sample"

    def nearest(self, time: Array) -> NDArray[np.intp]:
        """(F,) the sample at, or nearest to, each frame. time: (T,) [s], rising."""
        after = np.clip(np.searchsorted(time, self.times), 1, max(len(time) - 1, 1))
        if len(time) == 1:
            return np.zeros(self.count, dtype=np.intp)
        earlier = self.times - time[after - 1] <= time[after] - self.times
        return after - earlier
