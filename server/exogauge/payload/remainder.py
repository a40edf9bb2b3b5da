"""What compensation leaves of the wrench where nothing touches: the figures of [Payload] Table III, and per axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.payload.contact import second_zero
from exogauge.payload.sensor_motion import SensorMotion

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Figures:
    """first, mean, std: (2,) of |f| [N] and |τ| [N·m]: at t = 0, over the log. axes: (3, 6) the same of every axis,
    with its sign. rms, most: (6,) root mean square and largest size per axis."""

    first: Array
    mean: Array
    std: Array
    axes: Array
    rms: Array
    most: Array


@final
@dataclass(frozen=True)
class Remainder:
    """In a log without contact, before and after the secondary zero (44): after, where it helps, and helps: the share
    of time in which it does."""

    before: Figures
    after: Figures
    helps: float


def remainder(left: Array, motion: SensorMotion, gravity: Array, criteria: Moving = USUAL) -> Remainder:
    """left: (T, 6) of a log without contact, below the cut-off if there is one. gravity: (3,) [m/s²] in {B}."""
    zeroed, helps = second_zero(motion, left, gravity, criteria)
    return Remainder(figures(left), figures(zeroed[helps]), float(helps.mean()))


def figures(left: Array) -> Figures:
    """left: (T, 6)."""
    norms = np.column_stack([np.linalg.norm(left[:, :3], axis=1), np.linalg.norm(left[:, 3:], axis=1)])
    return Figures(
        norms[0], norms.mean(axis=0), norms.std(axis=0),
        np.array([left[0], left.mean(axis=0), left.std(axis=0)]),
        np.sqrt(np.mean(left**2, axis=0)), np.abs(left).max(axis=0),
    )  # fmt: skip
