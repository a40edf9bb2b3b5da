"""A sample as a laboratory records it, through the command as others call it: it ends, and says what it has found."""

import json
import subprocess
import sys

import numpy as np
import pytest

from exogauge.synthetic.disturbances import LAB
from exogauge.synthetic.log_plans import log_plans
from exogauge.synthetic.study import write_study

pytestmark = [pytest.mark.slow, pytest.mark.thorough]
TRIALS = ("1",)
LEFT_OUT = ("id_3", "id_4", "val_2")


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    plans = [p for p in log_plans("normal") if (p.name[-1] in TRIALS if p.repeats else p.name not in LEFT_OUT)]
    write_study(folder / "study", 5, suit="normal", logs=plans, disturbed=LAB)
    with (folder / "study" / "study.yaml").open("a", encoding="utf-8") as file:
        file.write("steps: [identify, support, stiffness]\n")  # with the search it takes ten minutes
    command = [sys.executable, "-m", "exogauge.cli", "run", str(folder / "study"), "--out", str(folder / "out")]
    return folder, subprocess.run(command, capture_output=True, text=True, check=False)


def test_every_step_ends_without_a_traceback(walked):
    folder, done = walked
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert {"report.html", "results.json", "summary.pdf"} <= {path.name for path in (folder / "out").iterdir()}


def test_verdicts_are_given_and_numbers_have_their_doubt(walked):
    folder, _ = walked
    results = json.loads((folder / "out" / "results.json").read_text())
    assert {entry["motion_equality"]["verdict"] for entry in results["support"]} <= {"equal", "doubtful", "different"}
    bands = [each for each in results["stiffness"] if each["approach"] in ("A", "B")]
    assert {each["band"] for each in bands} == {"A_left", "A_right", "B_left", "B_right"}
    for each in bands:
        value, std = each["stiffness_n_per_m"]["value"], each["stiffness_n_per_m"]["std"]
        if value is None or std is None:
            assert not each["identifiable"], each
            assert each["note"], each
        else:
            assert np.isfinite(value)
            assert std > 0.0


def test_the_doctor_lets_it_pass(walked):
    """The doctor may doubt, as in a laboratory; it finds no fault that bars an evaluation."""
    folder, _ = walked
    command = [sys.executable, "-m", "exogauge.cli", "doctor", str(folder / "study")]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout
