"""Angles told from 0 to 360 degrees: no joint goes round between two samples."""

import numpy as np
import pytest

from exogauge.logs.findings import JointLimits
from exogauge.logs.model import Log
from exogauge.logs.whole_turns import in_one_course

TURN = 2.0 * np.pi
T = np.arange(2000) / 100.0
FREE, LIMITED = JointLimits(), JointLimits(-2.2, 2.2, 2.0)


def one(log, limits):
    (found,) = in_one_course([log], limits)
    return found


def log(**channels):
    return Log("log", T, {f"q.{name}": values for name, values in channels.items()})


@pytest.mark.parametrize("limits", [FREE, LIMITED])
@pytest.mark.parametrize("size", [0.4, 2.0])
def test_an_angle_that_begins_anew_is_the_same_up_to_whole_turns(limits, size):
    true = size * np.sin(0.8 * T)
    found = one(log(a=true % TURN), {"a": limits})
    off = (found.channels["q.a"] - true) / TURN
    np.testing.assert_allclose(off, np.round(off[0]), atol=1e-12)
    assert [note.rule for note in found.notes][:1] == ["turns_continued"]
    if limits is LIMITED:
        np.testing.assert_allclose(found.channels["q.a"], true, atol=1e-12)


def test_the_row_is_that_after_the_jump():
    true = 0.4 * np.sin(0.8 * T)
    (note, *_) = one(log(a=true % TURN), {}).notes
    told = true % TURN
    assert abs(told[note.row - 1] - told[note.row - 2]) > np.pi


def test_many_turns_on_are_one_course():
    true = 3.0 * T
    off = (one(log(a=true % TURN), {}).channels["q.a"] - true) / TURN
    np.testing.assert_allclose(off, np.round(off[0]), atol=1e-9)


def test_a_joint_that_is_told_about_a_whole_turn_is_told_about_zero_where_only_that_is_within_its_limits():
    true = 0.2 * np.sin(0.8 * T)
    found = one(log(a=TURN - 0.5 + true, b=TURN - 0.5 + true), {"a": LIMITED, "b": FREE})
    np.testing.assert_allclose(found.channels["q.a"], -0.5 + true, atol=1e-12)
    np.testing.assert_array_equal(found.channels["q.b"], TURN - 0.5 + true)
    (note,) = found.notes
    assert note.rule == "turn_taken_off"
    assert "q.a" in note.detail
    assert "-360" in note.detail


@pytest.mark.parametrize(
    "values",
    [
        0.4 * np.sin(0.8 * T),
        0.4 * np.sin(0.8 * T) + np.where(T > 10.0, 5.5, 0.0),  # counts were lost, but no whole turn of them
        3.0 + 0.4 * np.sin(0.8 * T),  # beyond its limits, and further off by a turn
        np.random.default_rng(1).uniform(-9.0, 9.0, len(T)),
    ],
)
def test_what_is_no_whole_turn_is_left_as_it_is(values):
    before = log(a=values)
    assert one(before, {"a": LIMITED}) is before


def test_what_slides_has_no_turns():
    before = log(a=(0.4 * np.sin(0.8 * T)) % TURN)
    assert one(before, {"a": JointLimits(turns=False)}) is before


@pytest.mark.parametrize("samples", [0, 1])
def test_next_to_nothing_is_left_as_it_is(samples):
    before = Log("log", T[:samples], {"q.a": np.full(samples, 0.3)})
    assert one(before, {"a": LIMITED}) is before


def test_logs_of_one_recorder_are_told_alike():
    """A run that stays on one side of where the angle begins anew, beside one that crosses: the same postures."""
    true = 0.1 * np.sin(0.8 * T) - 0.2
    crossing, staying = log(a=(true + 0.25) % TURN), log(a=true % TURN)
    assert in_one_course([staying], {})[0] is staying
    both = in_one_course([crossing, staying], {})
    np.testing.assert_allclose(both[0].channels["q.a"], true + 0.25, atol=1e-12)
    np.testing.assert_allclose(both[1].channels["q.a"], true, atol=1e-12)
    assert [note.rule for note in both[1].notes] == ["turn_taken_off"]
