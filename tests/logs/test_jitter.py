"""Samples taken when their stamps say are resampled; stamps that jitter alone are replaced; positions tell which."""

import numpy as np
import pytest

from exogauge.logs.model import Log
from exogauge.logs.segments import segments

PERIOD, SAMPLES = 0.008, 3000
EVEN = PERIOD * np.arange(SAMPLES)


def angle(time: np.ndarray) -> np.ndarray:
    return 0.4 * np.sin(1.9 * time) + 0.1 * np.sin(5.3 * time)


def jittered(share: float) -> np.ndarray:
    late = share * PERIOD * np.random.default_rng(3).standard_normal(SAMPLES)
    time = EVEN + np.clip(late, -0.24 * PERIOD, 0.24 * PERIOD)
    return time - time[0]


def log_of(time: np.ndarray, taken: np.ndarray, moves: float = 1.0) -> Log:
    noise = 7e-6 * np.random.default_rng(4).standard_normal(SAMPLES)
    return Log("elbow", time, {"q.elbow": moves * angle(taken) + noise, "i.elbow": np.cos(1.9 * taken)})


@pytest.mark.parametrize("share", [0.03, 0.1, 0.2])
def test_samples_that_jitter_are_what_they_would_be_on_an_even_clock(share):
    time = jittered(share)
    (found,) = segments(log_of(time, time))
    assert [note.rule for note in found.notes] == ["samples_evened"]
    assert np.std(np.diff(found.time)) < 1e-9
    assert np.std(found.channels["q.elbow"] - angle(found.time)) < 1e-5  # counted as even: 0.0002 and more
    assert np.std(found.channels["i.elbow"] - np.cos(1.9 * found.time)) < 1e-5


@pytest.mark.parametrize("share", [0.03, 0.1, 0.2])
def test_samples_whose_stamps_alone_jitter_stay_as_they_are(share):
    given = log_of(jittered(share), EVEN)
    (found,) = segments(given)
    assert [note.rule for note in found.notes] == ["stamps_evened"]
    assert np.array_equal(found.channels["q.elbow"], given.channels["q.elbow"])
    assert np.std(np.diff(found.time)) < 1e-9


def test_where_nothing_moves_neither_is_said():
    given = log_of(jittered(0.1), EVEN, moves=0.0)
    assert segments(given) == [given]


def test_an_even_log_is_left_alone():
    given = log_of(EVEN, EVEN)
    assert segments(given) == [given]


@pytest.mark.parametrize("taken_at_stamps", [True, False])
@pytest.mark.parametrize("step", [2e-5, 4e-4])
def test_an_encoder_s_steps_make_neither_reading_the_smoother_one(taken_at_stamps, step):
    """Slow turns between rests: there interpolation smooths the steps, whichever is right."""
    time = jittered(0.02)
    slow = 0.3 * (1.0 - np.cos(0.5 * (time if taken_at_stamps else EVEN)))
    given = Log("elbow", time, {"q.elbow": step * np.round(slow / step), "q.wrist": np.zeros(SAMPLES)})
    (found,) = segments(given)
    wrong = "stamps_evened" if taken_at_stamps else "samples_evened"
    assert wrong not in [note.rule for note in found.notes]


def test_where_samples_and_stamps_jitter_neither_is_said():
    time = jittered(0.2)
    given = log_of(time, EVEN + 0.5 * (time - EVEN))
    assert segments(given) == [given]
