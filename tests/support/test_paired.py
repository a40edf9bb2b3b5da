"""The paired estimate: A where runs are alike, B where the model is right, better than either where neither holds."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest

from exogauge.support.balance import balance
from exogauge.support.difference import difference
from exogauge.support.paired import paired
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import SupportSettings

HELD = np.full(2, 4.0)


def stribeck(speed):
    """More friction at low speed than any model here knows."""
    return 2.0 * np.sign(speed) * np.exp(-((speed / 0.3) ** 2))


@pytest.fixture(scope="module")
def runs(biped, suit, wander):
    @functools.cache
    def record(worn, extra=None, base=1):
        more = {} if extra is None else {"extra": extra}
        return biped.record(wander(1, base_seed=base), bands=suit.bands if worn else (), **more)

    return record


def estimates(model, biped, worn, plain):
    """Balance with the device, A, and the paired estimate."""
    joints = np.array(biped.torso)
    this, other = (balance(model, model.prepare(each.log), joints) for each in (worn, plain))
    names = [model.robot.joints[j].name for j in joints]
    found = match(Posture(worn.log, names), Posture(plain.log, names), SupportSettings())
    apart = difference(this, other, found)
    return this, apart, paired(this, other, apart, HELD)


def test_of_runs_that_move_alike_it_is_approach_a(biped, runs):
    """With a model that is wrong by anything."""
    model = biped.known()
    xi = model.identified.xi * (1.0 + 0.1 * np.random.default_rng(0).normal(size=model.identified.xi.shape))
    phi = 1.1 * model.identified.phi
    wrong = replace(model, identified=replace(model.identified, xi=xi, phi=phi))
    _, apart, found = estimates(wrong, biped, runs(True, stribeck), runs(False, stribeck))
    assert apart.compared.mean(axis=0).min() > 0.3
    np.testing.assert_array_equal(found.torque[apart.compared], apart.torque[apart.compared])


def test_with_a_model_that_is_right_it_is_approach_b(biped, runs, inner):
    this, _, found = estimates(biped.known(), biped, runs(True), runs(False, base=2))
    moving = this.steady[inner] & np.isfinite(found.torque[inner])
    assert moving.mean(axis=0).min() > 0.3
    assert np.abs(found.torque - this.torque)[inner][moving].max() < 0.02


@pytest.mark.parametrize("wrong", ["mass", "coulomb"])
def test_what_the_model_errs_by_in_both_runs_drops_out(biped, runs, wander, low_passed, inner, wrong):
    """B has the whole of the error; of the paired estimate what is left is that of the difference of the runs, which
    is 3 mrad and smooth."""
    model, worn, course = biped.known(), runs(True), wander(1, base_seed=1)
    wave = 1.3 * course.time[:, None] + np.arange(6.0)
    plain = biped.record(
        replace(
            course,
            q=course.q + 4.2e-3 * np.sin(wave),
            dq=course.dq + 1.3 * 4.2e-3 * np.cos(wave),
            ddq=course.ddq - 1.3**2 * 4.2e-3 * np.sin(wave),
        )
    )
    identified = model.identified
    if wrong == "mass":
        identified = replace(identified, phi=1.05 * identified.phi)
    else:
        names = [effect.name for effect in model.equations.effects]
        xi = identified.xi.copy()
        xi[:, names.index("coulomb")] *= 1.3
        identified = replace(identified, xi=xi)
    this, apart, found = estimates(replace(model, identified=identified), biped, worn, plain)
    truth = low_passed(worn.support)[:, biped.torso]
    counts = apart.compared[inner]
    error = np.sqrt(np.mean((found.torque - truth)[inner][counts] ** 2))
    alone = np.sqrt(np.mean((this.torque - truth)[inner][counts] ** 2))
    assert alone > 0.1
    assert error < 0.2 * alone


@pytest.mark.slow
def test_where_the_partner_stands_elsewhere_its_friction_is_not_taken_for_an_error(biped, suit, stoop, low_passed):
    """Joints stick one way with the suit and the other way without: A is wrong by both, the paired estimate by none."""
    model, joints = biped.known(), biped.torso
    worn = biped.record(stoop(1), bands=suit.bands, stuck=lambda t: np.full(6, 0.9))
    plain = biped.record(stoop(1), stuck=lambda t: np.full(6, -0.9))
    held = biped.xi["tau_s"][joints]
    this, other = (balance(model, model.prepare(each.log), np.array(joints)) for each in (worn, plain))
    names = [model.robot.joints[j].name for j in joints]
    apart = difference(this, other, match(Posture(worn.log, names), Posture(plain.log, names), SupportSettings()))
    found = paired(this, other, apart, held)
    truth = low_passed(worn.support)[:, joints]
    quiet = this.at_rest & np.isfinite(found.torque)
    pitch = 1
    a, pair = (np.abs(each - truth)[quiet[:, pitch], pitch] for each in (apart.torque, found.torque))
    assert np.median(a) > held[pitch]
    assert np.median(pair) < 0.3 * held[pitch]
    outside = np.maximum(found.middle - found.half - truth, truth - found.middle - found.half)
    assert np.mean(outside[quiet] > 0.2 * held.max()) < 0.05
