"""What the doubt of a peak and of a mean is made of: against logs that are spoilt that way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.criteria.identifying import DECLARED
from exogauge.robots.description import Declared
from exogauge.support.evaluate import estimate_support
from exogauge.support.settings import PlainLog, WornLog

DRIFT, JOINT = 0.01, "torso_pitch"


@pytest.fixture(scope="module")
def logs(biped, suit, wander):
    """One without the device and one with it, of the same motion: no joint ever rests."""
    return biped.record(wander(1), "plain").log, biped.record(wander(1), "worn", suit.bands).log


@pytest.fixture(scope="module")
def told(biped, suit):
    """(log without, logs with the device) -> what is said of the joint, where motors drift and nothing else is in
    doubt."""
    model = replace(biped, robot=replace(biped.robot, declared=Declared(kt_drift=DRIFT))).known()

    def told(plain, *worns):
        worn = [WornLog(each, "wander", suit) for each in worns]
        support, _ = estimate_support(model, [PlainLog(plain, "wander", True)], worn)
        return next(each for each in support.joints if each.joint == JOINT).by

    return told


@pytest.fixture(scope="module")
def found(told, logs):
    return told(*logs)


def drifted(log):
    """The motor of the joint gives more than its current says."""
    return replace(log, channels={**log.channels, f"i.{JOINT}": log.channels[f"i.{JOINT}"] / (1.0 + DRIFT)})


@pytest.mark.parametrize("quantity", ["peak", "mean", "integral"])
@pytest.mark.parametrize("approach", ["a", "b", "paired"])
def test_squares_of_the_parts_add_up(found, approach, quantity):
    number = getattr(found[approach], quantity)
    assert np.sqrt(sum(std**2 for std in number.parts.values())) == pytest.approx(number.std)
    assert number.parts["kt_drift"] > 0.0


@pytest.mark.parametrize(("quantity", "within"), [("peak", 0.25), ("mean", 0.1), ("integral", 0.1)])
def test_a_motor_that_drifts_moves_them_as_far_as_their_part_says(told, logs, found, quantity, within):
    """Slopes are kept in steady motion, ten times a second: at a turn they are read between."""
    plain, worn = logs
    moved = getattr(told(plain, drifted(worn))["b"], quantity).value - getattr(found["b"], quantity).value
    assert getattr(found["b"], quantity).parts["kt_drift"] == pytest.approx(abs(moved), rel=within)


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["peak", "mean"])
def test_what_both_runs_drift_alike_acts_on_their_difference_once(told, logs, found, quantity):
    """Motors of the run with the device, of the one without it, and of both alike."""
    plain, worn = logs
    spoilt = (plain, drifted(worn)), (drifted(plain), worn), (drifted(plain), drifted(worn))
    value = getattr(found["a"], quantity).value
    with_it, without, both = (getattr(told(*each)["a"], quantity).value - value for each in spoilt)
    share = DECLARED.partner_alike
    expected = np.sqrt(share * both**2 + (1.0 - share) * (with_it**2 + without**2))
    assert getattr(found["a"], quantity).parts["kt_drift"] == pytest.approx(expected, rel=0.05)


def test_more_logs_of_a_session_hardly_tell_more_of_what_drifts_through_it(told, logs, found):
    plain, worn = logs
    twice = told(plain, worn, replace(worn, name="again"))["b"].mean.parts["kt_drift"]
    share = DECLARED.alike + 0.5 * (1.0 - DECLARED.alike)
    assert twice == pytest.approx(np.sqrt(share) * found["b"].mean.parts["kt_drift"], rel=1e-3)


def test_what_has_no_doubt_has_no_parts(found):
    assert not found["prior"].mean.parts


@pytest.mark.slow
def test_a_peak_of_what_the_model_lacks_at_one_moment_is_as_doubtful_as_it_is_large(biped, suit, wander):
    """The same torque of 3 N·m for half a second in every run, and a device that does not pull: B has it for a peak."""
    model, time = biped.known(), wander(1).time
    bump = 3.0 * np.exp(-(((time - 0.5 * time[-1]) / 0.3) ** 2))[:, None] * np.eye(6)[biped.places(JOINT)[0]]
    plain, again, *worn = (
        biped.record(wander(1, base_seed=k), f"run{k}", extra=lambda speed: np.zeros_like(speed) + bump).log
        for k in range(4)
    )
    logs = [WornLog(each, "wander", suit) for each in worn]
    support, _ = estimate_support(model, [PlainLog(each, "wander", True) for each in (plain, again)], logs)
    found = next(each for each in support.joints if each.joint == JOINT).by
    b = found["b"].peak
    assert abs(b.value) > 2.0  # where it is looked for in the other run, the same stands
    assert abs(b.value) < 2.0 * b.std
    assert b.parts["null_test"] == max(b.parts.values())
    for name in ("a", "paired"):
        assert found[name].peak.std < 0.2 * b.std


def test_what_errs_at_a_turn_is_no_peak(told, logs, found):
    """Friction that turns round otherwise than a sign does so in all runs, at the same moments."""
    plain, worn = logs
    q, t = worn.channels[f"q.{JOINT}"], worn.time
    turns = t[1:-1][np.diff(np.sign(np.diff(q))) != 0.0]
    spikes = 3.0 * np.sum(np.exp(-(((t[:, None] - turns) / 0.01) ** 2)), axis=1)
    spoilt = replace(worn, channels={**worn.channels, f"i.{JOINT}": worn.channels[f"i.{JOINT}"] - spikes})
    for approach in ("a", "b", "paired"):
        peak, without = told(plain, spoilt)[approach].peak, found[approach].peak
        assert peak.value == pytest.approx(without.value, abs=2.0 * without.std), approach
