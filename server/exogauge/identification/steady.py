"""How much of what each axis moves is steady motion, which alone gives rows to fit and errors to judge by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.preparation import Prepared

Array = NDArray[np.float64]

HARDLY = 0.01  # of a log in one direction: an axis that moves for less has no say in it
ENOUGH = 0.25  # of what a joint moves, in steady motion: below, the reader is warned


@final
@dataclass(frozen=True)
class SteadyMotion:
    """One actuator axis over some logs [s]: how long it moves and how long steadily, (2,) each, in its negative and
    its positive direction."""

    joint: str
    moving_s: Array
    steady_s: Array

    @property
    def share(self) -> float:
        """Of its motion that is steady; 1 of an axis that never moves."""
        return float(self.steady_s.sum() / self.moving_s.sum()) if self.moving_s.sum() > 0.0 else 1.0

    @property
    def one_way(self) -> bool:
        """It moves in both directions, steadily in one only: Coulomb friction and offset look alike."""
        return bool((self.moving_s > 0.0).all() and (self.steady_s > 0.0).sum() == 1)


def steady_motion(joints: Sequence[str], logs: Sequence[Prepared]) -> tuple[SteadyMotion, ...]:
    """Of every axis over all logs together."""
    seconds = np.sum([_counts(log) / log.log.rate_hz for log in logs], axis=0) if logs else np.zeros((2, 2, len(joints)))
    return tuple(SteadyMotion(joint, seconds[0, :, a], seconds[1, :, a]) for a, joint in enumerate(joints))


def smallest_share(log: Prepared) -> float:
    """Of an axis' motion in one direction, what is steady: the least over all that move; 1 where nothing moves."""
    moving, steady = _counts(log)
    counted = moving > HARDLY * log.log.samples
    return float(np.min(steady[counted] / moving[counted])) if counted.any() else 1.0


def _counts(log: Prepared) -> Array:
    """(2, 2, A) samples: moving and of these steady, backwards and forwards. The log's unsettled ends count as moving:
    what is lost there is lost to the fit."""
    signs = np.stack([log.raw_direction < 0.0, log.raw_direction > 0.0])
    steady = log.steady & log.settled[:, None]
    return np.array([signs.sum(axis=1), (signs & steady).sum(axis=1)], dtype=np.float64)
