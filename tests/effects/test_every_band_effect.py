"""The contract that every effect keeps which the model of a wear may miss."""

import importlib
import itertools
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from exogauge.effects.band import BandSignals
from exogauge.effects.catalogue import all_effects, band_effects, shaped_effects

COORDINATES = {"stretch", "rate", "clock"}
FITTED_ANYWAY = {"stiffness", "natural_length"}
MOST_SHAPES = 300  # of one effect at one band
DISSIPATIVE = ("band_viscous", "band_relaxation", "band_hysteresis")
K, L_0 = 300.0, 0.6
EFFECTS = dict(band_effects())

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


def signals(samples=4000, rate=100.0, seed=0, l_0=L_0):
    """A band of four parts round three corners, in part of its motion slack, over a motion that ends where it began."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / rate
    waves = [np.sin(2.0 * np.pi * k * t / t[-1] + rng.uniform(0.0, 6.0)) for k in (3, 7, 16)]
    whole = 0.02 * np.sum(waves, axis=0) + 0.03
    parts = np.column_stack([0.2 + 0.6 * whole, np.full_like(t, 0.1), 0.15 + 0.4 * whole, np.full_like(t, 0.15)])
    length = parts.sum(axis=1)
    return BandSignals(
        time=t,
        clock=t + 40.0,
        start=40.0,
        span=3.0 * t[-1],
        length=length,
        rate=np.gradient(length, t),
        stretch=np.maximum(length - l_0, 0.0),
        stiffness=K,
        natural_length=l_0,
        shortest=float(length.min()),
        travel=float(np.ptp(length)),
        segment_length=parts,
        wrap=np.tile([0.4, 0.9, 0.3], (samples, 1)),
    )


def cut(whole, part):
    return replace(
        whole, **{f.name: getattr(whole, f.name)[part] for f in fields(whole) if np.ndim(getattr(whole, f.name))}
    )


def slack(samples=500):
    t = np.arange(samples) / 100.0
    still, parts = np.full(samples, 0.5), np.full((samples, 4), 0.125)
    nothing = np.zeros(samples)
    return BandSignals(t, t, 0.0, 5.0, still, nothing, nothing, K, L_0, 0.5, 0.0, parts, np.full((samples, 3), 0.5))


def shapes_of(effect):
    """Grid points, and both ends of every range; of a long grid every tenth."""
    values = [(one.low, *one.grid[:: max(1, len(one.grid) // 10)], one.high) for one in effect.shapes]
    yield from itertools.product(*values)


def expected(effect, samples):
    return (samples, 4, len(effect.coefficients)) if effect.per_segment else (samples, len(effect.coefficients))


@every_effect
def test_tension_is_finite_one_per_coefficient_at_every_shape(effect):
    whole, seen = signals(), []
    for shape in shapes_of(effect):
        added = effect.added_tension(whole, shape)
        assert added.shape == expected(effect, len(whole.time))
        assert added.dtype == np.float64
        assert np.isfinite(added).all()
        seen.append(np.any(added != 0.0))
    assert np.mean(seen) > 0.3  # a slip before or after this log shows nothing in it


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 2, 3, 9])
def test_a_log_of_a_few_samples_is_no_special_case(effect, samples):
    short = cut(signals(), slice(1000, 1000 + samples))
    shown = False
    for shape in shapes_of(effect):
        added = effect.added_tension(short, shape)
        assert added.shape == expected(effect, samples)
        assert np.isfinite(added).all()
        shown |= bool(added.any())
    assert effect.applies(short) is False or (shown and samples > 0)  # what cannot be seen is not looked for


@every_effect
def test_a_band_that_stays_slack_is_blamed_for_nothing(effect):
    assert not effect.applies(slack())
    for shape in shapes_of(effect):
        added = effect.added_tension(slack(), shape)
        assert np.isfinite(added).all()
        assert effect.sort == "wire" or effect.law == "smooth_slack" or not added.any()


@every_effect
def test_where_a_declared_band_is_slack_nothing_is_added(effect):
    whole = signals()
    for shape in shapes_of(effect):
        added = effect.added_tension(whole, shape)
        assert effect.sort == "wire" or effect.law == "smooth_slack" or not added[whole.stretch == 0.0].any()


@every_effect
def test_it_applies_to_a_band_that_does_everything(effect):
    assert effect.applies(signals())


@every_effect
def test_the_signals_stay_as_they_are_and_so_does_what_was_returned(effect):
    whole, fresh = signals(), signals()
    shape = tuple(one.low for one in effect.shapes)
    added = effect.added_tension(whole, shape)
    before = added.copy()
    effect.added_tension(signals(seed=1), shape)
    np.testing.assert_array_equal(added, before)
    for field in fields(whole):
        np.testing.assert_array_equal(getattr(whole, field.name), getattr(fresh, field.name))


@every_effect
def test_what_it_is_confused_with_and_plotted_over_is_known(effect):
    assert effect.confounds
    assert set(effect.confounds) <= set(EFFECTS) | FITTED_ANYWAY
    assert effect.coordinate in COORDINATES
    assert effect.sort in ("law", "stated", "wire")


@every_effect
def test_the_effect_is_found_under_the_name_of_its_file_and_by_no_other_search(effect):
    assert importlib.import_module(f"exogauge.effects.{effect.name}").EFFECT is effect
    assert effect.name not in {**all_effects(), **shaped_effects()}


@every_effect
def test_a_search_stays_affordable(effect):
    assert np.prod([len(one.grid) for one in effect.shapes]) <= MOST_SHAPES


def test_no_two_coefficients_bear_the_same_name():
    names = [each.name for effect in EFFECTS.values() for each in effect.coefficients]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("name", DISSIPATIVE)
def test_what_lets_go_or_damps_takes_energy_out_of_a_closed_motion(name):
    effect, whole = EFFECTS[name], signals(l_0=0.4)  # taut throughout
    for shape in shapes_of(effect):
        power = effect.added_tension(whole, shape)[:, 0] * whole.rate
        assert np.trapezoid(power, whole.time) > 0.001 * np.trapezoid(np.abs(power), whole.time)


def test_relaxation_is_exact_between_samples_however_few():
    effect, fine = EFFECTS["band_relaxation"], signals(l_0=0.4)
    ramp = replace(fine, length=0.5 + 0.01 * fine.time, stretch=0.1 + 0.01 * fine.time)
    tau = 2.0
    exact = 0.01 * tau * (1.0 - np.exp(-ramp.time / tau))
    for every in (1, 50, 400):
        few = cut(ramp, slice(None, None, every))
        np.testing.assert_allclose(effect.added_tension(few, (tau,))[:, 0], exact[::every], atol=1e-12)


def test_a_via_point_that_gives_way_further_takes_longer_to_let_the_band_slide():
    effect, whole = EFFECTS["band_via_friction"], signals(l_0=0.4)
    stiff, soft = (np.abs(effect.added_tension(whole, (0.2, way, 1.3))).sum() for way in (2e-4, 0.02))
    assert soft < 0.8 * stiff


def test_one_via_point_lets_go_by_dahls_law():
    """Two stretches, pulled out evenly after a turn: from its own side to the other as the law's integral says."""
    effect, way, n, mu = EFFECTS["band_via_friction"], 0.004, 1.5, 1e-6
    whole = signals(l_0=0.4)
    slid = np.concatenate([np.linspace(0.0, 0.03, 2000), np.linspace(0.03, 0.01, 2000)])  # of the part before the point
    share = (0.2 + slid) / 0.4  # u = l_0 times this share of the length
    length = np.full(4000, 0.6)
    whole = replace(
        whole, length=length, segment_length=np.stack([share, 1.0 - share], axis=1) * 0.6, wrap=np.full((4000, 1), 0.5)
    )
    apart = -np.diff(effect.added_tension(whole, (mu, way, n))[:, :, 0], axis=1)[:, 0] / (0.5 * whole.tension)
    back = solve_ivp(lambda u, c: -((1.0 + c) ** n) / way, (0.0, 0.02), [1.0 - kept_after(0.03 / way, n)], rtol=1e-9,
                     t_eval=[0.002, 0.01, 0.02]).y[0]  # fmt: skip
    np.testing.assert_allclose(apart[[2000 + round(u / 0.02 * 1999) for u in (0.002, 0.01, 0.02)]], back, atol=2e-3)


def kept_after(ways: float, n: float) -> float:
    """u of du/dw = -u^n from 1, integrated."""
    return float(solve_ivp(lambda _w, u: -(u**n), (0.0, ways), [1.0], rtol=1e-10, atol=1e-12).y[0, -1])


def test_a_damper_acts_in_full_as_soon_as_the_band_is_taut():
    effect, whole = EFFECTS["band_viscous"], signals(l_0=0.63)
    pulls = whole.stretch > 0.0
    comes_and_goes = np.sum(np.diff(pulls.astype(int)) != 0)
    less = pulls & ~np.isclose(effect.added_tension(whole, (1.0,))[:, 0], whole.rate, rtol=1e-9)
    assert comes_and_goes > 5
    assert less.sum() <= 2 * comes_and_goes


@pytest.mark.parametrize("name", ["band_hardening", "band_viscous"])
def test_the_curve_has_the_power_that_is_asked_for_and_the_size_of_its_coefficient(name):
    effect, whole = EFFECTS[name], signals(l_0=0.4)  # taut throughout
    over, at, size = {
        "band_hardening": (whole.stretch, 0.1, 0.01),
        "band_viscous": (np.abs(whole.rate), 0.1, 0.1),
    }[name]
    for power in (1.5, 2.0):
        pull = np.abs(effect.added_tension(whole, (power,))[:, 0])
        np.testing.assert_allclose(pull, size * (over / at) ** power, atol=1e-12)


def test_a_slip_lasts_to_the_end_of_its_log_or_beyond_it():
    effect, whole = EFFECTS["band_slip"], signals(l_0=0.4)
    moment = (whole.start + 10.0) / whole.span
    slipped = effect.added_tension(whole, (moment, 0.0, 0.4))[:, 0]
    np.testing.assert_array_equal(slipped != 0.0, whole.time > 9.8 + 1e-9)
    np.testing.assert_allclose(slipped[whole.time > 10.2], -whole.stiffness)
    assert slipped[np.argmin(np.abs(whole.time - 10.0))] == pytest.approx(-0.5 * whole.stiffness, rel=0.02)
    before = 0.5 * whole.start / whole.span
    assert not effect.added_tension(whole, (before, 0.0, 0.4)).any()
    assert effect.added_tension(whole, (before, 1.0, 0.4)).all()
