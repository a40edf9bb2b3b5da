"""How a real effect may depart from the formula that it is named by."""

import numpy as np
import pytest

from exogauge.effects.catalogue import sensor_effects, shaped_effects
from exogauge.effects.places import SensorSignals
from exogauge.effects.shaped import AxisSignals
from exogauge.search.residual_correction import OwnCurve, possible_terms

EFFECTS = {**shaped_effects(), **sensor_effects()}
every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


def signals(effect, samples=3000):
    t = np.arange(samples) / 100.0
    if effect.place == "sensor":
        waves = np.stack([np.sin(2.0 * np.pi * f * t) for f in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)], axis=1)
        return SensorSignals(t, waves * np.array([8.0, 8.0, 8.0, 0.6, 0.6, 0.3]), 2, contacts=1)
    w = 2.0 * np.pi * 0.4
    q, v, a = np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)
    load = 5.0 * np.sin(q + 0.4)
    return AxisSignals(t, q, v, a, np.sign(v), load + np.sign(v), load, 25.0 + t, 1.8, 4.0, 2.0)


def first_shape(effect):
    return tuple(one.grid[0] for one in effect.shapes)


def curve(effect, *terms):
    own = effect.columns(signals(effect), first_shape(effect))
    return OwnCurve(effect, tuple(np.sqrt(np.mean(own**2, axis=0))), terms or tuple(range(len(possible_terms(effect)))))


@every_effect
def test_there_is_one_finite_column_per_coefficient_and_each_has_a_name_of_its_own(effect):
    bent = curve(effect)
    columns = bent.columns(signals(effect), first_shape(effect))
    assert columns.shape == (3000, len(bent.coefficients))
    assert np.isfinite(columns).all()
    names = [each.name for each in (*effect.coefficients, *bent.coefficients)]
    assert len(set(names)) == len(names)
    assert (bent.place, bent.shapes) == (effect.place, effect.shapes)
    assert bent.name not in EFFECTS


@every_effect
def test_a_part_of_the_terms_is_that_part_of_the_columns(effect):
    seen, shape = signals(effect), first_shape(effect)
    last = len(possible_terms(effect)) - 1
    np.testing.assert_array_equal(
        curve(effect, last, 0).columns(seen, shape), curve(effect).columns(seen, shape)[:, [last, 0]]
    )
    assert curve(effect, last).coefficients == (curve(effect).coefficients[last],)


def test_friction_over_the_square_of_the_load_is_a_bend_of_friction_over_the_load():
    effect = EFFECTS["load_coulomb"]
    seen, bent = signals(effect), curve(effect, 0)
    squared = -(seen.load**2) * seen.direction
    (column,) = bent.columns(seen, ()).T
    np.testing.assert_allclose(column * bent.sizes[0], squared, rtol=1e-12)


def test_a_second_harmonic_is_a_bend_of_a_ripple():
    effect = EFFECTS["torque_ripple"]
    seen = signals(effect)
    phase = 2.0 * np.pi * 2.0 * 5.0 / seen.range * seen.position
    columns = OwnCurve(effect, (1.0, 1.0), (0, 1)).columns(seen, (5.0,))
    np.testing.assert_allclose(columns, np.stack([np.sin(phase), np.cos(phase)], axis=1), atol=1e-12)


@pytest.mark.parametrize("name", ["stribeck", "elasticity", "thermal_viscous", "torque_offset_drift"])
def test_terms_along_a_shape_lead_to_the_columns_of_a_shape_nearby(name):
    effect = EFFECTS[name]
    seen, step = signals(effect), 1e-3
    shape = tuple(one.at(0.4) for one in effect.shapes)
    bent = OwnCurve(effect, (1.0,) * len(effect.coefficients), tuple(range(len(possible_terms(effect)))))
    along = [k for k, each in enumerate(bent.coefficients) if "_along_" in each.name]
    for place, one in enumerate(effect.shapes):
        nearby = (*shape[:place], one.at(0.4 + step), *shape[place + 1 :])
        change = effect.columns(seen, nearby) - effect.columns(seen, shape)
        own = [k for k in along if bent.coefficients[k].name.endswith(f"_along_{one.name}")]
        told = step * bent.columns(seen, shape)[:, own]
        assert np.abs(change - told).max() < 0.1 * np.abs(change).max()
