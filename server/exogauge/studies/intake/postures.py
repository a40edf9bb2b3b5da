"""Postures in which a device file is looked at: what a band does over all that its robot can do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

DRAWN = 400
WIDEST_TURN, WIDEST_SLIDE = np.pi, 0.5  # [rad], [m] to either side where a joint has no limits


def drawn_postures(tree: RigidTree, count: int = DRAWN) -> Array:
    """(1 + count, J) [rad or m]: all joints at zero, then drawn evenly within their limits, always the same ones."""
    widest = np.array([WIDEST_SLIDE if joint in tree.sliding else WIDEST_TURN for joint in tree.joints])
    lower = np.where(np.isfinite(tree.lower), tree.lower, -widest)
    upper = np.where(np.isfinite(tree.upper), tree.upper, widest)
    drawn = np.random.default_rng(0).uniform(lower, upper, size=(count, len(tree.joints)))
    return np.vstack([np.zeros(len(tree.joints)), drawn])
