"""Motors of a simulated robot that warm up through a session, and nothing else wrong."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.identify import identify
from exogauge.studies.intake.admit import admit
from exogauge.studies.intake.open import open_study
from exogauge.support.evaluate import estimate_support
from exogauge.synthetic.log_plans import log_plans
from exogauge.synthetic.study import write_study

pytestmark = [pytest.mark.slow, pytest.mark.thorough]
LOGS = ("id_1", "id_2", *(f"bend_{suit}_{n}" for suit, n in
        (("plain", 1), ("plain", 2), ("normal", 1), ("normal", 2), ("plain", 6), ("plain", 7))))  # fmt: skip


@pytest.fixture(scope="module", params=[(0.02, 31)], ids=["warms"])
def told(request, tmp_path_factory):
    """(truth, stiffness of group A by approach: with the session known, and without), N/m."""
    size, seed = request.param
    folder = tmp_path_factory.mktemp("warming")
    plans = [plan for plan in log_plans("normal") if plan.name in LOGS]
    write_study(folder, seed, (), suit="normal", logs=plans, disturbed={"kt_warming": size})
    truth = json.loads((folder / "truth.json").read_text())
    with open_study(folder / "study.yaml") as study:
        assert not [each for each in study.notices if each.code in ("session_unknown", "no_run_after")]
        logs = admit(study, worn=True)
        model = identify(study.robot, logs.recordings, study.settings).model
        known, unknown = (
            estimate_support(model, logs.plain, logs.worn, settings)
            for settings in (study.support_settings, replace(study.support_settings, started={}))
        )
    return truth, known, unknown


def test_the_motor_that_bends_the_trunk_is_told_with_its_sign_and_size(told):
    truth, known, _ = told
    (remark,) = [each for each in known[0].remarks if each.about == "drift_found"]
    percent, std = remark.each[remark.names.index("k_T torso_pitch")]
    share = truth["disturbances"]["kt_warming"]["share"]["torso_pitch"]
    true = -100.0 * share * np.mean(truth["session"]["logs"]["bend_plain_7"]["warmer"])
    assert abs(percent - true) < 2.5 * std
    assert std < 0.5 * abs(true)
    assert np.sign(percent) == np.sign(true)


@pytest.mark.parametrize("approach", ["A", "paired"])
def test_the_stiffness_over_the_back_is_nearer_to_the_truth_and_doubted_less(told, approach):
    _, known, unknown = told
    found, today = (
        next(each for each in stiffness if each.approach == approach).bands[0] for _, stiffness in (known, unknown)
    )
    k, before = found.stiffness, today.stiffness
    assert abs(k.value - found.true_stiffness) < 2.0 * k.std
    assert abs(k.value - found.true_stiffness) < abs(before.value - found.true_stiffness) + 1.0
    assert k.std < 0.5 * before.std
