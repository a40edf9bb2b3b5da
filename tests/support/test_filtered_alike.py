"""Logs that were low-passed before they were stored: what the model says of them passes the same low-pass, with a
device as without, and it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from exogauge.logs.filtering import StoredPass
from exogauge.remarks import About, Remark
from exogauge.support.evaluate import estimate_support
from exogauge.support.settings import PlainLog, WornLog

RATE, BAND = 100.0, 3.0
ONCE = butter(4, BAND, fs=RATE, output="sos")


def stored(log):
    channels = {name: sosfiltfilt(ONCE, values - values[0]) + values[0] for name, values in log.channels.items()}
    return replace(log, channels=channels)


@pytest.fixture(scope="module")
def recorded(biped, suit, wander):
    """The same joint motion over another base motion, all stored at 3 Hz."""
    plain = biped.record(wander(4, 12.0), "plain", ())
    worn = biped.record(wander(4, 12.0, base_seed=8), "worn", suit.bands)
    return stored(plain.log), stored(worn.log), worn.support


def support(biped, suit, plain, worn):
    return estimate_support(biped.known(), [PlainLog(plain, "any", True)], [WornLog(worn, "any", suit)])


def known(log):
    return replace(log, stored=StoredPass(BAND))


@pytest.mark.slow
def test_approach_b_meets_the_truth_where_it_says_that_it_holds(biped, suit, recorded, inner):
    plain, worn, true = recorded
    places = biped.places("torso_pitch", "torso_yaw")
    truth = sosfiltfilt(ONCE, true, axis=0)[:, places]
    worst = {}
    for name, logs in {"alike": (known(plain), known(worn)), "as if not": (plain, worn)}.items():
        trial = support(biped, suit, *logs)[0].trials[0]
        assert trial.steady[inner].mean() > 0.15
        worst[name] = np.abs(trial.support_b - truth)[inner][trial.steady[inner]].max()
    assert worst["alike"] < 0.02, "the yaw turns 0.02 samples after an instant; which side is more than such logs tell"
    assert worst["as if not"] > 0.1


@pytest.mark.slow
def test_bands_come_out_right_by_both_approaches(biped, suit, recorded):
    plain, worn, _ = recorded
    alike, as_if_not = (support(biped, suit, *logs)[1] for logs in ((known(plain), known(worn)), (plain, worn)))
    errors = {
        (name, each.approach): max(abs(b.stiffness.value / 1500.0 - 1.0) for b in each.bands)
        for name, found in (("alike", alike), ("as if not", as_if_not))
        for each in found
    }
    assert errors["alike", "A"] < 0.015
    assert errors["alike", "B"] < 0.015
    assert errors["alike", "B"] < errors["as if not", "B"]


@pytest.mark.slow
def test_it_is_said_which_logs_were_stored_so_and_which_were_not(biped, suit, recorded):
    plain, worn, _ = recorded
    both, one, none = (
        support(biped, suit, *logs)[0].remarks
        for logs in ((known(plain), known(worn)), (known(plain), worn), (plain, worn))
    )
    (low,) = [each for each in both if each.about == About.LOW_PASSED]
    assert (low.names, low.numbers) == (("plain", "worn"), (pytest.approx(3.0, abs=0.005),))
    assert [each.names for each in one if each.about == About.LOW_PASSED] == [("plain",)]
    assert Remark(About.STORED_UNLIKE, ("worn",), beside=("plain",)) in one
    assert not [each for each in none if each.about in (About.LOW_PASSED, About.STORED_UNLIKE)]
