"""What lies near marked samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from exogauge.logs.segments import around


@pytest.mark.parametrize("reach", [0, 1, 7, 400])
def test_samples_near_marked_ones_are_those_of_a_dilation(reach: int) -> None:
    marked = np.random.default_rng(reach).random((300, 4)) < 0.01
    marked[:, 3] = False
    assert np.array_equal(around(marked, reach), binary_dilation(marked, np.ones((2 * reach + 1, 1), dtype=bool)))
    assert not around(marked, reach)[:, 3].any()
