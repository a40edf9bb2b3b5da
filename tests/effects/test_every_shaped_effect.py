"""The contract that every effect keeps which a model may miss."""

import importlib
import itertools
from collections import Counter
from copy import deepcopy
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from exogauge.effects.catalogue import all_effects, shaped_effects
from exogauge.effects.shaped import AxisSignals, in_si

COORDINATES = {"velocity", "position", "load", "time", "acceleration", "drive", "temperature"}
MOST_COLUMNS = 64  # of one effect on one axis, over all shapes: each is made for every joint and log of a robot, and
# torque ripple, which has to try its orders one by one, takes 62
DISSIPATIVE = ("stribeck", "load_coulomb", "nonlinear_viscous", "presliding")
CONSERVATIVE = ("joint_spring", "torque_ripple")
EFFECTS = dict(shaped_effects())

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


@cache
def signals(samples=6000, rate=200.0, seed=0, temperature=False):
    """A joint that runs, stops and turns under a load of both signs, over a motion that ends where it began."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / rate
    phases = zip((3, 7, 16, 40), rng.uniform(0.0, 6.0, 4), strict=True)
    turns = [np.sin(2.0 * np.pi * k * t / t[-1] + phase) for k, phase in phases]
    q = np.sum(turns, axis=0) * 0.5
    v = np.gradient(q, 1.0 / rate)
    a = np.gradient(v, 1.0 / rate)
    load = 0.3 * a + 6.0 * np.sin(q) + 3.0 * np.sin(2.0 * np.pi * 0.4 * t)
    return AxisSignals(
        time=t,
        position=q,
        velocity=v,
        acceleration=a,
        direction=np.where(np.abs(v) < 0.02, 0.0, np.sign(v)),
        drive=load + 0.5 * np.sign(v) + 0.3 * v,
        load=load,
        temperature=20.0 + 15.0 * (1.0 - np.exp(-t / 10.0)) if temperature else None,
        speed_scale=float(np.sqrt(np.mean(v**2))),
        torque_scale=float(np.sqrt(np.mean(load**2))),
        range=float(np.ptp(q)),
    )


def still(samples=500, load=3.0):
    z = np.zeros(samples)
    return AxisSignals(np.arange(samples) / 200.0, z + 0.3, z, z, z, z + load, z + load, None, 0.0, abs(load), 0.0)


def cut(whole, part):
    """Some samples of a log; the axis' sizes stay."""
    return replace(
        whole, **{f.name: getattr(whole, f.name)[part] for f in fields(whole) if np.ndim(getattr(whole, f.name)) == 1}
    )


def shapes_of(effect):
    """All grid points, and both ends of every range."""
    yield from itertools.product(*((one.low, *one.grid, one.high) for one in effect.shapes))


@pytest.mark.parametrize(
    "effect",
    [pytest.param(each, id=name, marks=[pytest.mark.slow] * (name == "backlash")) for name, each in EFFECTS.items()],
)
@pytest.mark.parametrize("temperature", [False, True])
def test_columns_are_finite_one_per_coefficient_at_every_shape(effect, temperature):
    whole = signals(samples=2000, temperature=temperature)
    for shape in shapes_of(effect):
        columns = effect.columns(whole, shape)
        assert columns.shape == (len(whole.time), len(effect.coefficients))
        assert columns.dtype == np.float64
        assert np.isfinite(columns).all()
        assert np.any(columns != 0.0, axis=0).all()


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 2, 3, 5, 9])
@pytest.mark.parametrize("temperature", [False, True])
def test_a_log_of_a_few_samples_is_no_special_case(effect, samples, temperature):
    short = cut(signals(temperature=temperature), slice(1000, 1000 + samples))
    shown = False
    for shape in shapes_of(effect):
        columns = effect.columns(short, shape)
        assert columns.shape == (samples, len(effect.coefficients))
        assert np.isfinite(columns).all()
        shown |= bool(columns.any())
    assert effect.applies(short) is False or (shown and samples > 0)  # what cannot be seen is not looked for


@every_effect
@pytest.mark.parametrize("load", [0.0, -3.0])
def test_a_joint_that_stands_still_shows_nothing_infinite(effect, load):
    for shape in shapes_of(effect):
        columns = effect.columns(still(load=load), shape)
        assert columns.shape == (500, len(effect.coefficients))
        assert np.isfinite(columns).all()


@every_effect
def test_a_joint_that_stands_still_is_blamed_for_drift_alone(effect):
    assert not effect.applies(still(2000)) or effect.name == "torque_offset_drift"


@every_effect
def test_it_applies_to_a_joint_that_does_everything(effect):
    assert effect.applies(signals())
    assert effect.applies(signals(temperature=True))


@every_effect
def test_the_signals_stay_as_they_are_and_so_does_what_was_returned(effect):
    whole = signals(temperature=True)
    fresh = deepcopy(whole)
    shape = tuple(one.grid[0] for one in effect.shapes)
    columns = effect.columns(whole, shape)
    before = columns.copy()
    effect.columns(signals(seed=1), shape)
    np.testing.assert_array_equal(columns, before)
    for field in fields(whole):
        np.testing.assert_array_equal(getattr(whole, field.name), getattr(fresh, field.name))


@every_effect
def test_a_small_change_of_a_shape_is_a_small_change_of_the_torque(effect):
    """Behind a low-pass, as whoever fits sees it."""
    whole, smooth = signals(), butter(4, 10.0, fs=200.0, output="sos")
    for shape in itertools.product(*(one.grid for one in effect.shapes)):
        first = sosfiltfilt(smooth, effect.columns(whole, shape), axis=0)
        for k, one in enumerate(effect.shapes):
            step = 1e-4 * (one.high - one.low if one.low <= 0.0 else shape[k])
            moved = (*shape[:k], shape[k] + step, *shape[k + 1 :])
            change = sosfiltfilt(smooth, effect.columns(whole, moved), axis=0) - first
            assert np.linalg.norm(change) <= 0.02 * np.linalg.norm(first)


@every_effect
def test_what_it_is_confused_with_and_plotted_over_is_known(effect):
    assert effect.confounds
    assert set(effect.confounds) <= set(all_effects()) | set(shaped_effects())
    assert effect.coordinate in COORDINATES


@every_effect
def test_the_effect_is_found_under_the_name_of_its_file(effect):
    assert importlib.import_module(f"exogauge.effects.{effect.name}").EFFECT is effect


@every_effect
def test_a_search_stays_affordable(effect):
    points = int(np.prod([len(one.grid) for one in effect.shapes]))
    assert points * len(effect.coefficients) <= MOST_COLUMNS


def test_no_two_coefficients_bear_the_same_name():
    """A model may have both at one joint, and tells its numbers by their names."""
    names = Counter(each.name for effect in shaped_effects().values() for each in effect.coefficients)
    names.update(effect.coefficient.name for effect in all_effects().values())
    assert not [name for name, times in names.items() if times > 1]


@pytest.mark.parametrize("name", DISSIPATIVE)
def test_friction_takes_energy_out_of_a_closed_motion(name):
    effect, whole = EFFECTS[name], signals()
    assert all(each.low == 0.0 for each in effect.coefficients)
    for shape in shapes_of(effect):
        power = effect.columns(whole, shape) * whole.velocity[:, None]
        work, size = (np.trapezoid(each, whole.time, axis=0) for each in (power, np.abs(power)))
        assert np.all(work < -0.1 * size)


@pytest.mark.parametrize(
    "name", [name for name in DISSIPATIVE if name != "presliding"]
)  # which gives back what it bent
def test_friction_without_memory_puts_no_energy_in_at_any_moment(name):
    effect, whole = EFFECTS[name], signals()
    for shape in shapes_of(effect):
        assert np.all(effect.columns(whole, shape) * whole.velocity[:, None] <= 0.0)


@pytest.mark.parametrize("name", CONSERVATIVE)
def test_what_depends_on_the_position_gives_back_over_a_closed_motion_what_it_took(name):
    effect, whole = EFFECTS[name], signals()
    for shape in itertools.product(*(one.grid for one in effect.shapes)):
        power = effect.columns(whole, shape) * whole.velocity[:, None]
        assert np.all(
            np.abs(np.trapezoid(power, whole.time, axis=0)) < 0.02 * np.trapezoid(np.abs(power), whole.time, axis=0)
        )


def test_a_user_reads_shapes_in_si():
    assert in_si("rms velocity", 0.4, 6.0, 1.5) == (0.4, "rad/s")
    assert in_si("rms torque", 0.4, 6.0, 1.5) == (6.0, "N·m")
    assert in_si("range", 0.4, 6.0, 1.5) == (1.5, "rad")
    assert in_si("s", 0.4, 6.0, 1.5) == (1.0, "s")
    size, unit = in_si("cycles per range", 0.4, 6.0, np.pi)  # half a turn: one cycle over it is two in a revolution
    assert (size, unit) == (pytest.approx(2.0), "1/rev")
