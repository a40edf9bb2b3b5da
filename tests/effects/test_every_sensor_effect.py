"""The contract that every effect of a force/torque sensor keeps."""

import importlib
import itertools
from dataclasses import fields, replace

import numpy as np
import pytest

from exogauge.effects.catalogue import all_effects, sensor_effects, shaped_effects
from exogauge.effects.places import SensorSignals

COORDINATES = {"time", "reading"}
WORDS = {
    "mass",
    "first moments",
    "zero",
    "the sensor's frame",
    "base_tilt",
}  # bodies that may stand in for one
MOST_COLUMNS = 70  # on one component, over all effects and shapes: a sensor has six of them
EFFECTS = dict(sensor_effects())

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
every_component = pytest.mark.parametrize("component", range(6))


AT_CONTACTS = {"ft_zero"}  # where no model has a zero


def signals(component=0, samples=3000, seed=0, of=None):
    """A tool that is turned through all postures: every component takes both signs. of: an effect; those of contact
    sensors alone see one."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / 100.0
    phase = rng.uniform(0.0, 6.0, (4, 6))
    waves = [np.sin(2.0 * np.pi * f * t[:, None] + p) for f, p in zip((0.05, 0.13, 0.4, 0.9), phase, strict=True)]
    return SensorSignals(t, np.sum(waves, axis=0) * np.array([8.0, 8.0, 8.0, 0.6, 0.6, 0.3]), component, -1,
                         int(of is not None and of.name in AT_CONTACTS))  # fmt: skip


def cut(whole, part):
    return replace(whole, time=whole.time[part], expected=whole.expected[part])


def shapes_of(effect):
    """All grid points, and both ends of every range that is one."""
    yield from itertools.product(*(one.grid if one.choice else (one.low, *one.grid, one.high) for one in effect.shapes))


def is_itself(effect, shape, component):
    """A component does not leak into itself."""
    return effect.name == "ft_crosstalk" and round(shape[0]) == component


@every_effect
@every_component
def test_columns_are_finite_one_per_coefficient_at_every_shape(effect, component):
    whole = signals(component, of=effect)
    for shape in shapes_of(effect):
        columns = effect.columns(whole, shape)
        assert columns.shape == (len(whole.time), len(effect.coefficients))
        assert columns.dtype == np.float64
        assert np.isfinite(columns).all()
        assert np.any(columns != 0.0, axis=0).all() != is_itself(effect, shape, component)


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 2, 3, 9])
def test_a_log_of_a_few_samples_is_no_special_case(effect, samples):
    short = cut(signals(of=effect), slice(500, 500 + samples))
    shown = False
    for shape in shapes_of(effect):
        columns = effect.columns(short, shape)
        assert columns.shape == (samples, len(effect.coefficients))
        assert np.isfinite(columns).all()
        shown |= bool(columns.any())
    assert effect.applies(short) is False or (shown and samples > 0)  # what cannot be seen is not looked for


@every_effect
def test_it_applies_to_a_tool_that_is_turned(effect):
    assert effect.applies(signals(of=effect))


def test_what_is_a_contact_sensors_alone_is_not_looked_for_inside_the_robot():
    for name in AT_CONTACTS:
        assert not EFFECTS[name].applies(signals())
        assert not EFFECTS[name].columns(signals(), (-1.0,)).any()


@every_effect
def test_the_signals_stay_as_they_are_and_so_does_what_was_returned(effect):
    whole, fresh = signals(), signals()
    shape = tuple(one.grid[-1] for one in effect.shapes)
    columns = effect.columns(whole, shape)
    before = columns.copy()
    effect.columns(signals(seed=1), shape)
    np.testing.assert_array_equal(columns, before)
    for field in fields(whole):
        np.testing.assert_array_equal(getattr(whole, field.name), getattr(fresh, field.name))


@every_effect
def test_it_does_not_know_the_measured_reading(effect):
    """Its own noise would explain itself: all it gets is what the model's bodies ask for."""
    quiet = SensorSignals(signals().time, np.zeros((3000, 6)), 0)
    for shape in shapes_of(effect):
        assert effect.name == "ft_drift" or not effect.columns(quiet, shape).any()


@every_effect
def test_a_small_change_of_a_shape_is_a_small_change_of_the_reading(effect):
    whole = signals()
    for shape in itertools.product(*(one.grid for one in effect.shapes)):
        first = effect.columns(whole, shape)
        for k, one in enumerate(effect.shapes):
            step = 1e-4 * shape[k]
            moved = effect.columns(whole, (*shape[:k], shape[k] + step, *shape[k + 1 :]))
            assert one.choice or np.linalg.norm(moved - first) <= 0.02 * np.linalg.norm(first)


@pytest.mark.parametrize("effect", [each for name, each in EFFECTS.items() if name not in AT_CONTACTS])
def test_what_never_changes_is_the_sensors_zero_and_no_effect(effect):
    for shape in itertools.product(*(one.grid for one in effect.shapes)):
        for column in effect.columns(signals(), shape).T:
            assert np.ptp(column) > 1e-3 * np.abs(column).max() or is_itself(effect, shape, 0)


@every_effect
def test_what_it_is_confused_with_and_plotted_over_is_known(effect):
    assert effect.confounds
    assert set(effect.confounds) <= WORDS | set(EFFECTS) | set(all_effects())
    assert effect.coordinate in COORDINATES
    assert effect.place == "sensor"


@every_effect
def test_the_effect_is_found_under_the_name_of_its_file(effect):
    assert importlib.import_module(f"exogauge.effects.{effect.name}").EFFECT is effect


def test_a_search_stays_affordable():
    points = {name: int(np.prod([len(one.grid) for one in effect.shapes])) for name, effect in EFFECTS.items()}
    columns = {name: points[name] * len(effect.coefficients) for name, effect in EFFECTS.items()}
    assert sum(columns[name] for name in columns if name not in AT_CONTACTS) <= MOST_COLUMNS
    assert sum(columns.values()) <= 1.15 * MOST_COLUMNS, "under a foot"


def test_no_two_effects_bear_the_same_name():
    assert not set(EFFECTS) & (set(shaped_effects()) | set(all_effects()))
    names = [each.name for effect in EFFECTS.values() for each in effect.coefficients]
    assert len(set(names)) == len(names)


def test_a_gain_reads_in_proportion_and_a_leak_is_the_other_components_own():
    whole = signals(component=4)
    np.testing.assert_array_equal(EFFECTS["ft_gain"].columns(whole, ())[:, 0], whole.expected[:, 4])
    np.testing.assert_array_equal(EFFECTS["ft_crosstalk"].columns(whole, (2.0,))[:, 0], whole.expected[:, 2])


def test_a_drift_is_a_ramp_and_what_settles():
    whole = signals(samples=3001)  # 30 s
    ramp, settling = EFFECTS["ft_drift"].columns(whole, (5.0, -1.0)).T
    assert (ramp[0], settling[0]) == (0.0, 0.0)
    assert ramp[-1] == pytest.approx(30.0)
    assert settling[500] == pytest.approx(1.0 - np.exp(-1.0))
    assert not EFFECTS["ft_drift"].applies(cut(whole, slice(0, 300)))  # three seconds show no drift


def test_a_drift_of_one_log_leaves_the_others_alone():
    third = replace(signals(), number=2)
    assert EFFECTS["ft_drift"].columns(third, (5.0, 2.0)).any()
    assert not EFFECTS["ft_drift"].columns(third, (5.0, 1.0)).any()
    assert EFFECTS["ft_drift"].columns(third, (5.0, -1.0)).any()
