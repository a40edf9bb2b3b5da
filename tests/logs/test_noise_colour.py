"""Noise that grows towards low frequencies is measured where motion does not reach, and known below."""

import numpy as np
import pytest
from scipy.signal import lfilter

from exogauge.criteria.judging import Judging
from exogauge.logs.model import Log
from exogauge.logs.noise_colour import hidden_noise

RATE, CUTOFF = 200.0, 8.0


def log_of(values: np.ndarray, number: int) -> Log:
    return Log(f"log_{number}", np.arange(len(values)) / RATE, {"i.elbow": values})


def noisy(share: float, number: int) -> np.ndarray:
    return lfilter([1.0], [1.0, -share], np.random.default_rng(number).standard_normal(6000))


def in_the_band(share: float, cutoff: float) -> float:
    """Std of what noise holds below the cut-off beyond what its mean density above twice the cut-off would."""
    frequency = np.linspace(0.0, np.pi, 200_001)
    density = 1.0 / np.abs(1.0 - share * np.exp(-1j * frequency)) ** 2
    inside, above = frequency < 2 * np.pi * cutoff / RATE, frequency > 4 * np.pi * cutoff / RATE
    return float(np.sqrt((density[inside].mean() - density[above].mean()) * cutoff / (0.5 * RATE)))


@pytest.mark.parametrize("share", [0.3, 0.6, 0.8])
@pytest.mark.parametrize("moved", [0.0, 300.0])
@pytest.mark.parametrize("cutoff", [CUTOFF, 6.0])
def test_what_the_band_holds_beyond_white_noise_is_known_to_a_quarter_from_above_it(share, moved, cutoff):
    time = np.arange(6000) / RATE
    motion = moved * (np.sin(2.0 * time) + 0.3 * np.sin(11.0 * time))
    (found,) = hidden_noise([log_of(noisy(share, k) + motion, k) for k in range(4)], ["i.elbow"], cutoff, Judging())
    assert found == pytest.approx(in_the_band(share, cutoff), rel=0.25)


@pytest.mark.parametrize("cutoff", [10.0, 20.0])
@pytest.mark.parametrize("share", [0.5, 0.8])
def test_where_all_noise_falls_alike_the_band_may_hold_what_steep_noise_would(share, cutoff):
    logs = [log_of(noisy(share, k), k) for k in range(4)]
    (found,) = hidden_noise(logs, ["i.elbow"], cutoff, Judging())
    assert 0.8 * in_the_band(share, cutoff) < found < 8.0
    assert hidden_noise([log_of(noisy(0.0, k), k) for k in range(4)], ["i.elbow"], cutoff, Judging()) == [0.0]


def test_white_noise_hides_nothing_nor_does_a_log_that_reaches_no_higher():
    logs = [log_of(noisy(0.0, k), k) for k in range(4)]
    assert hidden_noise(logs, ["i.elbow"], CUTOFF, Judging()) == [0.0]
    assert hidden_noise([log_of(noisy(0.6, 1), 1)], ["i.elbow"], 30.0, Judging()) == [0.0]
    assert hidden_noise(logs, [], CUTOFF, Judging()).shape == (0,)
