"""What a count of few cases leaves possible."""

from __future__ import annotations

import pytest
from scipy.stats import binom

from exogauge.blind.score import in_words, interval_95, intervals


@pytest.mark.parametrize(("count", "n"), [(1, 50), (7, 12), (110, 114), (49, 50)])
def test_at_either_bound_chance_gives_as_much_or_as_little_in_one_of_forty(count: int, n: int) -> None:
    low, high = interval_95(count, n)
    assert binom.sf(count - 1, n, low) == pytest.approx(0.025)
    assert binom.cdf(count, n, high) == pytest.approx(0.025)


def test_none_of_fifty_is_below_5_8_percent() -> None:
    assert interval_95(0, 50) == pytest.approx((0.0, 1.0 - 0.05 ** (1 / 50)))
    assert in_words(0, 50) == "0 %, below 5.8 %"
    assert interval_95(53, 53) == pytest.approx((0.05 ** (1 / 53), 1.0))
    assert in_words(53, 53) == "100 %, above 95 %"


@pytest.mark.parametrize("share", [0.01, 0.2, 0.5, 0.93])
def test_the_truth_is_inside_at_least_as_often_as_is_said(share: float) -> None:
    n = 40
    inside = [interval_95(k, n)[0] <= share <= interval_95(k, n)[1] for k in range(n + 1)]
    assert sum(binom.pmf(k, n, share) for k in range(n + 1) if inside[k]) >= 0.925  # 0.95 but where one side has it all


def test_every_count_of_cases_gets_its_interval_under_its_own_keys() -> None:
    found = {"cases": 5, "clean": {"n": 2, "false_alarms": 0, "with_clutter": {"n": 0, "false_alarms": 0}}}
    assert intervals(found) == {"clean": {"false_alarms": [0.0, pytest.approx(1.0 - 0.05**0.5, abs=1e-4)]}}


@pytest.mark.parametrize(("count", "n"), [(8, 9), (1, 47), (1, 3000), (999, 1000), (0, 50), (9, 9), (3, 4)])
def test_an_interval_in_words_is_the_interval_and_holds_no_power_of_ten(count: int, n: int) -> None:
    words = in_words(count, n)
    assert "e" not in words.replace("below", "").replace("above", "")
    told = [float(word) for word in words.partition(",")[2].split() if word[0].isdigit()]
    meant = [100.0 * bound for bound in interval_95(count, n) if 0.0 < bound < 1.0]
    assert told == pytest.approx(meant, abs=0.51, rel=0.06)
