"""A force-length test as a straight line: against the line it was made from and scipy's regression."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import curve_fit
from scipy.stats import linregress

from exogauge.criteria.supporting import DEVICES
from exogauge.devices.bench import bench_line
from exogauge.devices.device import BenchTest


def stretched(k=197.8, l_0=0.62, noise=0.0, points=60, seed=0) -> BenchTest:
    """Slack up to l_0, then linear."""
    rng = np.random.default_rng(seed)
    length = rng.uniform(l_0 - 0.1, l_0 + 0.25, points)
    force = k * np.maximum(length - l_0, 0.0)
    return BenchTest(tuple(length), tuple(force + noise * rng.normal(size=points) * (force > 0)))


def test_the_line_behind_a_test_comes_back_and_the_slack_part_is_left_out():
    line = bench_line(stretched())
    assert line.stiffness == pytest.approx(197.8, rel=1e-9)
    assert line.natural_length == pytest.approx(0.62, rel=1e-9)


def test_the_order_of_the_points_does_not_matter():
    test = stretched(noise=0.5)
    back = BenchTest(test.length[::-1], test.force[::-1])
    assert bench_line(back).stiffness == pytest.approx(bench_line(test).stiffness, rel=1e-9)


def test_values_and_doubt_are_those_of_a_linear_regression_over_the_taut_part():
    test = stretched(noise=4.0)
    length, force = np.array(test.length), np.array(test.force)
    taut = force > DEVICES.slack * force.max()
    regression = linregress(length[taut], force[taut])
    (k, l_0), covariance = curve_fit(lambda x, k, l_0: k * (x - l_0), length[taut], force[taut], [200.0, 0.6])
    line = bench_line(test)
    assert line.stiffness == pytest.approx(regression.slope, rel=1e-6)
    assert line.stiffness_std == pytest.approx(regression.stderr, rel=1e-6)
    assert (line.stiffness, line.natural_length) == pytest.approx((k, l_0), rel=1e-5)
    assert line.natural_length_std == pytest.approx(np.sqrt(covariance[1, 1]), rel=1e-3)


def test_the_doubt_is_as_large_as_repeated_tests_differ():
    lines = [bench_line(stretched(noise=6.0, points=40, seed=seed)) for seed in range(300)]
    for value, std in (("stiffness", "stiffness_std"), ("natural_length", "natural_length_std")):
        spread = np.std([getattr(line, value) for line in lines])
        assert spread == pytest.approx(np.mean([getattr(line, std) for line in lines]), rel=0.15)


def test_no_test_bench_is_taken_to_be_perfect():
    line = bench_line(stretched())
    assert line.stiffness_std == pytest.approx(DEVICES.bench * 197.8)
    assert 0.0 < line.natural_length_std < 0.005


@pytest.mark.parametrize(
    ("length", "force"),
    [((0.5, 0.6, 0.7), (0.0, 0.0, 9.0)), ((0.7, 0.7, 0.7), (8.0, 9.0, 10.0)), ((0.5, 0.6), (0.0, 0.0)), ((), ())],
)
def test_a_line_needs_two_lengths_at_which_the_band_pulls(length, force):
    with pytest.raises(ValueError, match="two or more lengths"):
        bench_line(BenchTest(length, force))
