"""What the doubt of a supporting torque is made of, each part by a case in which it is all there is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from exogauge.support.evaluate import estimate_support
from exogauge.support.settings import PlainLog, WornLog

OFFSET_STD = 0.4  # [N·m]


@pytest.fixture(scope="module")
def wandering(biped, suit, wander):
    """(plain logs, worn logs, bands of each worn log) -> support; no joint ever rests."""

    def run(model, plains, worns):
        without = [PlainLog(each.log, "wander", True) for each in plains]
        return estimate_support(model, without, [WornLog(each.log, "wander", suit) for each in worns])[0]

    return run


@pytest.mark.slow
def test_an_offset_that_may_be_wrong_makes_the_mean_of_b_wrong_by_as_much_and_that_of_a_not_at_all(
    biped, suit, wander, wandering
):
    """It errs alike at every sample: no mean takes it off, and only a difference of two runs does."""
    model = biped.known()
    equations = model.equations
    names = [effect.coefficient.name for effect in equations.effects]
    covariance = np.zeros((equations.size, equations.size))
    for axis in range(len(equations.robot.joints)):
        place = equations.effect_columns(axis)[names.index("tau_o")]
        covariance[place, place] = OFFSET_STD**2
    believed = replace(model, covariance=covariance)
    plains = [biped.record(wander(1, base_seed=k), f"plain{k}") for k in range(2)]
    found = wandering(believed, plains, [biped.record(wander(1, base_seed=5), "worn", suit.bands)])
    for joint in found.joints:
        seconds = joint.by["b"].integral.value / joint.by["b"].mean.value
        assert joint.by["b"].mean.std == pytest.approx(OFFSET_STD, rel=0.05)
        assert joint.by["b"].integral.std == pytest.approx(OFFSET_STD * seconds, rel=0.05)
        assert joint.by["a"].mean.std < 0.1 * OFFSET_STD


@pytest.mark.slow
def test_trials_that_differ_make_the_doubt_of_their_mean(biped, suit, wander, wandering):
    """Bands that pull by a fifth more in one of three trials: the standard error of a mean of three."""
    stronger = tuple(replace(band, stiffness=1.2 * band.stiffness) for band in suit.bands)
    plains = [biped.record(wander(1, base_seed=k), f"plain{k}") for k in range(2)]
    worns = [
        biped.record(wander(1, base_seed=5 + k), f"worn{k}", bands)
        for k, bands in enumerate((suit.bands, stronger, suit.bands))
    ]
    found = wandering(biped.known(), plains, worns)
    for d, joint in enumerate(found.joints):
        for name, lines in (("a", "support_a"), ("b", "support_b")):
            means = np.array([np.nanmean(getattr(trial, lines)[:, d]) for trial in found.trials])
            apart = np.sqrt(np.sum((means - means.mean()) ** 2) / 2.0)
            assert apart > 0.02 * np.abs(means).max()
            assert joint.spread[name] == pytest.approx(apart)
            assert joint.by[name].mean.std == pytest.approx(apart / np.sqrt(3.0), rel=0.1)


@pytest.mark.slow
def test_with_one_run_without_the_device_a_is_doubted_for_the_errors_of_two_runs(
    biped, suit, wander, wandering, low_passed, inner
):
    """Torque that no model knows and that no run repeats: A has that of both runs in it."""

    def restless(seed):
        memory = np.exp(-1.0 / 20.0)  # 0.2 s at 100 Hz

        def torque(speed):
            white = np.random.default_rng(seed).normal(size=speed.shape)
            return lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white, axis=0)

        return torque

    course = wander(1, 30.0)
    plain = biped.record(course, "plain", extra=restless(1))
    worn = biped.record(course, "worn", suit.bands, extra=restless(2))
    (trial,) = wandering(biped.known(), [plain], [worn]).trials
    truth = low_passed(worn.support)[:, biped.places("torso_pitch", "torso_yaw")]
    for estimate, std, counts in (
        (trial.support_a, trial.support_a_std, trial.compared),
        (trial.support_b, trial.support_b_std, trial.steady),
    ):
        ratio = ((estimate - truth) / std)[inner][counts[inner]]
        assert 0.83 < np.sqrt(np.mean(ratio**2)) < 1.2
