import numpy as np
import pytest

from exogauge.logs.derivatives import derivative_noise_gain, difference_response, differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass


def test_polynomials_of_degree_six_are_differentiated_exactly_also_at_the_ends():
    time = np.arange(40) / 20.0
    polynomial = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.3, -0.2, 0.1, -0.02])
    for order, difference in [(1, differentiate), (2, differentiate_twice)]:
        truth = polynomial.deriv(order)(time)
        np.testing.assert_allclose(difference(polynomial(time), 20.0), truth, rtol=0, atol=1e-9)


@pytest.mark.parametrize("samples", [2, 3, 4, 5, 6, 7, 8, 9])
def test_short_logs_are_differentiated_as_well_as_their_length_allows(samples):
    time = np.arange(samples) / 10.0
    np.testing.assert_allclose(differentiate(3.0 * time, 10.0), 3.0, atol=1e-10)
    if samples > 2:
        np.testing.assert_allclose(differentiate_twice(time**2, 10.0), 2.0, atol=1e-10)
    with pytest.raises(ValueError, match="needs more than"):
        differentiate_twice(time[:2], 10.0)


@pytest.mark.parametrize(("order", "bandwidth"), [(1, 0.175), (2, 0.223)])
def test_the_error_stays_below_one_percent_exactly_up_to_the_bandwidth_that_is_told(order, bandwidth):
    fraction = np.linspace(1e-3, 0.5, 5000)
    error = np.abs(difference_response(fraction, order) / (2 * np.pi * fraction) ** order - 1.0)
    assert error[fraction <= bandwidth].max() < 0.01
    assert error[fraction > bandwidth + 0.001].min() > 0.01


def test_the_response_is_what_happens_to_a_sine():
    rate, frequency = 50.0, 9.0
    time = np.arange(200) / rate
    sine = np.column_stack([np.sin(2 * np.pi * frequency * time), np.cos(2 * np.pi * frequency * time)])
    inner = slice(3, -3)
    first, second = (float(difference_response(frequency / rate, order)) * rate**order for order in (1, 2))
    np.testing.assert_allclose(differentiate(sine, rate)[inner], first * sine[inner, ::-1] * [1, -1], atol=1e-9)
    np.testing.assert_allclose(differentiate_twice(sine, rate)[inner], -second * sine[inner], atol=1e-8)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("cutoff", [2.0, 10.0, 60.0])
def test_the_noise_gain_predicts_the_noise_of_a_filtered_derivative(order, cutoff):
    low_pass = LowPass(cutoff, 200.0)
    noise = 0.3 * np.random.default_rng(3).standard_normal((150_000, 2))
    filtered = low_pass.apply(noise)
    seen = [filtered, differentiate(filtered, 200.0), differentiate_twice(filtered, 200.0)][order]
    seen = seen[low_pass.settle_samples : -low_pass.settle_samples]
    assert seen.std() == pytest.approx(0.3 * derivative_noise_gain(low_pass, order), rel=0.04)
