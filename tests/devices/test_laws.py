"""What each force law says, against closed forms, and the catalogue."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import exogauge.devices.laws as package
from exogauge.devices.laws.catalogue import all_laws, check_values
from exogauge.devices.laws.law import WireMotion
from exogauge.errors import BadInput

K, L_0 = 200.0, 0.6


def law(name):
    return all_laws()[name]


def motion(time, length, segments=None, wrap=None):
    return WireMotion(time, length, np.gradient(length, time), segments, wrap)


def cycles(rate, amplitude=0.05, cycle=1000, before=30):
    """Sines about a stretch of 10 cm, and the samples of the last, when all has become steady."""
    samples = np.arange((before + 1) * cycle + 1)
    time = samples / (cycle * rate)
    length = L_0 + 0.1 + amplitude * np.sin(2 * np.pi * rate * time)
    return motion(time, length), samples >= before * cycle


def loop(tension, length):
    return float(np.sum(0.5 * (tension[1:] + tension[:-1]) * np.diff(length)))


def test_linear_pulls_by_its_stretch_and_is_slack_below_its_natural_length():
    seen = motion(np.arange(4.0), np.array([0.1, 0.6, 0.65, 0.8]))
    np.testing.assert_allclose(law("linear").tension(seen, K, L_0, {}), [0.0, 0.0, 10.0, 40.0], atol=1e-12)


def test_as_printed_25_does_not_decide_a_slack_band_and_its_first_case_would_push():
    """Printed: f = -k (l - l_0) for l ≥ l_0, 0 for l < 0. Half the natural length is neither; f > 0 is a push."""
    length = 0.5 * L_0
    assert 0.0 <= length < L_0
    assert -K * (length - L_0) > 0.0
    assert law("linear").tension(motion(np.arange(2.0), np.full(2, length)), K, L_0, {})[0] == 0.0


def test_smooth_slack_is_off_by_k_delta_ln_2_at_the_natural_length_and_by_less_elsewhere():
    x = np.linspace(-0.1, 0.1, 401)
    tension = law("smooth_slack").tension(motion(np.arange(401.0), L_0 + x), K, L_0, {"transition": 0.01})
    off = tension - K * np.maximum(x, 0.0)
    assert off[200] == pytest.approx(K * 0.01 * np.log(2.0), rel=1e-12)
    assert off.argmax() == 200
    assert off.min() >= 0.0
    assert np.all(np.diff(tension) > 0.0)


def test_hardening_starts_with_the_stiffness_and_grows_by_twice_its_value_per_metre():
    x = np.linspace(0.0, 0.2, 2001)
    tension = law("hardening").tension(motion(np.arange(2001.0), L_0 + x), K, L_0, {"hardening": 400.0})
    slope = np.gradient(tension, x, edge_order=2)
    np.testing.assert_allclose(slope, K + 800.0 * x, rtol=1e-9)


@pytest.mark.parametrize("rate", [0.2, 1.5])
def test_kelvin_voigt_loses_pi_a_squared_c_omega_per_cycle(rate):
    seen, steady = cycles(rate)
    tension = law("kelvin_voigt").tension(seen, K, L_0, {"damping": 12.0})
    assert loop(tension[steady], seen.length[steady]) == pytest.approx(
        np.pi * 0.05**2 * 12.0 * 2 * np.pi * rate, rel=2e-3
    )


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
    length = np.r_[L_0, np.full(41, L_0 + 0.08)]
    tension = law("maxwell").tension(motion(time, length), K, L_0, {"branch_stiffness": 50.0, "relaxation_time": 0.7})
    expected = 0.08 * (K + 50.0 * np.exp(-time[1:] / 0.7))
    np.testing.assert_allclose(tension[1:], expected, rtol=1e-5)


def test_maxwell_is_exact_between_samples_however_few():
    """Even stretching, sampled finely and with steps twenty times the relaxation time."""
    values = {"branch_stiffness": 50.0, "relaxation_time": 0.05}
    coarse = np.arange(0.0, 6.0, 1.0)
    tension = law("maxwell").tension(motion(coarse, L_0 + 0.03 * coarse), K, L_0, values)
    fine = np.arange(0.0, 5.0001, 0.001)
    closely = law("maxwell").tension(motion(fine, L_0 + 0.03 * fine), K, L_0, values)
    np.testing.assert_allclose(tension, closely[::1000], rtol=1e-9)
    np.testing.assert_allclose(tension[1:], 0.03 * (K * coarse[1:] + 50.0 * 0.05 * (1 - np.exp(-coarse[1:] / 0.05))))


def pulled_over(angle, friction, end=0.3, samples=60):
    """A band of two segments over one via point; the second is pulled out."""
    segments = np.stack([np.full(samples, 0.3), 0.3 + np.linspace(0.01, end, samples)], axis=1)
    seen = motion(np.arange(float(samples)), segments.sum(axis=1), segments, np.full((samples, 1), angle))
    return law("via_friction").tension(seen, K, L_0, {"friction": friction})


@pytest.mark.parametrize(("degrees", "ratio"), [(30, 1.11), (60, 1.23), (90, 1.37)])
def test_a_band_pulled_over_a_corner_has_the_capstan_ratio(degrees, ratio):
    tension = pulled_over(np.radians(degrees), 0.2)[-1]
    assert tension[1] / tension[0] == pytest.approx(np.exp(0.2 * np.radians(degrees)), rel=1e-12)
    assert tension[1] / tension[0] == pytest.approx(ratio, abs=5e-3)


def test_what_slides_obeys_both_springs():
    """Both parts keep EA = k l_0; their unstretched lengths add up to the natural length."""
    segments = np.array([0.3, 0.6])
    tension = pulled_over(1.0, 0.3)[-1]
    unstretched = segments / (1.0 + tension / (K * L_0))
    assert unstretched.sum() == pytest.approx(L_0, rel=1e-12)


def test_a_band_sticks_before_it_slides_back():
    """Pulled out and let in again at its second segment: the first keeps its tension until the ratio is turned over."""
    way = np.r_[np.linspace(0.01, 0.3, 100), np.linspace(0.3, 0.1, 400)]
    segments = np.stack([np.full(500, 0.3), 0.3 + way], axis=1)
    seen = motion(np.arange(500.0), segments.sum(axis=1), segments, np.ones((500, 1)))
    tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.2})
    ratio = np.log(tension[:, 1] / tension[:, 0])
    assert np.abs(ratio).max() <= 0.2 + 1e-12
    back = tension[99:, 0]
    held = np.flatnonzero(ratio[99:] > -0.2 + 1e-9)
    np.testing.assert_allclose(back[held], back[0], rtol=1e-12)
    assert 5 < len(held) < 200
    assert np.all(np.diff(back[held[-1] + 1 :]) < 0.0)
    assert ratio[-1] == pytest.approx(-0.2, abs=1e-9)


def test_friction_holds_no_more_than_it_can_and_slides_only_where_it_holds_that():
    """Seven segments that move at random. Over a via point goes only what its full ratio cannot hold."""
    rng, samples = np.random.default_rng(3), 2000
    time = np.arange(samples) * 0.01
    segments = 0.1 + 0.02 * np.sin(2 * np.pi * rng.uniform(0.1, 0.5, 7) * time[:, None] + rng.uniform(0, 6, 7))
    wrap = rng.uniform(0.1, 1.5, 6) + 0.05 * np.sin(time)[:, None]
    seen = motion(time, segments.sum(axis=1), segments, wrap)
    tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.2})
    ratio = np.diff(np.log(tension), axis=1)
    assert (np.abs(ratio) - 0.2 * wrap).max() < 1e-10
    unstretched = segments / (1.0 + tension / (K * L_0))
    assert np.abs(unstretched.sum(axis=1) - L_0).max() < 1e-12
    over = -np.cumsum(np.diff(unstretched, axis=0), axis=1)[:, :-1]  # from each segment into the next
    slides = np.abs(over) > 1e-9
    assert 0.2 < slides.mean() < 0.95
    assert np.abs(ratio[1:] - np.sign(over) * 0.2 * wrap[1:])[slides].max() < 1e-7


def test_a_band_that_was_slack_begins_again_without_friction():
    way = np.r_[np.linspace(0.01, 0.3, 50), np.linspace(0.3, -0.1, 50), np.linspace(-0.1, 0.01, 50)]
    segments = np.stack([np.full(150, 0.3), 0.3 + way], axis=1)
    seen = motion(np.arange(150.0), segments.sum(axis=1), segments, np.ones((150, 1)))
    tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.2})
    taut_again = np.flatnonzero(tension[100:, 0] > 0.0)[0] + 100
    np.testing.assert_allclose(tension[taut_again], K * (seen.length[taut_again] - L_0), rtol=1e-12)


def test_a_segment_that_vanishes_is_no_harm():
    segments = np.stack([np.full(50, 0.4), np.abs(np.linspace(-0.02, 0.03, 50)), np.full(50, 0.3)], axis=1)
    segments[20, 1] = 0.0
    seen = motion(np.arange(50.0), segments.sum(axis=1), segments, np.full((50, 2), 0.5))
    tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.2})
    assert np.isfinite(tension).all()
    assert np.abs(np.diff(np.log(tension), axis=1)).max() < 0.1 + 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_friction_neither_makes_nor_loses_band_however_many_points_hold_it(seed):
    """What lies unstretched on all segments together is the natural length, at every sample."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 10.0, 2000)
    waves = np.sin(np.outer(t, rng.uniform(0.3, 3.0, 7)) + rng.uniform(0.0, 6.0, 7))
    lengths = 0.1 + 0.01 * np.maximum(waves, -0.5)
    lengths[:, [0, 1, 4]] = 0.1  # on one link: as long at every sample, so that much sticks to the last digit
    seen = motion(t, lengths.sum(axis=1), lengths, np.full((2000, 6), 0.6))
    tension = law("via_friction").tension(seen, K, L_0, {"friction": 0.05})
    assert np.all(tension > 0.0)
    unstretched = np.sum(lengths / (1.0 + tension / (K * L_0)), axis=1)
    np.testing.assert_allclose(unstretched, L_0, rtol=1e-9)


def test_friction_without_segments_is_refused():
    with pytest.raises(ValueError, match="segment lengths"):
        law("via_friction").tension(motion(np.arange(2.0), np.ones(2)), K, L_0, {"friction": 0.2})


@pytest.mark.slow
def test_without_the_compiler_friction_is_the_same():
    """In a process where numba compiles nothing."""
    script = (
        "import numpy as np\nfrom exogauge.devices.laws.via_friction import LAW\n"
        "from exogauge.devices.laws.law import WireMotion\n"
        "t = np.arange(300) * 0.01\ns = 0.2 + 0.05 * np.sin(3 * t[:, None] + np.arange(4))\n"
        "w = np.ones((300, 3))\n"
        "T = LAW.tension(WireMotion(t, s.sum(axis=1), t, s, w), 200.0, 0.6, {'friction': 0.2})\n"
        "print(float(T.sum()), float(T[-1, 0]))\n"
    )
    plain, compiled = (
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "NUMBA_DISABLE_JIT": off},
            capture_output=True,
            check=True,
        ).stdout.split()
        for off in ("1", "0")
    )
    np.testing.assert_allclose([float(x) for x in plain], [float(x) for x in compiled], rtol=1e-12)


def test_values_are_checked_against_the_law():
    check_values("maxwell", {"branch_stiffness": 50.0, "relaxation_time": 0.5})
    with pytest.raises(BadInput) as caught:
        check_values("maxwell", {"branch_stiffness": -1.0, "damping": 3.0})
    faults = caught.value.faults
    assert [(fault.rule, fault.column) for fault in faults] == [
        ("unknown_law_value", "law_values.damping"),
        ("law_value_range", "law_values.branch_stiffness"),
        ("missing_law_value", "law_values.relaxation_time"),
    ]
    for value in (np.nan, np.inf):
        with pytest.raises(BadInput):
            check_values("kelvin_voigt", {"damping": value})


def test_an_unknown_law_is_named_and_the_nearest_offered():
    with pytest.raises(BadInput) as caught:
        check_values("kelvin_vogt", {}, "band.law")
    assert caught.value.faults[0].column == "band.law"
    assert "'kelvin_voigt'" in caught.value.faults[0].advice


def test_adding_one_file_is_all_it_takes(tmp_path, monkeypatch):
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    (tmp_path / "constant_pull.py").write_text(
        '"""A spring of one force."""\nimport numpy as np\n\nclass Constant:\n    name = "constant_pull"\n'
        '    sentence = "The band pulls with one force."\n    values = ()\n    per_segment = False\n\n'
        "    def tension(self, motion, stiffness, natural_length, values):\n"
        "        return np.full(len(motion.length), stiffness)\n\nLAW = Constant()\n"
    )
    all_laws.cache_clear()
    try:
        assert check_values("constant_pull", {}).tension(motion(np.arange(2.0), np.ones(2)), 7.0, 1.0, {})[0] == 7.0
    finally:
        monkeypatch.undo()
        all_laws.cache_clear()
        sys.modules.pop(f"{package.__name__}.constant_pull", None)
        vars(package).pop("constant_pull", None)


def test_nobody_can_change_the_catalogue_in_passing():
    with pytest.raises(TypeError):
        all_laws()["magic"] = object()
