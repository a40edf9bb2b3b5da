"""What a model lacks around the moments at which a joint turns round, over the time since the turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.findings.result import Evidence
from exogauge.identification.result import Prediction

Array = NDArray[np.float64]

WINDOW_S = 0.6  # to both sides of a turn
BINS = 25


def turn_evidence(channel: str, pairs: Sequence[tuple[Prediction, Prediction, Array]]) -> Evidence:
    """Mean residuals counted along the motion after the turn. pairs: (before, after, (T,) sign of the velocity).

    Signs: torque that the joint gets and the model lacks, as in `evidence`.
    """
    at, lacks = [], []
    for before, after, direction in pairs:
        turns = np.flatnonzero(direction[1:] * direction[:-1] < 0.0) + 1
        step = float(np.median(np.diff(before.time)))
        reach = round(WINDOW_S / step)
        residuals = np.stack([each.predicted[channel] - each.measured[channel] for each in (before, after)])
        for turn in turns:
            near = np.arange(max(int(turn) - reach, 0), min(int(turn) + reach + 1, len(direction)))
            at.append((near - turn) * step)
            lacks.append(residuals[:, near] * direction[turn])
    if not at:
        return Evidence("time_since_turn", "s", *([np.zeros(0)] * 5))
    time, (one, other) = np.concatenate(at), np.concatenate(lacks, axis=1)
    place = np.clip(((time + WINDOW_S) / (2.0 * WINDOW_S) * BINS).astype(np.intp), 0, BINS - 1)
    count = np.bincount(place, minlength=BINS)
    full = count > 1

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(place, values, minlength=BINS)[full] / count[full])

    spread = np.sqrt(np.maximum(mean(one**2) - mean(one) ** 2, 0.0) / count[full])
    return Evidence("time_since_turn", "s", mean(time), mean(one), mean(other), spread, mean(one) - mean(other))
