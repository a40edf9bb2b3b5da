"""A push in a log without the device: the time that the search for one leaves out is in no supporting torque, no band
and no doubt; and it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.remarks import About, Remark
from exogauge.support.evaluate import estimate_support
from exogauge.support.settings import PlainLog, WornLog

pytestmark = pytest.mark.slow

BEGAN, ENDED = 5.2, 6.0  # [s] of the push, while the torso rises
SPAN = (BEGAN - 0.1, ENDED + 0.1)
PUSH = 25.0  # [N·m] on torso_pitch at its largest


def swaying(k):
    return lambda t: 0.5 + 0.3 * np.sin(t + k)


@pytest.fixture(scope="module")
def recorded(biped, suit, stoop):
    plain = [biped.record(stoop(k), f"plain{k}", share=swaying(k)) for k in range(2)]
    worn = [biped.record(stoop(5 + k), f"worn{k}", suit.bands, share=swaying(3 * k)) for k in range(2)]
    return plain, worn


def pushed(biped, log):
    """A hand that lifts the chest for a moment: the motor of torso_pitch gives less."""
    joint = biped.places("torso_pitch")[0]
    inside = (log.time > BEGAN) & (log.time < ENDED)
    push = np.where(inside, PUSH * np.sin(np.pi * (log.time - BEGAN) / (ENDED - BEGAN)) ** 2, 0.0)
    current = log.channels["i.torso_pitch"] - push / biped.xi["k_T"][joint]
    return replace(log, channels=log.channels | {"i.torso_pitch": current})


@pytest.fixture(scope="module")
def evaluated(biped, suit, recorded):
    """untouched, touched and not noticed, touched and left out."""
    plain, worn = recorded
    with_suit = [WornLog(each.log, "stoop", suit) for each in worn]

    def run(first):
        logs = [first, plain[1].log]
        return estimate_support(biped.known(), [PlainLog(log, "stoop", True) for log in logs], with_suit)

    touched = pushed(biped, plain[0].log)
    return {
        "untouched": run(plain[0].log),
        "unnoticed": run(touched),
        "left out": run(replace(touched, left_out=(SPAN,))),
    }


def near(span, time, margin=0.0):
    return (time > span[0] - margin) & (time < span[1] + margin)


def test_approach_a_says_nothing_of_that_time_and_the_truth_of_the_rest(evaluated, recorded, low_passed, inner, biped):
    trial = evaluated["left out"][0].trials[0]
    silent = np.isnan(trial.support_a).any(axis=1)
    assert trial.reference == "plain0"
    assert silent[near(SPAN, trial.time)].all()
    assert not silent[~near(SPAN, trial.time, 0.3)][inner].any()
    assert not trial.compared[silent].any()
    truth = low_passed(recorded[1][0].support)[:, biped.places("torso_pitch", "torso_yaw")]
    error = np.abs(trial.support_a - truth)
    assert error[inner][trial.compared[inner]].max() < 0.02
    wrong = evaluated["unnoticed"][0].trials[0]
    assert np.nanmax(np.abs(wrong.support_a - truth)[inner][wrong.compared[inner]]) > 0.5 * PUSH


def test_a_log_that_nothing_touched_is_compared_as_ever(evaluated):
    before, after = (evaluated[name][0].trials[1] for name in ("untouched", "left out"))
    assert after.reference == "plain1"
    np.testing.assert_array_equal(after.support_a, before.support_a)


def test_bands_and_their_doubt_are_what_they_are_without_the_push(evaluated, suit):
    doubts = {}
    for name, (_, stiffness) in evaluated.items():
        by = {each.approach: each for each in stiffness}
        for approach in "AB":
            for estimate, band in zip(by[approach].bands, suit.bands, strict=True):
                doubts[name, approach, band.name] = estimate.stiffness.std
                assert estimate.stiffness.value == pytest.approx(band.stiffness, rel=1e-3)
                assert abs(estimate.stiffness.value - band.stiffness) < 3.0 * estimate.stiffness.std
    for (name, approach, band), std in doubts.items():
        if name == "left out":
            assert std == pytest.approx(doubts["untouched", approach, band], rel=0.5)
        if (name, approach) == ("left out", "B"):  # A finds the other joint, on which nobody pushed, to lean on
            assert std < 0.5 * doubts["unnoticed", approach, band]


def test_what_is_found_where_there_is_nothing_does_not_hold_the_push(evaluated):
    null = {name: support.joints[0].null for name, (support, _) in evaluated.items()}
    for approach in "ab":
        assert null["unnoticed"][approach] > 1.0
        assert null["left out"][approach] < 1.05 * null["untouched"][approach] + 0.01
    assert evaluated["left out"][0].joints[0].rest_half_width == pytest.approx(
        evaluated["untouched"][0].joints[0].rest_half_width
    )


def test_a_push_at_rest_is_no_friction(biped, suit, recorded):
    """While the bend is held: what friction can hold there is what sets the intervals."""
    plain, worn = recorded
    log, (start, stop) = plain[0].log, (3.4, 4.1)
    inside = (log.time > start) & (log.time < stop)
    current = log.channels["i.torso_pitch"] + np.where(inside, 3.0, 0.0)
    touched = replace(log, channels=log.channels | {"i.torso_pitch": current}, left_out=((start, stop),))
    with_suit = [WornLog(worn[0].log, "stoop", suit)]
    widths = [
        estimate_support(biped.known(), [PlainLog(one, "stoop", True)], with_suit)[0].joints[0].rest_half_width
        for one in (log, touched, replace(touched, left_out=()))
    ]
    assert widths[1] == pytest.approx(widths[0])
    assert widths[2] > 2.0 * widths[0]


def test_a_push_in_a_log_that_is_not_compared_is_not_spoken_of(biped, suit, recorded, stoop):
    plain, worn = recorded
    elsewhere = replace(plain[1].log, name="id_1", left_out=((3.0, 4.0),))
    logs = [PlainLog(plain[0].log, "stoop", True), PlainLog(elsewhere, None, False)]
    said = estimate_support(biped.known(), logs, [WornLog(worn[0].log, "stoop", suit)])[0].remarks
    assert About.TOUCHED not in [each.about for each in said]


def test_it_is_said(evaluated):
    (told,) = [each for each in evaluated["left out"][0].remarks if "plain0" in each.names]
    assert told == Remark(About.TOUCHED, ("plain0",), numbers=(pytest.approx(5.1), pytest.approx(6.1)))
    assert About.TOUCHED not in [each.about for each in evaluated["untouched"][0].remarks]
