"""The contract that every effect of two neighbouring joints keeps."""

import importlib
import itertools
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from exogauge.effects.catalogue import (
    all_effects,
    base_effects,
    link_effects,
    pair_effects,
    sensor_effects,
    shaped_effects,
)
from exogauge.effects.places import PairSignals
from exogauge.effects.shaped import AxisSignals

COORDINATES = {"motor_velocity", "time"}
MOST_COLUMNS = 60  # on one pair, over all effects and shapes; each is in two rows
RATE = 200.0
EFFECTS = dict(pair_effects())

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


def axis(samples=6000, seed=0, waves=(3, 7, 16, 40)):
    """A joint that runs, stops and turns, over a motion that ends where it began."""
    t = np.arange(samples) / RATE
    phases = zip(waves, np.random.default_rng(seed).uniform(0.0, 6.0, 4), strict=True)
    q = 0.5 * np.sum([np.sin(2.0 * np.pi * k * t / t[-1] + phase) for k, phase in phases], axis=0)
    v = np.gradient(q, 1.0 / RATE)
    a = np.gradient(v, 1.0 / RATE)
    direction, load = np.where(np.abs(v) < 0.02, 0.0, np.sign(v)), 0.3 * a + 6.0 * np.sin(q)
    return AxisSignals(t, q, v, a, direction, load + 0.3 * v, load, None, 0.5, 3.0, float(np.ptp(q)))


def still(samples=6000):
    z = np.zeros(samples)
    return AxisSignals(np.arange(samples) / RATE, z, z, z, z, z, z, None, 0.0, 0.0, 0.0)


def both(seed=0):
    return PairSignals(axis(seed=2 * seed), axis(seed=2 * seed + 1, waves=(4, 9, 13, 35)))


def cut(whole, part):
    def short(one):
        arrays = [f.name for f in fields(one) if np.ndim(getattr(one, f.name)) == 1]
        return replace(one, **{name: getattr(one, name)[part] for name in arrays})

    return PairSignals(short(whole.own), short(whole.other))


def shapes_of(effect):
    yield from itertools.product(*((one.low, *one.grid, one.high) for one in effect.shapes))


@every_effect
def test_columns_are_finite_one_per_coefficient_and_axis_at_every_shape(effect):
    for shape in shapes_of(effect):
        columns = effect.columns(both(), shape)
        assert columns.shape == (6000, len(effect.coefficients), 2)
        assert columns.dtype == np.float64
        assert np.isfinite(columns).all()
        assert np.any(columns != 0.0, axis=0).all()


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 2, 3, 9])
def test_a_log_of_a_few_samples_is_no_special_case(effect, samples):
    short = cut(both(), slice(1000, 1000 + samples))
    shown = False
    for shape in shapes_of(effect):
        columns = effect.columns(short, shape)
        assert columns.shape == (samples, len(effect.coefficients), 2)
        assert np.isfinite(columns).all()
        shown |= bool(columns.any())
    assert effect.applies(short) is False or (shown and samples > 0)  # what cannot be seen is not looked for


@every_effect
def test_it_applies_where_both_move_and_not_where_one_stands_still(effect):
    assert effect.applies(both())
    for pair in (PairSignals(axis(), still()), PairSignals(still(), axis()), PairSignals(still(), still())):
        assert not effect.applies(pair)


@every_effect
def test_two_joints_that_always_move_alike_are_no_evidence(effect):
    assert not effect.applies(PairSignals(axis(), axis()))


@every_effect
def test_what_stands_still_is_not_blamed(effect):
    for shape in shapes_of(effect):
        assert not effect.columns(PairSignals(still(), still()), shape).any()


@every_effect
def test_the_signals_stay_as_they_are_and_so_does_what_was_returned(effect):
    whole, fresh = both(), both()
    shape = tuple(one.grid[0] for one in effect.shapes)
    columns = effect.columns(whole, shape)
    before = columns.copy()
    effect.columns(both(seed=1), shape)
    np.testing.assert_array_equal(columns, before)
    for one, other in ((whole.own, fresh.own), (whole.other, fresh.other)):
        for field in fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


@every_effect
def test_a_small_change_of_a_shape_is_a_small_change_of_the_torque(effect):
    """Behind a low-pass, as whoever fits sees it."""
    whole, smooth = both(), butter(4, 10.0, fs=RATE, output="sos")
    for shape in itertools.product(*(one.grid for one in effect.shapes)):
        first = sosfiltfilt(smooth, effect.columns(whole, shape), axis=0)
        for k, one in enumerate(effect.shapes):
            moved = (*shape[:k], shape[k] + 1e-4 * (one.high - one.low), *shape[k + 1 :])
            change = sosfiltfilt(smooth, effect.columns(whole, moved), axis=0) - first
            assert np.linalg.norm(change) <= 0.02 * np.linalg.norm(first)


@every_effect
def test_nothing_of_it_is_friction_or_inertia_of_each_joint_by_itself(effect):
    """Else the model would have it already, and what is left would be noise."""
    whole = both()
    plain = [column for one in (whole.own, whole.other) for column in (one.direction, one.velocity, one.acceleration)]
    own, other = (np.linalg.qr(np.stack(part, axis=1))[0] for part in (plain[:3], plain[3:]))
    for shape in itertools.product(*(one.grid for one in effect.shapes)):
        columns = effect.columns(whole, shape)
        for c in range(columns.shape[1]):
            left = [columns[:, c, k] - Q @ (Q.T @ columns[:, c, k]) for k, Q in enumerate((own, other))]
            assert np.hypot(*map(np.linalg.norm, left)) > 0.1 * np.linalg.norm(columns[:, c])


@every_effect
def test_what_it_is_confused_with_and_plotted_over_is_known(effect):
    assert effect.confounds
    assert set(effect.confounds) <= set(EFFECTS) | set(shaped_effects()) | set(all_effects())
    assert effect.coordinate in COORDINATES
    assert effect.place == "pair"


@every_effect
def test_the_effect_is_found_under_the_name_of_its_file(effect):
    assert importlib.import_module(f"exogauge.effects.{effect.name}").EFFECT is effect


def test_a_search_stays_affordable():
    points = {name: int(np.prod([len(one.grid) for one in effect.shapes])) for name, effect in EFFECTS.items()}
    assert sum(points[name] * len(effect.coefficients) for name, effect in EFFECTS.items()) <= MOST_COLUMNS


def test_no_two_effects_or_coefficients_bear_the_same_name():
    others = (shaped_effects(), sensor_effects(), base_effects(), link_effects())
    assert not set(EFFECTS) & {*all_effects(), *itertools.chain(*others)}
    names = [
        each.name for part in (shaped_effects(), EFFECTS) for effect in part.values() for each in effect.coefficients
    ]
    names += [effect.coefficient.name for effect in all_effects().values()]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("ratio", [-1.0, 0.5, 2.0])
def test_what_drags_at_a_motor_takes_power_from_both_joints_together(ratio):
    """Virtual work: on both joints together it does the work that it does at the motor."""
    whole = both()
    columns = EFFECTS["coupling"].columns(whole, (ratio,))
    speeds = np.stack([whole.own.velocity, whole.other.velocity], axis=1)
    at_the_motor = whole.own.velocity + ratio * whole.other.velocity
    rate = np.einsum("tck,tk->tc", columns, speeds)
    np.testing.assert_allclose(rate[:, 1], -(at_the_motor**2), atol=1e-12)
    assert np.all(rate[:, 0] <= 0.0)
    kinetic = 0.5 * at_the_motor**2
    np.testing.assert_allclose(
        np.trapezoid(rate[1000:5000, 2], whole.time[1000:5000]), kinetic[1000] - kinetic[4999], rtol=5e-3
    )
