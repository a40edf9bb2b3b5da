"""The estimate of a headline number: the least of the null tests, the smallest doubt among equals; peaks unbiased."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.criteria.supporting import Supporting
from exogauge.support.best import best
from exogauge.support.peak import peak_places, same_moments
from exogauge.support.repeatability import Null

REGIMES = ("steady", "other", "whole", "moves")


def found(size, seconds):
    of = np.array([size])
    return Null(
        of, of, of, dict.fromkeys(REGIMES, of), of, {name: np.array([seconds]) for name in ("steady", "other", "whole")}
    )


@pytest.mark.parametrize(
    ("sizes", "seconds", "std", "chosen", "equal"),
    [
        ({"a": 2.3, "b": 0.12, "paired": 0.17}, 100.0, {"a": 0.01, "b": 0.05, "paired": 0.03}, "b", {"b"}),
        (
            {"a": 2.3, "b": 0.12, "paired": 0.13},
            14.0,
            {"a": 0.01, "b": 0.05, "paired": 0.03},
            "paired",
            {"b", "paired"},
        ),
        ({"b": 0.1}, 14.0, {"b": 0.2}, "b", {"b"}),
        ({"b": 0.1}, 14.0, {"a": 0.1, "b": 0.2, "paired": 0.3}, "paired", {"paired"}),  # one log without the device
    ],
)
def test_the_least_null_test_wins_and_among_equals_the_smallest_doubt(sizes, seconds, std, chosen, equal):
    said = best({name: found(size, seconds) for name, size in sizes.items()}, std, 0, "whole", Supporting())
    assert (said.approach, set(said.as_good)) == (chosen, equal)


def test_what_is_declared_does_not_speak_against_an_estimate_that_bears_less_of_it():
    """Zeros that drift from the first log without the device to the last stand in the null test of what compares runs,
    and are declared; from a run to its partner they drift less."""
    drifted = replace(found(0.9, 100.0), beyond=dict.fromkeys(REGIMES, np.zeros(1)))
    nulls = {"b": replace(drifted, whole=np.array([0.6])), "paired": drifted}
    assert best(nulls, {"b": 1.1, "paired": 0.4}, 0, "whole", Supporting()).as_good == ("paired",)


def test_nothing_is_best_where_nothing_is_told():
    assert best({"b": found(0.1, 14.0)}, {}, 0, "whole", Supporting()) is None


def test_a_peak_is_not_too_large_because_its_largest_sample_was_chosen():
    """Errors that last half a second: a run's maximum is too large by one deviation, the peak read elsewhere is not."""
    rng, time = np.random.default_rng(0), np.arange(0.0, 14.0, 0.01)
    bell = np.exp(-(((time - 7.0) / 2.5) ** 2))
    errors, naive = [], []
    for _ in range(60):
        runs = [3.0 * bell + 0.3 * np.repeat(rng.standard_normal(28), 50) for _ in range(5)]
        used = [np.ones_like(time, dtype=bool)] * 5
        places = peak_places([time] * 5, same_moments([time] * 5, [0.0] * 5), runs, [None] * 5, used, 0.2)
        errors.append(np.mean([value for _, value in places]) - 3.0)
        naive.append(np.mean([run.max() for run in runs]) - 3.0)
    assert np.mean(naive) > 0.2
    assert abs(np.mean(errors)) < 0.12


def test_a_motion_that_goes_both_ways_is_read_on_one_side_in_all_its_runs():
    """A mean over one run's left and another's right is of neither."""
    rng, time = np.random.default_rng(1), np.arange(0.0, 14.0, 0.01)
    twist = np.sin(2.0 * np.pi * time / 14.0)
    for _ in range(20):
        runs = [3.0 * twist + 0.1 * np.repeat(rng.standard_normal(28), 50) for _ in range(3)]
        used = [np.ones_like(time, dtype=bool)] * 3
        places = peak_places([time] * 3, same_moments([time] * 3, [0.0] * 3), runs, [None] * 3, used, 0.2)
        values = [value for _, value in places]
        assert abs(np.sum(np.sign(values))) == 3
        assert np.abs(values) == pytest.approx(3.0, abs=0.45)


def test_runs_that_begin_at_other_times_are_read_at_the_same_moment():
    time = np.arange(0.0, 10.0, 0.01)
    runs = [np.exp(-((time - 5.0 - shift) ** 2)) for shift in (0.0, 0.7)]
    places = peak_places(
        [time] * 2, same_moments([time] * 2, [0.0, 0.7]), runs, [None] * 2, [np.ones_like(time, dtype=bool)] * 2, 0.2
    )
    assert [time[top] for top, _ in places] == pytest.approx([5.0, 5.7], abs=0.02)


def test_a_single_run_is_read_where_the_band_model_is_largest():
    time = np.arange(0.0, 10.0, 0.01)
    model, line = np.exp(-((time - 5.0) ** 2)), np.exp(-((time - 5.0) ** 2))
    line[100:140] += 4.0
    (place,) = peak_places([time], same_moments([time], [0.0]), [line], [model], [np.ones_like(time, dtype=bool)], 0.2)
    assert place[1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("noise", "read_at"), [(0.1, 2.0), (2.0, 5.0)])
def test_a_single_run_that_is_surely_larger_elsewhere_is_read_there(noise: float, read_at: float):
    """A band that rubs pulls most where it shortens, not where it is longest."""
    time = np.arange(0.0, 10.0, 0.01)
    model, line = np.exp(-((time - 5.0) ** 2)), np.exp(-((time - 5.0) ** 2)) + 2.0 * np.exp(-((time - 2.0) ** 2))
    (place,) = peak_places(
        [time], same_moments([time], [0.0]), [line], [model], [np.ones_like(time, dtype=bool)], 0.2,
        [np.full_like(time, noise)],
    )  # fmt: skip
    assert time[place[0]] == pytest.approx(read_at, abs=0.02)
