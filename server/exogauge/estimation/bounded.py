"""Least squares from normal equations, within bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

Array = NDArray[np.float64]


def bounded_least_squares(H: Array, g: Array, low: Array, high: Array) -> Array:
    """(C,) argmin ½ xᵀ H x - gᵀ x with low ≤ x ≤ high. H: (C, C) positive definite."""
    x = np.linalg.solve(H, g)
    if np.all(x >= low) and np.all(x <= high):
        return np.asarray(x)
    if len(x) == 1:
        return np.clip(x, low, high)
    L = np.linalg.cholesky(H)
    found = lsq_linear(L.T, np.linalg.solve(L, g), bounds=(low, high), method="bvls")
    return np.asarray(np.clip(found.x, low, high))
