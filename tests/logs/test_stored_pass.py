"""The low-pass that a log has passed before it was stored, and what is computed from its late positions."""

import numpy as np
import pytest
from scipy.signal import bessel, butter, group_delay, sosfilt, sosfiltfilt, zpk2tf

from exogauge.logs.filtering import LowPass, StoredPass

RATE = 200.0
KINDS = [("butterworth", 1), ("butterworth", 3), ("bessel", 2), ("bessel", 4)]


def sections(stored):
    if stored.kind == "bessel":
        return bessel(stored.order, stored.hz, fs=RATE, output="sos", norm="mag")
    return butter(stored.order, stored.hz, fs=RATE, output="sos")


@pytest.mark.parametrize("late", [True, False])
@pytest.mark.parametrize(("kind", "order"), KINDS)
def test_friction_of_the_stored_motion_is_the_stored_friction(kind, order, late):
    """sign(ẋ) smeared by the filter, and smeared again from the sign of the velocity that the filter left."""
    stored = StoredPass(4.0, order, late, kind)
    t = np.arange(6000) / RATE
    x = np.sin(2 * np.pi * 0.12 * t) + 0.3 * np.sin(2 * np.pi * 0.31 * t + 1.0)
    passed = sosfilt if late else sosfiltfilt
    true = passed(sections(stored), np.sign(np.gradient(x)))
    found = stored.apply(np.sign(np.gradient(passed(sections(stored), x))), RATE)
    unaware = LowPass(4.0, RATE).apply(np.sign(np.gradient(passed(sections(stored), x))))
    left, left_unaware = (np.sqrt(np.mean((each - true)[400:-400] ** 2)) for each in (found, unaware))
    assert left < 0.015
    assert left < 0.35 * left_unaware


@pytest.mark.parametrize("late", [True, False])
@pytest.mark.parametrize(("kind", "order"), KINDS)
def test_a_straight_line_stays_where_it_is_however_short(kind, order, late):
    for samples in (1, 2, 7, 3000):
        line = np.column_stack([2.0 - 0.3 * np.arange(samples), np.full(samples, 4.0)])
        np.testing.assert_allclose(StoredPass(3.0, order, late, kind).apply(line, RATE), line, atol=1e-6)


@pytest.mark.parametrize(("kind", "order"), KINDS)
def test_the_delay_is_the_group_delay_of_slow_motion(kind, order):
    design = {"bessel": bessel, "butterworth": butter}[kind]
    how = {"norm": "mag"} if kind == "bessel" else {}
    system = zpk2tf(*design(order, 5.0, fs=RATE, output="zpk", **how))
    (samples,) = group_delay(system, w=[0.02], fs=RATE)[1]
    assert StoredPass(5.0, order, True, kind).delay_s(RATE) == pytest.approx(samples / RATE, rel=1e-3)
    assert StoredPass(5.0, order, False, kind).delay_s(RATE) == 0.0


def test_there_and_back_it_is_the_low_pass_of_the_same_order():
    values = np.random.default_rng(3).standard_normal((2000, 3)).cumsum(axis=0)
    np.testing.assert_allclose(StoredPass(6.0).apply(values, RATE), LowPass(6.0, RATE).apply(values), atol=1e-9)


@pytest.mark.parametrize("late", [True, False])
@pytest.mark.parametrize(("kind", "order"), KINDS)
def test_half_of_a_sine_is_left_where_it_is_said(kind, order, late):
    stored = StoredPass(4.0, order, late, kind)
    t = np.arange(8000) / RATE
    sine = np.sin(2 * np.pi * stored.half_hz(RATE) * t)
    passed = (sosfilt if late else sosfiltfilt)(sections(stored), sine)
    assert np.std(passed[1000:-1000]) == pytest.approx(0.5 * np.std(sine[1000:-1000]), rel=1e-3)
