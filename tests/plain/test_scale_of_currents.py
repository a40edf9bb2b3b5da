"""The scale of an arm that logs currents alone does not hang on how sure its maker is of k_T."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.plain.stock_robots import ROBOTS
from tests.plain.study_files import plan, write_study

from exogauge.identification.identify import identify
from exogauge.studies.intake.admit import admit
from exogauge.studies.intake.open import open_study

pytestmark = pytest.mark.slow

DOUBTS = (0.02, 0.05, 0.2, 0.5)  # relative, as stated; the stated values are true
MOVES = {"UR5": (0, "point_to_point"), "Panda": (1, "chirp")}


@pytest.fixture(scope="module", params=MOVES)
def found(request, tmp_path_factory):
    """Stated doubt -> (k_T over the true one, its std, held-out errors of the joints by the stated constants)."""
    folder = tmp_path_factory.mktemp("currents")
    seed, style = MOVES[request.param]
    robot = next(each for each in ROBOTS if each.name == request.param)
    write_study(folder / "study", replace(plan(seed), robot=robot, style=style, actuation="current", rate_hz=125.0))
    truth = json.loads((folder / "study/truth.json").read_bytes())["k_T"]
    stated = json.loads((folder / "study/robot.yaml").read_bytes())
    results = {}
    for doubt in DOUBTS:
        for joint in stated["joints"]:
            true = truth[joint["name"]]
            joint |= {"prior": {"k_T": true}, "prior_std": {"k_T": doubt * true}}
        (folder / "study/robot.yaml").write_text(json.dumps(stated))
        with open_study(folder / "study/study.yaml") as study:
            recordings = admit(study, worn=False, progress=lambda *_: None).recordings
            told = identify(study.robot, recordings, study.settings).by_stated_constants()
        k_T = {name: next(p for p in told.parameters if p.name == f"k_T[{name}]") for name in truth}
        errors = {fit.channel: fit.rmse_identified for fit in told.validation if fit.held_out}
        results[doubt] = (
            np.array([k_T[name].value / true for name, true in truth.items()]),
            np.array([k_T[name].std / true for name, true in truth.items()]),
            np.array([errors[f"tau.{name}"] for name in truth]),
        )
    return results


def test_every_torque_constant_is_the_true_one_within_its_doubt(found):
    for value, std, _ in found.values():
        assert np.all(np.abs(value - 1.0) < 2.0 * std)


def test_the_error_does_not_fall_as_the_stated_doubt_grows(found):
    for doubt in DOUBTS[1:]:
        np.testing.assert_allclose(found[doubt][2], found[DOUBTS[0]][2], rtol=0.05)
