"""The cut-off that serves the equations best, found by trying."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from exogauge.errors import NotIdentifiable
from exogauge.identification.preparation import suggested_cutoff
from exogauge.logs.model import Log
from exogauge.robots.description import Robot

HALVINGS = 5  # at most: below the positions' own bandwidth by a factor of 32
LOWEST_HZ = 2.0
AS_GOOD = np.log(1.03)  # three per cent of the residual; a lower cut-off lets less noise into the regressor
STOP = np.log(1.15)


def choose_cutoff(robot: Robot, logs: Sequence[Log], unexplained: Callable[[Log, float], float]) -> float:
    """[Hz] the lowest that leaves no more unexplained of the unfiltered measurements than the best does.

    unexplained(log, cutoff_hz): mean over channels of the logarithm of the residual's share of the channel. Tried from
    the cut-off that the spectra suggest downwards, in octaves, on the longest of the logs; elastic vibration and
    current ripple often call for less bandwidth than the sensors could give. Never more than 0.2 of the sampling rate.
    """
    log = max(logs, key=lambda one: one.samples)
    cutoff_hz = suggested_cutoff(robot, logs)
    scores = {cutoff_hz: _score(unexplained, log, cutoff_hz)}
    for _ in range(HALVINGS):
        cutoff_hz /= 2.0
        if cutoff_hz < LOWEST_HZ:
            break
        scores[cutoff_hz] = _score(unexplained, log, cutoff_hz)
        if np.isfinite(min(scores.values())) and scores[cutoff_hz] > min(scores.values()) + STOP:
            break
    return min(hz for hz, score in scores.items() if score <= min(scores.values()) + AS_GOOD)


def _score(unexplained: Callable[[Log, float], float], log: Log, cutoff_hz: float) -> float:
    """inf where so low a bandwidth leaves no steady motion to identify from."""
    try:
        return unexplained(log, cutoff_hz)
    except NotIdentifiable:
        return np.inf
