"""A number where a joint stands still: what it showed just before and after, within what friction allows.

At rest the data give an interval only, as wide as the friction that holds the joint. A passive device pulls alike as
long as nothing moves, so the value of the interval nearest to the line between the last and the next steady motion is
the best guess in it. That is an assumption about the device; the interval is not. Another joint that stretches the
same bands meanwhile takes it away: then only the interval is left to say how far the number can be believed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

NEIGHBOURS = 5  # steady samples on either side whose mean the line goes through


def bridged(torque: Array, steady: BoolArray, half_width: Array) -> Array:
    """(T, D) torque where it moves steadily, the line between such parts within torque ± half_width elsewhere.

    torque: (T, D) [N·m] middle of the interval. A joint that never moves steadily keeps the middle.
    """
    result = torque.copy()
    for joint in range(torque.shape[1]):
        line = between_motions(torque[:, joint], steady[:, joint])
        if line is not None:
            low, high = torque[:, joint] - half_width[:, joint], torque[:, joint] + half_width[:, joint]
            result[:, joint] = np.where(steady[:, joint], torque[:, joint], np.clip(line, low, high))
    return result


def between_motions(torque: Array, steady: BoolArray) -> Array | None:
    """(T,) the torque in steady motion, straight lines between; None where there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(np.int8)))
    if edges.size == 0:
        return None
    at, value = [], []
    for start, stop in edges.reshape(-1, 2):
        near = min(NEIGHBOURS, stop - start)
        at += [start, stop - 1]
        value += [float(np.mean(torque[start : start + near])), float(np.mean(torque[stop - near : stop]))]
    return np.asarray(np.interp(np.arange(len(torque)), at, value))


def doubt_at_rest(torque: Array, steady: BoolArray, half_width: Array, length: Array, acts: BoolArray) -> Array:
    """(T, D) [N·m] standard deviation of what `bridged` gives that comes of rest alone.

    length: (T, W) [m]. acts: (W, D) which band acts on which joint. A band that is longer than on the line between the
    joint's motions pulls as much more as it did in motion: torque per length is that of the joint's steady motion. No
    more than an interval's standard deviation, and that of a joint that never moves.
    """
    shortest_travel = 1e-3  # [m] of a band in steady motion, from which its pull per length is taken
    doubt: Array = half_width / np.sqrt(3.0)
    for joint in range(torque.shape[1]):
        used = steady[:, joint] & np.isfinite(torque[:, joint])
        if not used.any():
            continue
        more = np.zeros(len(torque))
        for band in np.flatnonzero(acts[:, joint]):
            line = between_motions(length[:, band], steady[:, joint])
            assert line is not None
            travel = max(float(np.ptp(length[used, band])), shortest_travel)
            more = np.maximum(more, np.abs(length[:, band] - line) / travel)
        pull = float(np.ptp(torque[used, joint]))
        resting = np.where(steady[:, joint], 0.0, more * pull)
        doubt[:, joint] = np.minimum(doubt[:, joint], resting)
    return doubt


def scatter_at_rest(torque: Array, steady: BoolArray, half_width: Array) -> Array:
    """(D,) [N·m] RMS of the torque about that line where friction holds the joint; NaN where it never moves."""
    scatter = np.full(torque.shape[1], np.nan)
    for joint in range(torque.shape[1]):
        line = between_motions(torque[:, joint], steady[:, joint])
        held = (half_width[:, joint] > 0.5 * np.max(half_width[:, joint], initial=1e-12)) & np.isfinite(
            torque[:, joint]
        )
        if line is not None and held.any():
            scatter[joint] = float(np.sqrt(np.mean((torque[held, joint] - line[held]) ** 2)))
    return scatter
