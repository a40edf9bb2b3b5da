"""Blocks that are long against the memory of the residual."""

import numpy as np
import pytest
from scipy.signal import lfilter

from exogauge.identification.uncertainty import block_length


def test_blocks_grow_with_the_memory_of_the_residual():
    rng = np.random.default_rng(0)
    white = rng.normal(size=(40_000, 6))
    lengths = [block_length(lfilter([1.0], [1.0, -a], white, axis=0), 10.0) for a in (0.0, 0.8, 0.95, 0.98)]
    assert lengths == sorted(lengths)
    for a, length in zip((0.8, 0.95, 0.98), lengths[1:], strict=True):
        assert length == pytest.approx(8.0 * (1 + a) / (1 - a), rel=0.25)  # 8 integral correlation times


def test_blocks_are_half_a_second_at_least_and_twelve_at_least():
    rng = np.random.default_rng(0)
    assert block_length(rng.normal(size=(10_000, 3)), 200.0) == 100
    assert block_length(np.cumsum(rng.normal(size=(1200, 3)), axis=0), 10.0) <= 100
