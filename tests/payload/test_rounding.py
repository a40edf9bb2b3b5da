"""What rounding to steps leaves in a mean, against rounding itself."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.payload.rounding import Rounding, rounded_mean


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


@pytest.mark.parametrize(("size", "noise"), [(0.6, 0.0), (1.3, 0.0), (1.3, 0.2), (6.0, 0.0)])
def test_few_steps_look_like_a_gain_by_as_much_as_is_said(size: float, noise: float) -> None:
    """A sine of some steps, read wherever the steps lie: what least squares say of its size."""
    rng = np.random.default_rng(5)
    time = np.linspace(0.0, 12.0, 4000)
    A = np.column_stack([np.sin(time) + 0.5 * np.sin(2.3 * time), np.ones_like(time)])
    inverse, found = np.linalg.inv(A.T @ A), []
    for place in np.linspace(0.0, 1.0, 200, endpoint=False):
        read = np.round(A @ [size, place] + noise * rng.standard_normal(len(time))) - place
        found.append((inverse @ A.T @ read)[0] - size)
    rounding = Rounding.of(np.array([1.0, *[0.0] * 5]), np.full(6, noise))
    assert rounding is not None
    rows = np.zeros((len(time), 6, 2))
    rows[:, 0] = A
    reading = np.zeros((len(time), 6))
    reading[:, 0] = A @ [size, 0.0]
    said = inverse @ rounding.spread(rows, reading) @ inverse
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(np.sqrt(said[0, 0]), rel=0.1)


def test_steps_finer_than_the_noise_are_none() -> None:
    assert Rounding.of(np.full(6, 0.1), np.full(6, 0.2)) is None
