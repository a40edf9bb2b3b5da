"""Effects added to a model: their coefficients come back, all that applies it knows them, none changes nothing."""

from dataclasses import fields, replace

import numpy as np
import pytest

from exogauge.effects.catalogue import shaped_effects
from exogauge.identification.axis_signals import axis_signals, loads
from exogauge.identification.identify import identify, seen_by_effects
from exogauge.identification.model import AddedEffect, Extension
from exogauge.identification.predict import predictions
from exogauge.identification.result import Parameter
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import AxisSite
from exogauge.identification.validate import floors_of
from exogauge.logs.model import Log
from exogauge.support.balance import balance, slopes

D_A = 0.7  # [N·m·s/rad]
AXIS = 1
ASYMMETRIC = shaped_effects()["asym_viscous"]
RIPPLE = shaped_effects()["torque_ripple"]


def with_more_friction_one_way(log, d_a):
    """The log of a joint whose motor has d_a |v| more to give."""
    q = log.channels["q.j2"]
    smooth = np.convolve(np.pad(q, 5, mode="edge"), np.ones(11) / 11.0, mode="valid")  # over 55 ms
    more = d_a * np.abs(np.gradient(smooth, log.time))
    return Log(log.name, log.time, {**log.channels, "tau.j2": log.channels["tau.j2"] + more})


@pytest.fixture
def recordings(make_truth, make_log):
    """(d_a, noise) -> (truth, recordings): two fitted, one held out."""

    def make(d_a, noise=0.3):
        truth = make_truth(False, actuation="torque")
        logs = [with_more_friction_one_way(make_log(truth, seed, noise=noise), d_a) for seed in (1, 2, 9)]
        return truth, [Recording(log, k == 2) for k, log in enumerate(logs)]

    return make


def extended(truth, recordings, *effects):
    """(identification without, identification with)"""
    settings = Settings(cutoff_hz=8.0)
    first = identify(truth.robot, recordings, settings)
    return first, identify(truth.robot, recordings, settings, extension=Extension(first.model, effects))


def asymmetry(found) -> Parameter:
    (parameter,) = [each for each in found.parameters if each.name == "asym_viscous.d_a[j2]"]
    return parameter


@pytest.mark.slow
def test_a_known_coefficient_comes_back(recordings):
    truth, logs = recordings(D_A)
    first, found = extended(truth, logs, AddedEffect(ASYMMETRIC, AxisSite(AXIS)))
    d_a = asymmetry(found)
    assert d_a.value == pytest.approx(D_A, abs=max(3.0 * d_a.std, 0.02 * D_A))
    assert d_a.std < 0.05 * D_A
    assert (d_a.unit, d_a.prior, d_a.identifiable) == ("N·m·s/rad", 0.0, True)
    assert found.model.identified.added.tolist() == [d_a.value]
    rmse = [
        next(f.rmse_moving for f in each.validation if f.held_out and f.channel == "tau.j2") for each in (first, found)
    ]
    assert rmse[1] < 0.5 * rmse[0]


@pytest.mark.slow
def test_an_effect_that_is_not_there_is_zero_within_its_standard_deviation(recordings):
    truth, logs = recordings(0.0)
    d_a = asymmetry(extended(truth, logs, AddedEffect(ASYMMETRIC, AxisSite(AXIS)))[1])
    assert abs(d_a.value) < 2.5 * d_a.std
    assert d_a.std < 0.1


def test_predictions_hold_the_added_torque(recordings):
    truth, logs = recordings(D_A)
    model = extended(truth, logs, AddedEffect(ASYMMETRIC, AxisSite(AXIS)))[1].model
    prepared = model.prepare(logs[2].log)
    both = [model.identified, replace(model.identified, added=np.zeros(1))]
    with_it, without = predictions(model.equations, prepared, both)
    (signals,) = axis_signals(model.extension.parent, prepared, [AXIS])
    moving = prepared.raw_direction[:, AXIS] != 0.0  # at rest static friction answers to it
    more = model.identified.added[0] * np.abs(signals.velocity)  # what the motor has to give beyond
    np.testing.assert_allclose((with_it["tau.j2"] - without["tau.j2"])[moving], more[moving], atol=1e-9)
    for other in ("tau.j1", "tau.j3"):
        np.testing.assert_array_equal(with_it[other], without[other])


def test_the_supporting_torque_and_its_slopes_know_the_added_torque(recordings):
    truth, logs = recordings(D_A)
    model = extended(truth, logs, AddedEffect(RIPPLE, AxisSite(0), (5.0,)), AddedEffect(ASYMMETRIC, AxisSite(AXIS)))[
        1
    ].model
    prepared, joints = model.prepare(logs[2].log), np.arange(3)
    plain = replace(model, identified=replace(model.identified, added=np.zeros(3)))
    more = balance(model, prepared, joints).torque - balance(plain, prepared, joints).torque
    delivered = prepared.added * model.identified.added
    expected = -np.column_stack([delivered[:, 0] + delivered[:, 1], delivered[:, 2], np.zeros(len(more))])
    np.testing.assert_allclose(more, expected, atol=1e-9)
    samples = prepared.kept[::50]
    for place, slope in slopes(model, prepared, samples, joints):
        np.testing.assert_allclose(slope[:, -3:] @ model.identified.added, expected[samples, place], atol=1e-9)


@pytest.mark.slow
def test_columns_are_named_after_effect_and_coefficient(recordings):
    truth, logs = recordings(0.0)
    found = extended(truth, logs, AddedEffect(ASYMMETRIC, AxisSite(AXIS)), AddedEffect(RIPPLE, AxisSite(2), (5.0,)))[1]
    assert [(each.name, each.place) for each in found.model.equations.added] == [
        ("asym_viscous.d_a", "j2"), ("torque_ripple.ripple_sin", "j3"), ("torque_ripple.ripple_cos", "j3"),
    ]  # fmt: skip
    assert {"asym_viscous.d_a[j2]", "torque_ripple.ripple_cos[j3]"} <= {each.name for each in found.parameters}


def same(one, other):
    for field in fields(one):
        if field.name not in ("model", "predictions"):
            left, right = getattr(one, field.name), getattr(other, field.name)
            np.testing.assert_equal(left, right, err_msg=field.name)
    for left, right in zip(one.predictions, other.predictions, strict=True):
        np.testing.assert_equal(dict(left.channels().predicted), dict(right.channels().predicted))
    np.testing.assert_array_equal(one.model.covariance, other.model.covariance)


@pytest.mark.parametrize("actuation", ["torque", "current"])
def test_adding_nothing_changes_nothing(make_truth, make_log, actuation):
    truth = make_truth(actuation == "current", actuation=actuation)
    logs = [Recording(make_log(truth, seed, seconds=15.0, noise=1.0), seed == 9) for seed in (1, 9)]
    one, other = extended(truth, logs)
    same(one, other)
    assert one.parameters == other.parameters


@pytest.mark.slow
def test_noise_floors_of_the_parent_are_kept(recordings):
    truth, logs = recordings(D_A)
    first = identify(truth.robot, logs, Settings(cutoff_hz=8.0))
    floors = floors_of(first.validation)
    extension = Extension(first.model, (AddedEffect(ASYMMETRIC, AxisSite(AXIS)),), floors)
    again = identify(truth.robot, logs, Settings(cutoff_hz=8.0), extension=extension)
    assert floors_of(again.validation) == floors


@pytest.mark.slow
def test_effects_see_the_robot_as_it_is_identified_with_them(recordings):
    truth, logs = recordings(D_A)
    settings = Settings(cutoff_hz=8.0)
    first = identify(truth.robot, logs, settings)
    extension = Extension(first.model, (AddedEffect(ASYMMETRIC, AxisSite(AXIS)),), floors_of(first.validation))
    seen = seen_by_effects(truth.robot, logs, settings, extension)
    told = identify(truth.robot, logs, settings, extension=extension).model
    for own, other in ((seen.identified, told.identified), (seen.a_priori, told.a_priori), (seen.sizes, told.sizes)):
        for name, values in vars(other).items():
            np.testing.assert_array_equal(getattr(own, name), values, err_msg=name)
    assert (seen.order, seen.cutoff_hz) == (told.order, told.cutoff_hz)


def test_the_cut_off_is_the_parents(make_truth, make_log):
    truth = make_truth(False, actuation="torque")
    logs = [Recording(make_log(truth, 1, seconds=15.0, noise=0.3), False)]
    first = identify(truth.robot, logs, Settings(cutoff_hz=6.0))
    again = identify(
        truth.robot, logs, Settings(), extension=Extension(first.model, (AddedEffect(ASYMMETRIC, AxisSite(0)),))
    )
    assert again.cutoff_hz == 6.0


def test_effects_see_the_load_of_the_bodies_and_the_drive_that_the_model_calls_for(make_truth, make_log):
    truth = make_truth(False, actuation="torque")
    log = make_log(truth, 1)  # without noise
    model = identify(truth.robot, [Recording(log, False)], Settings(cutoff_hz=8.0)).model
    prepared = model.prepare(log)
    for axis, signals in enumerate(axis_signals(model, prepared, [0, 1, 2])):
        steady = prepared.steady[:, axis]
        measured = log.channels[f"tau.j{axis + 1}"]
        friction = truth.xi["k_d"][axis] * signals.velocity + truth.xi["tau_c"][axis] * signals.direction
        friction = friction + truth.xi["J_r"][axis] * signals.acceleration - truth.xi["tau_o"][axis]
        size = np.std(measured)
        left, other = (signals.drive - measured)[steady], (signals.load - (measured - friction))[steady]
        assert np.sqrt(np.mean(left**2)) < 0.03 * size
        assert np.std(other) < 0.05 * size
        np.testing.assert_array_equal(signals.load, loads(model, prepared)[:, axis])


def test_noise_of_the_measured_torque_stays_out_of_what_effects_see(make_truth, make_log):
    truth = make_truth(False, actuation="torque")
    log, rng = make_log(truth, 1, noise=0.3), np.random.default_rng(3)
    model = identify(truth.robot, [Recording(log, False)], Settings(cutoff_hz=8.0)).model
    noisy = {name: log.channels[name] + rng.normal(size=log.samples) for name in ("tau.j1", "tau.j2", "tau.j3")}
    again = Log("noisy", log.time, {**log.channels, **noisy})
    quiet, shaken = (axis_signals(model, model.prepare(each), [0, 1, 2]) for each in (log, again))
    for one, other in zip(quiet, shaken, strict=True):
        np.testing.assert_array_equal(one.drive, other.drive)
        np.testing.assert_array_equal(one.load, other.load)
