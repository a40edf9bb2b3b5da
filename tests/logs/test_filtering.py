import numpy as np
import pytest

from exogauge.errors import BadLog
from exogauge.logs.filtering import LowPass, _sections, both_ways_by_scipy, zero_phase_by_scipy


@pytest.mark.parametrize("frequency", [1.0, 5.0, 10.0, 15.0, 40.0])
def test_a_sine_comes_out_scaled_by_the_stated_gain_and_not_shifted(frequency):
    low_pass = LowPass(cutoff_hz=10.0, rate_hz=200.0)
    time = np.arange(2000) / 200.0
    sine = np.sin(2 * np.pi * frequency * time + 0.3)
    inner = slice(2 * low_pass.settle_samples, -2 * low_pass.settle_samples)
    np.testing.assert_allclose(low_pass.apply(sine)[inner], low_pass.gain(frequency) * sine[inner], atol=5e-4)


def test_columns_are_filtered_as_each_would_be_alone():
    low_pass = LowPass(5.0, 100.0)
    table = np.random.default_rng(1).standard_normal((300, 4))
    together = low_pass.apply(table)
    assert together.shape == table.shape
    for column in range(4):
        np.testing.assert_allclose(together[:, column], low_pass.apply(table[:, column]), rtol=0, atol=1e-14)


def test_the_same_filter_on_both_sides_leaves_the_parameters_unchanged():
    rng = np.random.default_rng(2)
    columns, parameters = rng.standard_normal((500, 3)), np.array([2.0, -1.0, 0.5])
    low_pass = LowPass(8.0, 100.0)
    found = np.linalg.lstsq(low_pass.apply(columns), low_pass.apply(columns @ parameters), rcond=None)[0]
    np.testing.assert_allclose(found, parameters, atol=1e-12)


def test_an_impulse_has_settled_after_settle_samples():
    for cutoff, rate, order in [(1.0, 1000.0, 4), (10.0, 200.0, 4), (20.0, 100.0, 2)]:
        low_pass = LowPass(cutoff, rate, order)
        n = 4 * low_pass.settle_samples + 1
        response = np.abs(low_pass.apply(np.eye(1, n, n // 2)[0]))
        assert response[: n // 2 - low_pass.settle_samples].max() < 0.03 * response.max()


def test_a_straight_line_passes_however_short_the_log():
    low_pass = LowPass(1.0, 1000.0)
    for samples in (1, 2, 5, 50, 5000):
        line = 3.0 + 0.1 * np.arange(samples)
        np.testing.assert_allclose(low_pass.apply(line), line, atol=1e-8)


def test_decimation_leaves_less_than_four_percent_of_what_folds_back():
    low_pass = LowPass(10.0, 1000.0)
    kept_rate = low_pass.rate_hz / low_pass.decimation()
    assert kept_rate >= 2.5 * low_pass.cutoff_hz
    assert low_pass.gain(kept_rate - low_pass.cutoff_hz) < 0.039
    assert LowPass(10.0, 20.1).decimation() == 1
    assert low_pass.decimation(keep_factor=2.0) == 50


def test_a_missing_value_is_named_instead_of_smeared():
    table = np.zeros((50, 3))
    table[20, 1] = np.nan
    with pytest.raises(BadLog) as caught:
        LowPass(5.0, 100.0).apply(table)
    assert (caught.value.faults[0].row, caught.value.faults[0].column) == (21, "2")


def test_a_cutoff_above_half_the_rate_is_refused():
    with pytest.raises(ValueError, match="cut-off"):
        LowPass(60.0, 100.0)


@pytest.mark.parametrize("channels", [1, 3, 17])
@pytest.mark.parametrize("samples", [300, 2000])
def test_the_compiled_low_pass_is_scipys_to_the_last_bit(channels, samples):
    from exogauge.loops.passes import zero_phase

    walk = np.random.default_rng(3).standard_normal((samples, channels)).cumsum(axis=0)
    for low_pass in (LowPass(6.5, 200.0), LowPass(20.0, 100.0, 2)):
        one, other = np.empty_like(walk), np.empty_like(walk)
        zero_phase(*_sections(low_pass), walk, low_pass.settle_samples, one)
        zero_phase_by_scipy(*_sections(low_pass), walk, low_pass.settle_samples, other)
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("channels", [1, 3, 17])
def test_the_compiled_passes_round_as_scipy_does(channels):
    from exogauge.loops.passes import both_ways

    walk = np.random.default_rng(3).standard_normal((2000, channels)).cumsum(axis=0)
    for low_pass in (LowPass(2.0, 1000.0), LowPass(6.5, 200.0), LowPass(20.0, 100.0, 2)):
        one, other = walk.copy(), walk.copy()
        both_ways(*_sections(low_pass), one)
        both_ways_by_scipy(*_sections(low_pass), other)
        assert np.abs(one - walk).max() > 1e-3
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * np.abs(walk).max())
