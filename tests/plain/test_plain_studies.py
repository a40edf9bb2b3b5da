"""Nothing is missing, nothing is named: a slow periodic motion, and moves from point to point."""

import json

import numpy as np
import pytest
from tests.plain.excitation import STYLES
from tests.plain.score import FLOORS, facts, summary
from tests.plain.study_files import plan, write_study


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 5])
def test_a_plain_study_stands_at_its_noise_and_lacks_nothing(seed, tmp_path):
    from exogauge.studies.evaluate import evaluate

    write_study(tmp_path / "study", plan(seed))
    evaluate(tmp_path / "study/study.yaml", tmp_path / "out", lambda *_: None)
    results = json.loads((tmp_path / "out/results.json").read_bytes())
    found = facts(results, json.loads((tmp_path / "study/truth.json").read_bytes()))
    assert (found["verdict"], found["named"]) == ("none", [])
    assert found["floors"] <= FLOORS
    assert np.mean(np.abs(list(found["off"].values())) < 2.0) > 0.7
    for each in results["identification"]["steady"]:
        assert each["fitted_s"] > 0.2 * each["fitted_of_s"]


@pytest.mark.parametrize("style", STYLES)
def test_velocities_and_accelerations_are_those_of_the_positions(style):
    time = np.arange(0, 40.0, 1e-3)
    q, dq, ddq = STYLES[style](np.random.default_rng(1), time, 1.0)
    inside = slice(5, -5)
    np.testing.assert_allclose(np.gradient(q, time)[inside], dq[inside], atol=2e-5 * np.abs(dq).max() + 1e-6)
    np.testing.assert_allclose(np.gradient(dq, time)[inside], ddq[inside], atol=3e-3 * np.abs(ddq).max())
    assert np.abs(q).max() <= 1.0 + 1e-12


def test_all_styles_rates_and_actuations_meet_every_robot():
    plans = [plan(seed) for seed in range(120)]
    arms = {(p.robot.name, p.style, p.actuation) for p in plans if not p.robot.base_link}
    assert len(arms) >= 12
    assert {p.rate_hz for p in plans} == {125.0, 200.0, 250.0, 500.0}
    assert {p.style for p in plans if p.robot.base_link} == set(STYLES)


def test_soft_friction_is_counted_apart_and_doubts_that_are_too_small_show_in_z():
    """Errors of twice what is stated: 67 % inside 1.96 standard deviations, rms 2."""
    rng = np.random.default_rng(3)

    def study(name, verdict, floors, size):
        off = {f"k_d[j{k}]": size * rng.standard_normal() for k in range(500)}
        return {"name": name, "verdict": verdict, "floors": floors, "good": verdict == "none", "off": off}

    text = summary([
        study("0000-UR5-chirp-125Hz-current", "none", 1.0, 1.0),
        study("0001-Panda-sines-250Hz-torque", "none", 1.01, 2.0),
        study("0003-UR5-sines-125Hz-current-soft", "effects", 1.9, 9.0),
        {"name": "0005-UR5-fourier-125Hz-current", "error": "it did not end"},
    ])  # fmt: skip
    assert "at once: 2 of 3 are `none`" in text
    assert "1 did not end; worst floors: 1.010, 1.000" in text
    assert "soft: 0 of 1 are `none`" in text
    of_kinds = [line.split() for line in text.splitlines() if line.startswith("  ")]
    share = {words[0]: float(words[2]) for words in of_kinds}
    rms = {words[0]: float(words[words.index("rms") + 1].rstrip(",")) for words in of_kinds}
    assert abs(rms["chirp"] - 1.0) < 0.1
    assert abs(rms["Panda"] - 2.0) < 0.2
    assert abs(share["chirp"] - 95.0) < 3.0
    assert abs(share["sines"] - 67.0) < 7.0
