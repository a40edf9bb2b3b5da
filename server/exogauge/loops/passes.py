"""The passes of a low-pass, compiled: all channels of a sample side by side, where SciPy takes one after the other.

Channels that are filtered side by side: see `logs.decimating`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]


@compiled("f8[:,::1], f8[:,::1], f8[:,::1]")
def both_ways(sections: Array, steady: Array, values: Array) -> None:
    """Filter values (T, K) in place, forwards and then backwards, each time settled at the first sample that it meets.

    sections: (S, 6) second-order sections. steady: (S, 2) their state at a constant 1.
    """
    samples, channels = values.shape
    early, late = np.empty((len(sections), channels)), np.empty((len(sections), channels))
    for way in range(2):
        first = 0 if way == 0 else samples - 1
        for s in range(len(sections)):
            for k in range(channels):
                early[s, k] = steady[s, 0] * values[first, k]
                late[s, k] = steady[s, 1] * values[first, k]
        for n in range(samples):
            row = values[n] if way == 0 else values[samples - 1 - n]
            for s in range(len(sections)):
                b_0, b_1, b_2 = sections[s, 0], sections[s, 1], sections[s, 2]
                a_1, a_2 = sections[s, 4], sections[s, 5]
                for k in range(channels):
                    x = row[k]
                    y = b_0 * x + early[s, k]
                    early[s, k] = b_1 * x - a_1 * y + late[s, k]
                    late[s, k] = b_2 * x - a_2 * y
                    row[k] = y


@compiled(
    "f8[:,::1], f8[:,::1], f8[:,::1], i8, f8[:,::1]",
    "f8[:,::1], f8[:,::1], f8[:,::1], i8, f8[:,:]",
)
def zero_phase(sections: Array, steady: Array, values: Array, beyond: int, out: Array) -> None:
    """out (T, K): the line from the first to the last of values (T, K), as `numpy.linspace` draws it, and the rest,
    turned about both ends (beyond < T samples) and filtered both ways."""
    length, channels = values.shape
    buffer, step = np.empty((length + 2 * beyond, channels)), np.empty(channels)
    for k in range(channels):
        step[k] = (values[length - 1, k] - values[0, k]) / (length - 1)
        buffer[beyond + length - 1, k] = 0.0
    for n in range(length - 1):
        for k in range(channels):
            buffer[beyond + n, k] = values[n, k] - (n * step[k] + values[0, k])
    for n in range(1, beyond + 1):
        for k in range(channels):
            buffer[beyond - n, k] = -buffer[beyond + n, k]
            buffer[beyond + length - 1 + n, k] = -buffer[beyond + length - 1 - n, k]
    both_ways(sections, steady, buffer)
    for n in range(length - 1):
        for k in range(channels):
            out[n, k] = (n * step[k] + values[0, k]) + buffer[beyond + n, k]
    for k in range(channels):
        out[length - 1, k] = values[length - 1, k] + buffer[beyond + length - 1, k]


IntArray = NDArray[np.intp]

TILE = 64  # samples that are turned from one after the other to side by side at once


@compiled(
    "f8[:,::1], i8, f8[:,::1]",
    "f8[:,:], i8, f8[:,::1]",
    "f8[::1,:], i8, f8[:,::1]",
)
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


@compiled(
    "f8[:,::1], i8, f8[:,::1], i8[::1], f8[:,::1]",
    "f8[:,::1], i8, f8[:,::1], i8[::1], f8[:,:]",
    "f8[::1,:], i8, f8[:,::1], i8[::1], f8[:,::1]",
    "f8[:,:], i8, f8[:,::1], i8[::1], f8[:,:]",
)
def picked(channels: Array, beyond: int, buffer: Array, samples: IntArray, out: Array) -> None:
    """out: (n, K) the line and what was filtered, at these samples."""
    count, length = channels.shape
    for k in range(count):
        first = channels[k, 0]
        step = (channels[k, length - 1] - first) / (length - 1)
        for row in range(len(samples)):
            n = samples[row]
            out[row, k] = buffer[beyond + n, k] + (n * step + first)
