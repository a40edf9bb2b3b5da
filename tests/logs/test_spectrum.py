"""Spectra, correlations and low-passes of our own against SciPy's, which takes half a second to load."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal as sig

from exogauge.logs.butterworth import poles_of, sections_of, steady_states
from exogauge.logs.spectrum import correlations, welch

WINDOWS = {"blackmanharris": "blackmanharris", "kaiser24": ("kaiser", 24.0)}


@pytest.mark.parametrize("length", [400, 401, 2000])
@pytest.mark.parametrize("window", WINDOWS)
def test_spectra_are_those_of_scipy(window, length):
    values = np.random.default_rng(1).normal(size=(3, 2000)).cumsum(axis=1) + 5.0
    frequency, power = welch(values, 200.0, window, length)
    theirs = sig.welch(values, 200.0, WINDOWS[window], nperseg=length, detrend="constant")
    np.testing.assert_allclose(frequency, theirs[0], rtol=1e-14)
    np.testing.assert_allclose(power, theirs[1], rtol=1e-8, atol=1e-12 * theirs[1].max())


def test_correlations_begin_where_the_other_ends_before_the_one_begins():
    rng = np.random.default_rng(2)
    one, other = rng.normal(size=(2, 90)), rng.normal(size=(2, 41))
    wanted = [sig.correlate(a, b) for a, b in zip(one, other, strict=True)]
    np.testing.assert_allclose(correlations(one, other), wanted, atol=1e-12)
    assert sig.correlation_lags(90, 41)[0] == 1 - 41


@pytest.mark.parametrize("order", [2, 4, 6])
def test_a_low_pass_of_even_order_is_scipys_to_the_last_bit(order):
    rng = np.random.default_rng(order)
    for rate in (50.0, 200.0, 1000.0, *rng.uniform(20.0, 2000.0, 20)):
        cutoff = float(rng.uniform(0.002, 0.48)) * rate
        sections = sections_of(order, cutoff, rate)
        np.testing.assert_array_equal(sections, sig.butter(order, cutoff, fs=rate, output="sos"))
        np.testing.assert_array_equal(steady_states(sections), sig.sosfilt_zi(sections))


@pytest.mark.parametrize("order", [1, 3, 5])
def test_a_low_pass_of_odd_order_lets_through_what_scipys_does(order):
    cutoff, rate = 30.0, 200.0
    frequency = np.linspace(0.0, 90.0, 50)
    ours, theirs = sections_of(order, cutoff, rate), sig.butter(order, cutoff, fs=rate, output="sos")
    responses = [sig.sosfreqz(each, frequency, fs=rate)[1] for each in (ours, theirs)]
    np.testing.assert_allclose(responses[0], responses[1], atol=1e-12)
    np.testing.assert_allclose(
        np.sort_complex(poles_of(order, cutoff, rate)[0]),
        np.sort_complex(sig.butter(order, cutoff, fs=rate, output="zpk")[1]),
    )
    passed = sig.sosfilt(ours, np.ones(20), zi=steady_states(ours))[0]
    np.testing.assert_allclose(passed, 1.0, rtol=1e-12)
