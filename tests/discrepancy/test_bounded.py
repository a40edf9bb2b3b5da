"""Bounded least squares against the conditions that only its solution meets."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.estimation.least_squares import bounded_least_squares


@pytest.mark.parametrize("seed", range(40))
def test_downhill_leads_only_out_of_the_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 7))
    A = rng.normal(size=(size + 3, size))
    H, g = A.T @ A, 10.0 * rng.normal(size=size)
    low, high = np.where(rng.random(size) < 0.3, -np.inf, -rng.random(size)), rng.random(size)
    high[rng.random(size) < 0.3] = np.inf
    x = bounded_least_squares(H, g, low, high)
    assert np.all(x >= low)
    assert np.all(x <= high)
    uphill, close = H @ x - g, 1e-9 * np.abs(g).max()
    assert np.all(uphill[x > low + 1e-12] <= close)  # what is not at its lower bound gains nothing by falling
    assert np.all(uphill[x < high - 1e-12] >= -close)
