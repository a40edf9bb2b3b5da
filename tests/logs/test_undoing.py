"""Positions before a low-pass stored them, from what it left; the low-passes are SciPy's."""

import numpy as np
import pytest
from scipy.signal import bessel, butter, sosfilt, sosfiltfilt

from exogauge.logs.derivatives import differentiate
from exogauge.logs.filtering import LowPass, StoredPass
from exogauge.logs.model import Log
from exogauge.logs.undoing import StoredPositions, undone

RATE = 200.0
TIME = np.arange(5000) / RATE
INSIDE = slice(200, -200)
SHAPES = [("butterworth", 1, True), ("butterworth", 3, True), ("bessel", 2, True), ("butterworth", 2, False)]
FINEST = LowPass(30.0, RATE)


def motion(delay_s=0.0):
    """Waves up to 2 Hz and a slow drift [rad]."""
    t = TIME - delay_s
    return (
        np.sin(2 * np.pi * 0.13 * t) + 0.2 * np.sin(2 * np.pi * 1.1 * t) + 0.02 * np.sin(2 * np.pi * 2.0 * t) + 0.05 * t
    )


def passed(stored, values):
    how = {"norm": "mag"} if stored.kind == "bessel" else {}
    design = bessel if stored.kind == "bessel" else butter
    sections = design(stored.order, stored.hz, fs=RATE, output="sos", **how)
    return (sosfilt if stored.late else sosfiltfilt)(sections, values - values[0]) + values[0]


@pytest.mark.parametrize(("kind", "order", "late"), SHAPES)
def test_what_went_in_is_found_again_when_it_went_in(kind, order, late):
    stored = StoredPass(3.0, order, late, kind)
    came_out = passed(stored, motion())
    lost = np.max(np.abs((came_out - motion())[INSIDE]))
    left = np.max(np.abs((undone(came_out, stored, RATE, 0.03) - motion())[INSIDE]))
    assert left < 2e-3
    assert left < 0.05 * lost


@pytest.mark.parametrize(("kind", "order", "late"), SHAPES)
def test_or_as_late_as_slow_motion_came_out(kind, order, late):
    stored = StoredPass(3.0, order, late, kind)
    found = undone(passed(stored, motion()), stored, RATE, 0.03, late=True)
    np.testing.assert_allclose(found[INSIDE], motion(stored.delay_s(RATE))[INSIDE], atol=2e-3)


def test_what_is_computed_from_what_went_in_passes_as_that_did():
    stored = StoredPass(4.0, 2, True)
    values = np.column_stack([np.sign(np.sin(TIME)), motion()])
    found = stored.let_through(values, RATE)
    for column, value in zip(found.T, values.T, strict=True):
        np.testing.assert_allclose(column[INSIDE], passed(stored, value)[INSIDE], atol=1e-6)


def position(log):
    return StoredPositions(log, ["q.j"], FINEST)


def test_a_log_that_nothing_low_passed_is_left_as_it_is():
    log = Log("plain", TIME, {"q.j": motion()})
    np.testing.assert_array_equal(position(log).before(None)[:, 0], FINEST.apply(motion()))


def stored_in_steps(step):
    """What came out of a steep low-pass, rounded, and the same undone."""
    stored = StoredPass(2.0, 4, False)
    rounded = step * np.round(passed(stored, motion()) / step)
    found = position(Log("rounded", TIME, {"q.j": rounded})).before(stored)[:, 0]
    return FINEST.apply(rounded), found


@pytest.mark.parametrize("step", [1e-9, 1e-5, 1e-3])
def test_undoing_helps_as_far_as_rounding_allows(step):
    as_stored, found = stored_in_steps(step)
    errors = [np.std(differentiate(each - motion(), RATE)[INSIDE]) for each in (found, as_stored)]
    assert errors[0] < 0.5 * errors[1]


def test_coarse_rounding_is_not_blown_up_to_motion():
    as_stored, found = stored_in_steps(0.02)
    np.testing.assert_array_equal(found, as_stored)
