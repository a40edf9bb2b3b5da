"""Nothing is missing, nothing is named: a slow periodic motion, and moves from point to point."""

import json

import numpy as np
import pytest
from tests.plain.excitation import STYLES
from tests.plain.score import FLOORS, facts
from tests.plain.study_files import plan, write_study


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 5])
def test_a_plain_study_stands_at_its_noise_and_lacks_nothing(seed, tmp_path):
    from exogauge.studies.evaluate import evaluate

    write_study(tmp_path / "study", plan(seed))
    evaluate(tmp_path / "study/study.yaml", tmp_path / "out", lambda _fraction, _phrase: None)
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
