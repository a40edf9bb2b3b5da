import math

import numpy as np
import pytest

from exogauge.logs.noise import quantisation_step, white_noise_std

RATE = 200.0


def slow_motion(samples: int) -> np.ndarray:
    time = np.arange(samples) / RATE
    return 0.8 * np.sin(2 * np.pi * 0.4 * time) + 0.2 * np.sin(2 * np.pi * 2.1 * time)


@pytest.mark.parametrize("std", [1e-5, 1e-3, 0.1])
def test_white_noise_is_recovered_under_a_motion_ten_thousand_times_larger(std):
    values = slow_motion(8000) + std * np.random.default_rng(0).standard_normal(8000)
    assert white_noise_std(values, RATE, above_hz=25.0) == pytest.approx(std, rel=0.05)


def test_impacts_and_standing_still_do_not_change_the_noise():
    rng = np.random.default_rng(1)
    values = slow_motion(8000)
    values[:3000] = values[3000]
    values += 0.01 * rng.standard_normal(8000)
    values[rng.integers(0, 8000, 10)] += 5.0
    assert white_noise_std(values, RATE, above_hz=25.0) == pytest.approx(0.01, rel=0.1)


def test_rounding_alone_costs_a_twelfth_of_a_step_squared():
    step = 2 * math.pi / 4096
    values = np.round(slow_motion(8000) / step) * step
    assert white_noise_std(values, RATE, above_hz=25.0) == pytest.approx(step / math.sqrt(12), rel=0.25)
    still = np.repeat(values[:500], 40)
    assert white_noise_std(still, RATE, above_hz=25.0) == pytest.approx(step / math.sqrt(12), rel=1e-6)


@pytest.mark.parametrize(
    ("step", "dtype"),
    [(1e-6, np.float64), (2 * math.pi / 65536, np.float64), (2 * math.pi / 65536, np.float32), (0.05, np.float32)],
)
def test_the_step_of_a_converter_is_found(step, dtype):
    values = (np.round(slow_motion(4000) / step) * step).astype(dtype).astype(float)
    assert quantisation_step(values) == pytest.approx(step, rel=2e-3 if dtype is np.float32 else 1e-6)


def test_continuous_values_and_constants_have_no_step():
    rng = np.random.default_rng(2)
    assert quantisation_step(rng.standard_normal(3000)) is None
    assert quantisation_step(rng.standard_normal(5)) is None
    assert quantisation_step(slow_motion(3000)) is None
    assert quantisation_step(np.full(100, 0.3)) is None
    assert quantisation_step(np.zeros(0)) is None
