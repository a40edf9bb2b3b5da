"""Channels that are filtered side by side: see `logs.decimating`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

TILE = 64  # samples that are turned from one after the other to side by side at once


@compiled
def extended(channels: Array, beyond: int, buffer: Array) -> None:
    """channels (K, T) side by side into buffer (beyond + T + beyond, K): without the line from the first to the
    last sample, turned about both ends."""
    count, length = channels.shape
    for start in range(0, length, TILE):
        for k in range(count):
            first = channels[k, 0]
            step = (channels[k, length - 1] - first) / (length - 1)
            for n in range(start, min(start + TILE, length)):
                buffer[beyond + n, k] = channels[k, n] - (n * step + first)
    buffer[beyond + length - 1] = 0.0
    for n in range(1, beyond + 1):
        buffer[beyond - n] = -buffer[beyond + n]
        buffer[beyond + length - 1 + n] = -buffer[beyond + length - 1 - n]


@compiled
def picked(channels: Array, beyond: int, buffer: Array, samples: IntArray, out: Array) -> None:
    """out: (n, K) the line and what was filtered, at these samples."""
    count, length = channels.shape
    for k in range(count):
        first = channels[k, 0]
        step = (channels[k, length - 1] - first) / (length - 1)
        for row in range(len(samples)):
            n = samples[row]
            out[row, k] = buffer[beyond + n, k] + (n * step + first)
