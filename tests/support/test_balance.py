"""Approaches A and B against torques that pinocchio's pulls at via points really gave; [Evaluator] (1)-(4)."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest

from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.identification.predict import Parameters, measured_channels, predictions
from exogauge.support.balance import balance, slopes
from exogauge.support.difference import difference
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import SupportSettings

EVERY = np.arange(6)


def one_foot_more(t):
    return 0.5 + 0.4 * np.sin(1.1 * t)


def apart_with_the_feet(t):
    """The feet push each other forwards and backwards, by up to 40 N."""
    return np.outer(40.0 * np.sin(0.9 * t + 0.4), [1.0, 0.2, 0.0, 0.15, -0.75, 0.0])  # at the height of the soles


def own_torque(model, recorded):
    return balance(model, model.prepare(recorded.log), EVERY)


def apart(model, worn, plain):
    """Approach A in full."""
    runs = [own_torque(model, each) for each in (worn, plain)]
    postures = [Posture(each.log, [joint.name for joint in model.robot.joints]) for each in (worn, plain)]
    return difference(*runs, match(*postures, SupportSettings()))


def as_printed(biped, plain, worn, low_passed):
    """(3): Z ξ without minus with the device. Velocities repeat, so friction and offset do: the currents are left."""
    names = [f"i.{joint.name}" for joint in biped.robot.joints]
    return biped.xi["k_T"] * low_passed(plain.log.stack(names) - worn.log.stack(names))


def stribeck(speed):
    """More friction at low speed than any model here knows: 2 N·m that fade within 0.3 rad/s."""
    return 2.0 * np.sign(speed) * np.exp(-((speed / 0.3) ** 2))


@pytest.fixture(scope="module")
def runs(biped, suit, wander):
    """The same joint motion with and without the suit, recorded once for all tests."""

    @functools.cache
    def record(worn, base=1, **changed):
        return biped.record(wander(1, base_seed=base), bands=suit.bands if worn else (), **changed)

    return record


def test_1_and_4_give_the_devices_torque_where_joints_move_steadily(any_biped, suit, wander, low_passed, inner):
    model = any_biped.known()
    recorded = any_biped.record(wander(1), bands=suit.bands, share=one_foot_more)
    own, truth = own_torque(model, recorded), low_passed(recorded.support)
    error = np.where(own.steady, own.torque - truth, 0.0)[inner]
    assert np.abs(error).max() < 1e-6
    assert np.ptp(truth, axis=0)[any_biped.torso].min() > 5.0
    assert own.steady[inner].mean(axis=0).min() > 0.4


def test_2_leaves_nothing_without_a_device(any_biped, wander, inner):
    own = own_torque(any_biped.known(), any_biped.record(wander(5), share=one_foot_more))
    assert np.abs(np.where(own.steady, own.torque, 0.0)[inner]).max() < 1e-6


def test_bands_act_on_the_joints_they_pass_as_the_virtual_work_of_their_pulls(biped, suit, runs, wander):
    recorded = runs(True)
    routing = Routing(biped.robot.tree, suit.bands)
    torque = band_torque(routing, suit.bands, wander(1).q, wander(1).time).torque
    assert np.abs(recorded.support[:, routing.columns] - torque).max() < 1e-9
    assert not recorded.support[:, biped.legs].any()


def test_a_band_worn_leaves_the_base_rows_as_they_are(biped, suit, runs, wander, inner):
    """Its pulls at the via points are outside forces to pinocchio, and still the feet carry the same."""
    worn, plain = runs(True), runs(False)
    assert np.abs(worn.support).max() > 5.0
    assert np.abs(worn.base - plain.base).max() < 1e-9
    model = biped.known()
    prepared = model.prepare(worn.log)
    (says,) = predictions(model.equations, prepared, [model.identified])
    reads = measured_channels(model.equations, prepared, model.k_T)
    for axis in ("fx", "fy", "fz", "mx", "my", "mz"):
        assert np.abs(says[f"base.{axis}"] - reads[f"base.{axis}"])[inner].max() < 1e-6


def test_3_in_full_is_exact_where_velocities_repeat_whatever_friction_is(biped, suit, runs, wander, low_passed, inner):
    """Friction, offset and rotor inertia are wrong in the model, and half of the friction is not in it at all."""
    model = biped.known(
        k_d=0.2 * biped.xi["k_d"], tau_c=1.6 * biped.xi["tau_c"], tau_o=biped.xi["tau_o"] + 0.7, J_r=np.zeros(6)
    )
    worn = runs(True, base=2, share=one_foot_more, against=apart_with_the_feet, extra=stribeck)
    plain = runs(False, extra=stribeck)
    truth, found = low_passed(worn.support), apart(model, worn, plain)
    assert np.abs(found.torque - truth)[inner].max() < 1e-6
    assert found.compared[inner].mean() > 0.3
    own = own_torque(model, worn)
    assert np.sqrt(np.mean((own.torque - truth)[own.steady] ** 2)) > 0.5


def test_b_misses_friction_that_its_model_does_not_know_by_as_much(biped, suit, runs, wander, low_passed, inner):
    worn = runs(True, extra=stribeck)
    own = own_torque(biped.known(), worn)
    missed = low_passed(stribeck(wander(1).dq))
    error = own.torque + missed - low_passed(worn.support)
    assert np.abs(np.where(own.steady, error, 0.0)[inner]).max() < 1e-6
    assert np.abs(np.where(own.steady, missed, 0.0)[inner]).max() > 1.0


def test_3_as_printed_takes_another_load_on_the_feet_for_support(biped, suit, runs, wander, low_passed, inner):
    """Equal motions of joints and base; only the feet share the load otherwise in the run with the suit."""
    worn, plain = runs(True, share=one_foot_more, against=apart_with_the_feet), runs(False)
    truth = low_passed(worn.support)
    printed = as_printed(biped, plain, worn, low_passed)
    error = np.abs(printed - truth)[inner].max(axis=0)
    assert error[biped.legs].min() > 10.0
    assert error[biped.legs].max() > 30.0
    assert error[biped.torso].max() < 1e-6
    assert np.abs(apart(biped.known(), worn, plain).torque - truth)[inner].max() < 1e-6


def test_3_as_printed_needs_the_same_motion_of_the_base_too(biped, suit, runs, wander, low_passed, inner):
    worn, plain = runs(True, base=2), runs(False)
    printed = as_printed(biped, plain, worn, low_passed)
    truth = low_passed(worn.support)
    assert np.abs(printed - truth)[inner, biped.torso].max() > 1.0
    assert np.abs(apart(biped.known(), worn, plain).torque - truth)[inner].max() < 1e-6


def test_a_common_gain_on_the_motor_constants_scales_a_alone(biped, suit, runs, wander, inner):
    worn, plain = runs(True), runs(False)
    louder = biped.known(k_T=1.07 * biped.xi["k_T"])
    right, scaled = (apart(model, worn, plain).torque[inner] for model in (biped.known(), louder))
    assert np.abs(scaled - 1.07 * right).max() < 1e-6
    b = own_torque(louder, worn).torque[inner]
    assert np.abs(b - 1.07 * own_torque(biped.known(), worn).torque[inner]).max() > 1.0


def test_what_the_maker_believes_is_balanced_with_the_makers_numbers(biped, suit, wander, low_passed, inner):
    """On a robot of which the maker's values are true, the a-priori torque is right and the other one is not."""
    model = biped.known()
    told = biped.with_truth(model.a_priori.phi, model.a_priori.xi)
    recorded = told.record(wander(4), bands=suit.bands)
    own, truth = own_torque(model, recorded), low_passed(recorded.support)
    assert np.abs(np.where(own.steady, own.torque_a_priori - truth, 0.0)[inner]).max() < 1e-6
    assert np.abs(own.torque - truth)[inner].max() > 0.5


def test_slopes_are_how_the_torque_follows_the_robots_parameters(any_biped, suit, wander):
    model, rng = any_biped.known(), np.random.default_rng(0)
    prepared = model.prepare(any_biped.record(wander(1, seconds=3.0), bands=suit.bands).log)
    samples = np.arange(20, 280, 7)
    step = Parameters(0.1 * rng.normal(size=any_biped.phi.shape), 0.1 * rng.normal(size=model.identified.xi.shape))
    moved = replace(model, identified=Parameters(model.identified.phi + step.phi, model.identified.xi + step.xi))
    change = balance(moved, prepared, EVERY).torque - balance(model, prepared, EVERY).torque
    x = np.concatenate([model.equations.base.regroup @ step.phi.ravel(), step.xi.ravel()])
    for place, slope in slopes(model, prepared, samples, EVERY):
        np.testing.assert_allclose(slope @ x, change[samples, place], atol=1e-9)


def test_static_friction_is_left_out_of_the_torque_and_of_its_slopes(biped, stoop):
    model = biped.known()
    prepared = model.prepare(biped.record(stoop(), stuck=lambda t: np.ones(6)).log)
    twice = replace(model, identified=Parameters(model.identified.phi, model.identified.xi * [1, 1, 1, 2, 1, 1]))
    np.testing.assert_array_equal(balance(twice, prepared, EVERY).torque, balance(model, prepared, EVERY).torque)
