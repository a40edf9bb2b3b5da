import numpy as np
import pytest

from exogauge.logs.bandwidth import suggest_cutoff
from exogauge.logs.derivatives import differentiate_twice
from exogauge.logs.filtering import LowPass

RATE = 200.0
TIME = np.arange(8000) / RATE


def band_limited(highest_hz: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Position and acceleration, (T,) each: twelve sines up to highest_hz, accelerations of equal size."""
    frequency = np.linspace(0.2, highest_hz, 12)
    phase = 2 * np.pi * frequency * TIME[:, None] + rng.uniform(0, 2 * np.pi, 12)
    acceleration = np.sin(phase).sum(axis=1)
    return -(np.sin(phase) / (2 * np.pi * frequency) ** 2).sum(axis=1), acceleration


def error_of(cutoff: float, measured: np.ndarray, truth: np.ndarray) -> float:
    found = LowPass(cutoff, RATE).apply(differentiate_twice(measured, RATE))
    return float(np.sqrt(np.mean((found - truth)[400:-400] ** 2)))


@pytest.mark.parametrize("highest_hz", [2.0, 5.0, 12.0])
@pytest.mark.parametrize("disturb", ["noise", "quantisation"])
def test_the_suggested_cutoff_is_nearly_the_best_one(highest_hz, disturb):
    rng = np.random.default_rng(3)
    position, acceleration = band_limited(highest_hz, rng)
    step = 2 * np.pi / 2**17
    measured = (
        position + 2e-5 * rng.standard_normal(TIME.size) if disturb == "noise" else np.round(position / step) * step
    )
    suggested = suggest_cutoff(measured[:, None], RATE)
    best = min(error_of(float(cutoff), measured, acceleration) for cutoff in np.geomspace(1.0, 40.0, 60))
    assert error_of(suggested, measured, acceleration) < 1.15 * best


def test_more_noise_means_a_lower_cutoff():
    rng = np.random.default_rng(4)
    position, _ = band_limited(15.0, rng)
    noise = rng.standard_normal(TIME.size)
    cutoffs = [suggest_cutoff((position + std * noise)[:, None], RATE) for std in (1e-6, 1e-4, 1e-3)]
    assert cutoffs[0] > cutoffs[1] > cutoffs[2]


def test_joints_that_stand_still_have_no_say():
    rng = np.random.default_rng(5)
    position, _ = band_limited(5.0, rng)
    measured = np.round((position + 1e-5 * rng.standard_normal(TIME.size)) / 1e-5) * 1e-5
    constant, trembling = np.full(TIME.size, 0.7), 1e-5 * rng.standard_normal(TIME.size)
    alone = suggest_cutoff(measured[:, None], RATE)
    crowd = np.column_stack([constant, trembling, constant, measured, trembling, constant])
    assert suggest_cutoff(crowd, RATE) == alone
    assert suggest_cutoff(np.column_stack([constant, trembling]), RATE) == 1.0


def test_the_cutoff_stays_where_second_derivatives_are_accurate():
    rng = np.random.default_rng(6)
    assert suggest_cutoff(np.cumsum(rng.standard_normal((4000, 2)), axis=0), RATE) <= 0.2 * RATE
    assert suggest_cutoff(rng.standard_normal((10, 2)), RATE) == 1.0
