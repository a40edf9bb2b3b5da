"""The contract that every file in the catalogue keeps."""

import numpy as np
import pytest

from exogauge.effects.catalogue import all_effects
from exogauge.effects.effect import JointSignals, Quantity
from exogauge.identification.settings import Settings

FRICTION = ("viscous", "coulomb", "static_friction")
UNITS = {"N·m", "N·m/A", "N·m·s/rad", "kg·m²"}

every_effect = pytest.mark.parametrize("effect", all_effects().values(), ids=list(all_effects()))


def signals(samples=400, still=False, seed=0):
    """A joint that runs, stops and turns; still: one that rests under a torque that changes its sign."""
    rng = np.random.default_rng(seed)
    velocity = np.zeros(samples) if still else np.cumsum(rng.normal(size=samples)) / 10
    direction = np.where(np.abs(velocity) < 0.2, 0.0, np.sign(velocity))
    rest = 1.0 - np.abs(direction)
    return JointSignals(
        drive=rng.normal(size=samples),
        velocity=velocity,
        acceleration=np.gradient(velocity) * 200.0,
        direction=direction,
        rest=rest,
        stick=rest * np.sign(rng.normal(size=samples)),
    )


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 400])
def test_the_column_is_finite_and_has_a_row_per_sample(effect, samples):
    seen = signals(400)
    part = JointSignals(**{name: values[:samples] for name, values in vars(seen).items()})
    column = effect.column(part)
    assert column.shape == (samples,)
    assert column.dtype == np.float64
    assert np.isfinite(column).all()


@every_effect
def test_the_column_says_something(effect):
    assert np.any(effect.column(signals()) != 0.0)


@every_effect
def test_the_column_leaves_the_signals_as_they_are(effect):
    seen, fresh = signals(), signals()
    column = effect.column(seen)
    for name, values in vars(seen).items():
        np.testing.assert_array_equal(values, getattr(fresh, name))
    before = column.copy()
    effect.column(signals(seed=1))  # nor does a later call change what an earlier one gave
    np.testing.assert_array_equal(column, before)


@every_effect
def test_each_sample_stands_alone_so_that_chunks_do_not_matter(effect):
    seen = signals()
    whole = effect.column(seen)
    halves = [JointSignals(**{k: v[part] for k, v in vars(seen).items()}) for part in (slice(0, 150), slice(150, None))]
    np.testing.assert_array_equal(whole, np.concatenate([effect.column(half) for half in halves]))


@every_effect
def test_the_coefficient_has_a_name_a_unit_and_a_range_that_holds_zero(effect):
    quantity = effect.coefficient
    assert isinstance(quantity, Quantity)
    assert quantity.name.isidentifier()
    assert quantity.unit in UNITS
    assert quantity.low <= 0.0 < quantity.high


@every_effect
def test_a_user_is_told_in_a_sentence(effect):
    assert effect.sentence[0].isupper()
    assert effect.sentence.endswith(".")
    assert len(effect.sentence.split()) >= 4


def test_no_two_effects_estimate_a_coefficient_of_the_same_name():
    names = [effect.coefficient.name for effect in all_effects().values()]
    assert len(set(names)) == len(names)


def test_what_is_fitted_by_default_is_in_the_catalogue():
    assert set(Settings().effects) <= set(all_effects())


@pytest.mark.parametrize("name", FRICTION)
def test_friction_takes_energy_out_of_every_motion_and_never_puts_any_in(name):
    effect, seen = all_effects()[name], signals()
    assert effect.coefficient.low == 0.0
    assert np.all(effect.column(seen) * seen.velocity * (seen.direction != 0.0) <= 0.0)


def test_static_friction_holds_against_what_pushes():
    seen = signals(still=True)
    np.testing.assert_array_equal(np.sign(all_effects()["static_friction"].column(seen)), -np.sign(seen.stick))


def test_rotor_inertia_takes_as_much_energy_to_start_as_it_gives_back_at_the_stop():
    t = np.linspace(0.0, 1.0, 2001)
    seen = signals(len(t))
    smooth = JointSignals(
        seen.drive, np.sin(np.pi * t), np.pi * np.cos(np.pi * t), np.ones_like(t), seen.rest, seen.stick
    )
    power = all_effects()["rotor_inertia"].column(smooth) * smooth.velocity
    assert power.min() < -0.1
    assert abs(np.trapezoid(power, t)) < 1e-6
