"""Labs that agree are said to agree as often as chance has it, and the spread between labs that is put in is found."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from exogauge.criteria.between_labs import USUAL
from exogauge.estimation.between_labs import agreement


def test_labs_that_agree_are_said_to_differ_as_often_as_chance_has_it() -> None:
    rng, trials = np.random.default_rng(1), 1000
    stds = np.array([1.0, 2.0, 0.5, 4.0])
    found = [agreement(200.0 + stds * rng.standard_normal(4), stds) for _ in range(trials)]
    wrong = sum(each.verdict == "differ" for each in found)
    low, high = binom.ppf((0.001, 0.999), trials, USUAL.by_chance)
    assert low <= wrong <= high
    held = sum(abs(each.mean - 200.0) < 1.96 * each.std for each in found)  # type: ignore[operator]
    assert held / trials > 0.94


def test_the_spread_between_labs_is_found_within_its_interval() -> None:
    rng, trials, tau = np.random.default_rng(2), 400, 3.0
    stds = np.array([1.0, 2.0, 0.5, 4.0, 1.5, 1.0, 2.0, 3.0])
    found = [agreement(200.0 + np.hypot(stds, tau) * rng.standard_normal(8), stds) for _ in range(trials)]
    held = sum(each.tau_interval[0] <= tau <= each.tau_interval[1] for each in found if each.tau_interval)
    low, high = binom.ppf((0.001, 0.999), trials, USUAL.interval)
    assert low <= held <= high
    assert np.median([each.tau for each in found]) == pytest.approx(tau, rel=0.15)  # type: ignore[type-var]
    assert not any(each.provisional for each in found)


def test_two_labs_are_judged_by_their_difference_over_its_standard_deviation() -> None:
    """An identity: Q of two is z²."""
    found = agreement([200.0, 206.0], [1.0, 2.0])
    assert found.q == pytest.approx(6.0**2 / (1.0 + 4.0))
    assert found.birge_ratio == pytest.approx(6.0 / np.sqrt(5.0))
    assert found.verdict == "differ"
    assert found.provisional
    assert agreement([200.0, 203.0], [1.0, 2.0]).verdict == "agree"


def test_numbers_do_not_depend_on_the_unit_and_a_lab_more_that_knows_nothing_changes_nothing() -> None:
    one = agreement([200.0, 206.0, 190.0], [1.0, 2.0, 3.0])
    scaled = agreement([0.2, 0.206, 0.19], [0.001, 0.002, 0.003])
    assert scaled.q == pytest.approx(one.q)
    assert scaled.tau == pytest.approx(one.tau / 1000.0, rel=1e-6)  # type: ignore[operator]
    more = agreement([200.0, 206.0, 190.0, 0.0], [1.0, 2.0, 3.0, 1e9])
    assert more.mean == pytest.approx(one.mean)
    assert more.q == pytest.approx(one.q, rel=1e-6)


@pytest.mark.parametrize("values", [[], [200.0]])
def test_one_lab_alone_leaves_it_undecided(values: list[float]) -> None:
    found = agreement(values, [1.0] * len(values))
    assert (found.labs, found.verdict, found.mean, found.tau_interval) == (len(values), "undecided", None, None)


def test_equal_values_leave_no_spread_and_tell_what_could_be_hidden() -> None:
    found = agreement([5.0, 5.0, 5.0], [1.0, 1.0, 1.0])
    assert (found.q, found.i_squared, found.birge_ratio, found.tau) == (0.0, 0.0, 0.0, 0.0)
    assert found.tau_interval is None, "so alike they are by chance in fewer than 25 of 1000 cases: no spread fits"
    assert agreement([4.0, 5.0, 6.0], [1.0, 1.0, 1.0]).tau_interval == pytest.approx(
        (0.0, np.sqrt(2 / 0.0506356 - 1)), rel=1e-4
    )


@pytest.mark.parametrize("std", [0.0, np.nan, -1.0])
def test_a_value_without_a_doubt_is_refused(std: float) -> None:
    with pytest.raises(ValueError, match="standard deviation"):
        agreement([1.0, 2.0], [1.0, std])
