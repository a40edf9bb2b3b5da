"""The contract that every force law keeps."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from exogauge.devices.laws.catalogue import all_laws
from exogauge.devices.laws.law import Quantity, WireMotion

UNITS = {"1", "m", "s", "N/m", "N/m²", "N·s/m"}
K, L_0 = 200.0, 0.6
SHARES = np.array([0.3, 0.1, 0.4, 0.2])  # of the segments in the length

every_law = pytest.mark.parametrize("law", all_laws().values(), ids=list(all_laws()))


def motion(length, time=None, seed=0):
    """Four segments that share a length, each with a sway of its own that adds up to nothing; wraps up to a radian."""
    time = np.arange(len(length)) * 0.01 if time is None else time
    sway = 0.02 * np.sin(3.0 * time[:, None] + np.arange(4))
    segments = length[:, None] * SHARES + sway - sway.mean(axis=1, keepdims=True)
    wrap = np.abs(np.sin(0.7 * time[:, None] + np.arange(3)))
    rate = np.gradient(length, time) if len(length) > 1 else np.zeros(len(length))
    return WireMotion(time, length, rate, segments, wrap)


def wandering(samples=3000, seed=0):
    """A length that wanders from 8 cm below the natural length to 20 cm above."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) * 0.01
    wave = sum(
        np.sin(2 * np.pi * f * t + p) for f, p in zip(rng.uniform(0.05, 1.2, 5), rng.uniform(0, 6, 5), strict=True)
    )
    return L_0 + 0.06 + 0.14 * wave / np.abs(wave).max()


def typical(law):
    return {value.name: value.typical for value in law.values}


def pull(law, seen, values=None):
    return law.tension(seen, K, L_0, typical(law) if values is None else values)


def segments_of(law, seen):
    return seen.segment_length if law.per_segment else seen.length


@every_law
@pytest.mark.parametrize("samples", [0, 1, 3000])
def test_tension_is_finite_never_negative_and_has_a_row_per_sample(law, samples):
    seen = motion(wandering()[:samples])
    tension = pull(law, seen)
    assert tension.shape == ((samples, 4) if law.per_segment else (samples,))
    assert tension.dtype == np.float64
    assert np.isfinite(tension).all()
    assert np.all(tension >= 0.0)


@every_law
def test_a_band_shorter_than_its_natural_length_is_slack(law):
    """Exactly, but for a transition: there it is slack to a millionth 7 cm below."""
    seen = motion(wandering())
    below = seen.length < L_0 - (0.07 if "transition" in typical(law) else 0.0)
    assert below.sum() > 10
    assert np.all(pull(law, seen)[below] <= 1e-6)


@every_law
def test_a_longer_band_pulls(law):
    seen = motion(np.linspace(L_0 + 0.05, L_0 + 0.15, 50))
    tension = pull(law, seen)
    assert np.all(tension > 0.0)
    assert np.all(tension[-1] > tension[0])


@every_law
def test_with_its_own_values_at_zero_the_law_is_the_linear_one(law):
    seen = motion(wandering())
    linear = K * np.maximum(seen.length - L_0, 0.0)
    tension = pull(law, seen, {value.name: 0.0 for value in law.values})
    assert np.abs(tension - (linear[:, None] if law.per_segment else linear)).max() < 1e-9


@every_law
def test_near_zero_the_law_is_near_the_linear_one(law):
    seen = motion(wandering())
    linear = K * np.maximum(seen.length - L_0, 0.0)
    tension = pull(law, seen, {name: 1e-6 * value for name, value in typical(law).items()})
    assert np.abs(tension - (linear[:, None] if law.per_segment else linear)).max() < 1e-3


@every_law
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("times", [1.0, 0.1, 10.0])
def test_no_cycle_gives_energy(law, seed, times):
    """∮ T·dl ≥ 0 over closed loops of any speed, begun where the band is slack, so that it ends as it began."""
    length = wandering(seed=seed)
    out = np.linspace(L_0 - 0.08, length[0], 200)
    length = np.concatenate([out, length, np.linspace(length[-1], L_0 - 0.08, 200), np.full(300, L_0 - 0.08)])
    seen = motion(length, np.arange(len(length)) * 0.01 * times)
    tension, way = pull(law, seen), segments_of(law, seen)
    energy = np.sum(0.5 * (tension[1:] + tension[:-1]) * np.diff(way, axis=0))
    gross = np.sum(0.5 * (tension[1:] + tension[:-1]) * np.abs(np.diff(way, axis=0)))
    assert energy > -1e-3 * gross


@every_law
def test_twice_the_stiffness_and_all_stiffnesses_pulls_twice_as_much(law):
    seen, values = motion(wandering()), typical(law)
    doubled = {v.name: values[v.name] * (2.0 if v.unit.startswith("N") else 1.0) for v in law.values}
    np.testing.assert_allclose(law.tension(seen, 2 * K, L_0, doubled), 2.0 * pull(law, seen), rtol=1e-12, atol=1e-12)


@every_law
def test_what_is_to_come_does_not_matter(law):
    seen = motion(wandering())
    first = motion(wandering()[:1200])
    first = WireMotion(first.time, first.length, seen.rate[:1200], first.segment_length, first.wrap)
    np.testing.assert_allclose(pull(law, first), pull(law, seen)[:1200], rtol=1e-12, atol=1e-12)


@every_law
def test_the_motion_is_left_as_it_is(law):
    seen, fresh = motion(wandering()), motion(wandering())
    before = pull(law, seen)
    for name, values in vars(seen).items():
        np.testing.assert_array_equal(values, getattr(fresh, name))
    kept = before.copy()
    pull(law, motion(wandering(seed=1)))
    np.testing.assert_array_equal(before, kept)


@every_law
def test_every_value_has_a_name_a_unit_a_sentence_and_a_range_that_holds_zero_and_the_typical(law):
    for value in law.values:
        assert isinstance(value, Quantity)
        assert value.name.isidentifier()
        assert value.unit in UNITS
        assert value.low == 0.0 < value.typical < value.high
        sentence(value.sentence)
    assert len({value.name for value in law.values}) == len(law.values)


@every_law
def test_a_user_is_told_in_a_sentence(law):
    sentence(law.sentence)


def sentence(text):
    assert text[0].isupper()
    assert text.endswith(".")
    assert len(text.split()) >= 4


@every_law
def test_the_law_is_found_under_the_name_of_its_file(law):
    assert importlib.import_module(f"exogauge.devices.laws.{law.name}").LAW is law
