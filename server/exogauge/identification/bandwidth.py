"""The cut-off that serves the equations best, found by trying."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from exogauge.identification.preparation import suggested_cutoff
from exogauge.logs.model import Log
from exogauge.robots.description import Robot

HALVINGS = 5  # at most: below the positions' own bandwidth by a factor of 32
LOWEST_HZ = 2.0


def choose_cutoff(robot: Robot, logs: Sequence[Log], unexplained: Callable[[Log, float], float]) -> float:
    """[Hz] where what a model leaves unexplained of the unfiltered measurements is smallest.

    unexplained(log, cutoff_hz): mean over channels of the logarithm of the residual's share of the channel. Tried from
    the cut-off that the spectra suggest downwards, in octaves, on the longest of the logs; elastic vibration and
    current ripple often call for less bandwidth than the sensors could give. Never more than 0.2 of the sampling rate.
    """
    log = max(logs, key=lambda one: one.samples)
    best_hz = cutoff_hz = suggested_cutoff(robot, logs)
    best = unexplained(log, cutoff_hz)
    for _ in range(HALVINGS):
        cutoff_hz /= 2.0
        if cutoff_hz < LOWEST_HZ:
            break
        score = unexplained(log, cutoff_hz)
        if score < best:
            best_hz, best = cutoff_hz, score
        elif score > best + np.log(1.05):
            break
    return best_hz
