"""Filtering for some samples only: the same numbers as all of them, of which some are taken."""

import numpy as np
import pytest

from exogauge.errors import BadLog
from exogauge.logs.filtering import LowPass, StoredPass, low_passed_at


def wandering(channels: int, samples: int) -> np.ndarray:
    return 50.0 + np.cumsum(np.random.default_rng(channels).normal(size=(channels, samples)), axis=1)


@pytest.mark.parametrize("stored", [None, StoredPass(12.0, 2)])
@pytest.mark.parametrize("channels", [1, 16, 35])
def test_it_is_the_low_pass_at_those_samples_to_the_last_bit(channels: int, stored: StoredPass | None) -> None:
    values, low_pass = wandering(channels, 1500), LowPass(6.0, 200.0, stored=stored)
    samples = np.delete(np.arange(40, 1460, 13), slice(20, 31))
    whole = low_pass.apply(np.ascontiguousarray(values.T))
    np.testing.assert_array_equal(low_passed_at(low_pass, values, samples), whole[samples])


def test_of_a_log_shorter_than_the_transient_too() -> None:
    values, low_pass = wandering(5, 30), LowPass(1.0, 200.0)
    assert low_pass.settle_samples > 30
    np.testing.assert_array_equal(low_passed_at(low_pass, values, np.array([3, 17])), low_pass.apply(values.T)[[3, 17]])


def test_a_value_that_is_none_is_named() -> None:
    values = wandering(20, 400)
    values[17, 200] = np.nan
    with pytest.raises(BadLog) as caught:
        low_passed_at(LowPass(6.0, 200.0), values, np.arange(40, 360, 10))
    assert (caught.value.faults[0].row, caught.value.faults[0].column) == (201, "18")
