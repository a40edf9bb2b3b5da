"""The force laws of device.yaml: the contract that every one keeps, closed forms, and how they are stated."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.effects.band import WireMotion
from exogauge.effects.band_laws import all_laws, check_values, law_named
from exogauge.effects.catalogue import band_effects
from exogauge.errors import BadInput

UNITS = {"1", "m", "1/m", "s", "N/m", "N/m²", "N·s/m"}
K, L_0 = 200.0, 0.6
SHARES = np.array([0.3, 0.1, 0.4, 0.2])  # of the segments in the length

every_law = pytest.mark.parametrize(
    "law", [*all_laws().values(), law_named("hardening+kelvin_voigt+via_friction")], ids=lambda law: law.name
)


def law(name):
    return all_laws()[name]


def motion(length, time=None):
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
    return {value.name: value.stated.typical for value in law.values}


def least(law, share=0.0):
    """A share of what is typical, of every value that may be 0."""
    return {name: value * share if each.stated.low == 0.0 else value
            for each in law.values for name, value in [(each.name, each.stated.typical)]}  # fmt: skip


def pull(law, seen, values=None):
    return law.tension(seen, K, L_0, typical(law) if values is None else values)


def linear(law, seen):
    spring = K * np.maximum(seen.length - L_0, 0.0)
    return spring[:, None] if law.per_segment else spring


def cycles(rate, amplitude=0.05, cycle=1000, before=30):
    """Sines about a stretch of 10 cm, and the samples of the last, when all has become steady."""
    samples = np.arange((before + 1) * cycle + 1)
    time = samples / (cycle * rate)
    return motion(L_0 + 0.1 + amplitude * np.sin(2 * np.pi * rate * time), time), samples >= before * cycle


def loop(tension, length):
    return float(np.sum(0.5 * (tension[1:] + tension[:-1]) * np.diff(length, axis=0)))


@every_law
@pytest.mark.parametrize("samples", [0, 1, 3000])
def test_tension_is_finite_never_negative_and_has_a_row_per_sample(law, samples):
    tension = pull(law, motion(wandering()[:samples]))
    assert tension.shape == ((samples, 4) if law.per_segment else (samples,))
    assert tension.dtype == np.float64
    assert np.isfinite(tension).all()
    assert np.all(tension >= 0.0)


@every_law
def test_a_band_shorter_than_its_natural_length_is_slack(law):
    """Exactly, but for a transition: there it is slack to a ten-thousandth 7 cm below."""
    seen = motion(wandering())
    gradual = "transition" in typical(law)
    below = seen.length < L_0 - (0.07 if gradual else 0.0)
    assert below.sum() > 10
    assert np.all(pull(law, seen)[below] <= (1e-6 if gradual else 0.0))


@every_law
def test_a_longer_band_pulls(law):
    tension = pull(law, motion(np.linspace(L_0 + 0.05, L_0 + 0.15, 50)))
    assert np.all(tension > 0.0)
    assert np.all(tension[-1] > tension[0])


@every_law
def test_with_its_own_values_at_zero_the_law_is_the_linear_one_and_near_zero_it_is_near(law):
    seen = motion(wandering())
    assert np.abs(pull(law, seen, least(law)) - linear(law, seen)).max() < 1e-9
    assert np.abs(pull(law, seen, least(law, 1e-6)) - linear(law, seen)).max() < 1e-3


@every_law
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("times", [1.0, 0.1, 10.0])
def test_no_cycle_gives_energy(law, seed, times):
    """∮ T·dl ≥ 0 over closed loops of any speed, begun where the band is slack, so that it ends as it began."""
    length = wandering(seed=seed)
    out = np.linspace(L_0 - 0.08, length[0], 200)
    length = np.concatenate([out, length, np.linspace(length[-1], L_0 - 0.08, 200), np.full(300, L_0 - 0.08)])
    seen = motion(length, np.arange(len(length)) * 0.01 * times)
    tension, way = pull(law, seen), seen.segment_length if law.per_segment else seen.length
    gross = np.sum(0.5 * (tension[1:] + tension[:-1]) * np.abs(np.diff(way, axis=0)))
    assert loop(tension, way) > -1e-3 * gross


@every_law
def test_twice_the_stiffness_and_all_stiffnesses_pulls_twice_as_much(law):
    seen, values = motion(wandering()), typical(law)
    doubled = {v.name: values[v.name] * (2.0 if v.unit.startswith("N") else 1.0) for v in law.values}
    np.testing.assert_allclose(law.tension(seen, 2 * K, L_0, doubled), 2.0 * pull(law, seen), rtol=1e-12, atol=1e-12)


@every_law
def test_what_is_to_come_does_not_matter(law):
    seen, first = motion(wandering()), motion(wandering()[:1200])
    first = WireMotion(first.time, first.length, seen.rate[:1200], first.segment_length, first.wrap)
    np.testing.assert_allclose(pull(law, first), pull(law, seen)[:1200], rtol=1e-10, atol=1e-10)


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
def test_every_value_has_a_name_a_unit_words_and_a_range_that_holds_what_is_typical(law):
    for value in law.values:
        assert value.name.isidentifier()
        assert value.unit in UNITS
        assert len(value.words.split()) >= 3
        stated = value.stated
        assert 0.0 <= stated.low < stated.typical <= stated.high
        assert stated.default is None or stated.low <= stated.default <= stated.high
    assert any(value.stated.low == 0.0 for value in law.values) or not law.values


def test_no_two_laws_have_a_value_of_one_name():
    names = [value.name for each in all_laws().values() for value in each.values]
    assert len(set(names)) == len(names), "or they could not be added"


def test_what_is_stated_are_the_values_of_the_law():
    for effect in band_effects().values():
        own = {each.name for each in (*effect.coefficients, *effect.shapes)}
        assert set(effect.stated) == (own if effect.law else set())


@every_law
def test_what_a_search_may_find_can_be_stated(law):
    """Or the device file that is made of a result would be refused."""
    for effect in law.effects:
        for each in (*effect.coefficients, *effect.shapes):
            stated = effect.stated[each.name]
            assert stated.low <= each.low < each.high <= stated.high, each.name


def test_linear_pulls_by_its_stretch_and_is_slack_below_its_natural_length():
    seen = motion(np.array([0.1, 0.6, 0.65, 0.8]), np.arange(4.0))
    np.testing.assert_allclose(law("linear").tension(seen, K, L_0, {}), [0.0, 0.0, 10.0, 40.0], atol=1e-12)


def test_as_printed_25_does_not_decide_a_slack_band_and_its_first_case_would_push():
    """Printed: f = -k (l - l_0) for l ≥ l_0, 0 for l < 0. Half the natural length is neither; f > 0 is a push."""
    length = 0.5 * L_0
    assert 0.0 <= length < L_0
    assert -K * (length - L_0) > 0.0
    assert law("linear").tension(motion(np.full(2, length)), K, L_0, {})[0] == 0.0


def test_smooth_slack_is_off_by_k_delta_ln_2_at_the_natural_length_and_by_less_elsewhere():
    x = np.linspace(-0.1, 0.1, 401)
    tension = law("smooth_slack").tension(motion(L_0 + x), K, L_0, {"transition": 0.01})
    off = tension - K * np.maximum(x, 0.0)
    assert off[200] == pytest.approx(K * 0.01 * np.log(2.0), rel=1e-12)
    assert off.argmax() == 200
    assert off.min() >= 0.0
    assert np.all(np.diff(tension) > 0.0)


def test_hardening_starts_with_the_stiffness_and_grows_by_twice_its_value_per_metre():
    x = np.linspace(0.0, 0.2, 2001)
    tension = law("hardening").tension(motion(L_0 + x), K, L_0, {"hardening": 400.0})
    np.testing.assert_allclose(np.gradient(tension, x, edge_order=2), K + 800.0 * x, rtol=1e-9)


def test_softening_starts_with_the_stiffness_and_loses_half_of_what_it_loses_by_its_stretch():
    x, half = np.linspace(0.0, 0.2, 20001), 0.05
    tension = law("softening").tension(motion(L_0 + x), K, L_0, {"softening": 400.0, "softening_stretch": half})
    lost = K - np.gradient(tension, x, edge_order=2)
    assert lost[0] == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(lost, 2.0 * np.interp(half, x, lost) * x / (x + half), atol=1e-3)
    assert np.interp(0.1, x, tension) == pytest.approx(K * 0.1 - 400.0 * 0.1**2, rel=1e-9)


def test_rubber_follows_softening():
    """A neo-Hookean band stretched to half as long again, by values that a fit would find."""
    x = np.linspace(1e-3, 0.5 * L_0, 500)
    stretched = 1.0 + x / L_0
    rubber = K * L_0 / 3.0 * (stretched - stretched**-2)
    seen, values = motion(L_0 + x), {"softening_stretch": 0.4 * L_0}
    linear, softer = (law("softening").tension(seen, K, L_0, values | {"softening": s}) for s in (0.0, 100.0))
    columns = np.column_stack([linear, softer - linear]) / rubber[:, None]
    found = np.linalg.lstsq(columns, np.ones(len(x)), rcond=None)[0]
    np.testing.assert_allclose(columns @ found, 1.0, atol=3e-3)
    assert found[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("rate", [0.2, 1.5])
def test_kelvin_voigt_loses_pi_a_squared_c_omega_per_cycle(rate):
    seen, steady = cycles(rate)
    tension = law("kelvin_voigt").tension(seen, K, L_0, {"damping": 12.0})
    expected = np.pi * 0.05**2 * 12.0 * 2 * np.pi * rate
    assert loop(tension[steady], seen.length[steady]) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("rate", [0.05, 0.4, 3.0])
def test_maxwell_loses_most_where_a_cycle_takes_as_long_as_it_relaxes(rate):
    seen, steady = cycles(rate)
    k_M, tau, omega = 70.0, 0.4, 2 * np.pi * rate
    tension = law("maxwell").tension(seen, K, L_0, {"branch_stiffness": k_M, "relaxation_time": tau})
    expected = np.pi * 0.05**2 * k_M * omega * tau / (1.0 + (omega * tau) ** 2)
    assert loop(tension[steady], seen.length[steady]) == pytest.approx(expected, rel=2e-3)


def test_maxwell_relaxes_as_an_exponential_at_any_uneven_times():
    """One jump of 8 cm within a microsecond, then held."""
    time = np.r_[0.0, 1e-6, np.sort(np.random.default_rng(0).uniform(0.01, 5.0, 40))]
    seen = motion(np.r_[L_0, np.full(41, L_0 + 0.08)], time)
    tension = law("maxwell").tension(seen, K, L_0, {"branch_stiffness": 50.0, "relaxation_time": 0.7})
    np.testing.assert_allclose(tension[2:], 0.08 * (K + 50.0 * np.exp(-time[2:] / 0.7)), rtol=1e-5)


def test_maxwell_is_exact_between_samples_however_few():
    """Even stretching, sampled finely and with steps twenty times the relaxation time."""
    values, natural = {"branch_stiffness": 50.0, "relaxation_time": 0.05}, 0.3  # taut throughout
    coarse, fine = np.arange(0.0, 6.0, 1.0), np.arange(0.0, 5.0001, 0.001)
    few, many = (law("maxwell").tension(motion(L_0 + 0.03 * time, time), K, natural, values) for time in (coarse, fine))
    np.testing.assert_allclose(few, many[::1000], rtol=1e-9)
    branch = 0.03 * 50.0 * 0.05 * (1 - np.exp(-coarse / 0.05))
    np.testing.assert_allclose(few, K * (0.3 + 0.03 * coarse) + branch, rtol=1e-12)


def two_segments(second, angle=1.0):
    """The first stays, the second has these lengths."""
    segments = np.stack([np.full(len(second), 0.3), second], axis=1)
    seen = motion(segments.sum(axis=1))
    return WireMotion(seen.time, seen.length, seen.rate, segments, np.full((len(second), 1), angle))


@pytest.mark.parametrize(("degrees", "ratio"), [(30, 1.11), (60, 1.23), (90, 1.37)])
def test_a_band_pulled_over_a_corner_has_the_capstan_ratio_and_the_springs_mean(degrees, ratio):
    seen = two_segments(0.3 + np.linspace(0.01, 0.3, 60), np.radians(degrees))
    tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.2})
    assert tension[-1, 1] / tension[-1, 0] == pytest.approx(np.exp(0.2 * np.radians(degrees)), rel=1e-9)
    assert tension[-1, 1] / tension[-1, 0] == pytest.approx(ratio, abs=5e-3)
    mean = np.sum(tension * seen.segment_length, axis=1) / seen.length
    np.testing.assert_allclose(mean, K * (seen.length - L_0), rtol=1e-9)


def test_friction_turns_over_within_the_way_that_is_stated():
    """Pulled out and let in again: the ratio goes from one end of what friction holds to the other."""
    seen = two_segments(0.3 + np.r_[np.linspace(0.01, 0.3, 200), np.linspace(0.3, 0.1, 400)])
    for way in (0.0005, 0.005):
        tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.2, "way": way})
        ratio = np.log(tension[:, 1] / tension[:, 0])
        assert np.abs(ratio).max() <= 0.2 + 1e-12
        assert ratio[199] == pytest.approx(0.2, abs=1e-3)
        assert ratio[-1] == pytest.approx(-0.2, abs=1e-3)
        slid = -np.diff(L_0 * seen.segment_length[:, 0] / seen.length)[199:]
        zero = np.flatnonzero(ratio[199:] < 0.0)[0]
        assert np.abs(slid[:zero]).sum() == pytest.approx(way * np.log(2.0), abs=2e-3)


def test_friction_holds_no_more_than_it_can_wherever_segments_move():
    seen = motion(wandering())
    tension = law("via_friction").tension(seen, K, 0.3, {"friction": 0.2})
    assert (np.abs(np.diff(np.log(tension), axis=1)) - 0.2 * seen.wrap).max() < 1e-10


def test_friction_without_segments_is_refused():
    time = np.arange(2.0)
    with pytest.raises(ValueError, match="segment lengths"):
        law("via_friction").tension(WireMotion(time, np.ones(2), np.zeros(2)), K, L_0, {"friction": 0.2})


def test_several_laws_of_one_band_add_up_and_no_sum_pushes():
    seen, values = motion(wandering()), {"hardening": 300.0, "damping": 8.0}
    both = law_named("hardening+kelvin_voigt").tension(seen, K, L_0, values)
    one, other = (law(name).tension(seen, K, L_0, values) for name in ("hardening", "kelvin_voigt"))
    taut = (one > 0.0) & (other > 0.0)
    np.testing.assert_allclose(both[taut], (one + other - linear(law("linear"), seen))[taut], rtol=1e-9, atol=1e-9)
    assert both.min() == 0.0


def test_values_are_checked_against_the_law():
    check_values("maxwell", {"branch_stiffness": 50.0, "relaxation_time": 0.5})
    check_values("maxwell + hardening", {"branch_stiffness": 50.0, "relaxation_time": 0.5, "hardening": 3.0})
    with pytest.raises(BadInput) as caught:
        check_values("maxwell", {"branch_stiffness": -1.0, "damping": 3.0})
    assert [(fault.rule, fault.column) for fault in caught.value.faults] == [
        ("unknown_law_value", "law_values.damping"),
        ("law_value_range", "law_values.branch_stiffness"),
        ("missing_law_value", "law_values.relaxation_time"),
    ]
    for value in (np.nan, np.inf):
        with pytest.raises(BadInput):
            check_values("kelvin_voigt", {"damping": value})


@pytest.mark.parametrize(
    ("name", "rule", "words"),
    [("kelvin_vogt", "unknown_law", "'kelvin_voigt'"), ("linear+maxwel", "unknown_law", "'maxwell'"),
     ("maxwell+maxwell", "law_twice", "once")],
)  # fmt: skip
def test_a_law_that_there_is_not_is_named_and_the_nearest_offered(name, rule, words):
    with pytest.raises(BadInput) as caught:
        check_values(name, {}, "band.law")
    (fault,) = caught.value.faults
    assert (fault.column, fault.rule) == ("band.law", rule)
    assert words in fault.advice


NEW = """
import numpy as np
from exogauge.effects.band import Stated
from exogauge.effects.effect import Quantity

class Preload:
    name, law, place, words = "band_preload", "preload", "band", "a preload"
    sentence = "The band pulls with a further force wherever it is taut."
    coefficients = (Quantity("preload", "N", low=0.0, words="force wherever it is taut"),)
    shapes, confounds = (), ("natural_length",)
    needs, coordinate, once, per_segment, sort = "Motion through the slack posture.", "stretch", False, False, "law"
    stated = {"preload": Stated(3.0)}

    def added_tension(self, signals, shape):
        return signals.taut[:, None]

    def applies(self, signals):
        return bool(np.any(signals.stretch > 0.0))

EFFECT = Preload()
"""


def test_one_new_file_is_a_law_of_device_yaml_of_what_if_and_of_the_search(folder_of_effects):
    (folder_of_effects.path / "band_preload.py").write_text(NEW)
    folder_of_effects.look_again()
    tension = check_values("preload", {"preload": 3.0}).tension(motion(np.array([0.5, 0.7])), K, 0.65, {"preload": 3.0})
    np.testing.assert_allclose(tension, [0.0, 200.0 * 0.05 + 3.0 * 0.25])  # comes up within one sample's way
    assert band_effects()["band_preload"].sort == "law"


def test_nobody_can_change_the_catalogue_in_passing():
    with pytest.raises(TypeError):
        all_laws()["magic"] = object()
