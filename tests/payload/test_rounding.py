"""What rounding to steps leaves in a mean, against rounding itself."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.payload.prepare import rounded_mean


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.2, 0.3])
def test_the_error_of_a_rounded_mean_is_that_of_rounding(noise: float) -> None:
    rng = np.random.default_rng(4)
    places = np.linspace(0.0, 1.0, 200, endpoint=False)
    samples = places[:, None] + noise * rng.standard_normal((200, 4000))
    errors = (np.round(samples) - samples).mean(axis=1)
    assert rounded_mean(1.0, noise) == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.05)


def test_noise_as_large_as_a_step_hides_it_and_no_steps_leave_nothing() -> None:
    assert rounded_mean(0.5, 0.5) < 1e-8
    assert rounded_mean(0.0, 0.1) == 0.0
