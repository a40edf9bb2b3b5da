"""The ideal sample through the product: made by MuJoCo, evaluated without its truth, then scored against it."""

import json
import subprocess
import sys

import numpy as np
import pytest

from exogauge.synthetic.log_plans import log_plans
from exogauge.synthetic.study import write_study

pytestmark = [pytest.mark.slow, pytest.mark.thorough]
LOGS = ("id_1", "id_2", "val_1", "bend_plain", "twist_plain")

EVALUATED = """
import sys
from pathlib import Path
from exogauge.studies.evaluate import evaluate
folder = Path(sys.argv[1])
evaluate(folder / "study" / "study.yaml", folder / "out", lambda *_: None)

from numba.core.sigutils import normalize_signature
from exogauge.loops.compiled import ahead
declared = {}
for loop, types in ahead:
    declared.setdefault(loop, set()).add(normalize_signature(types)[0])
for loop, types in declared.items():
    for called in set(loop.signatures) - types:
        print(loop.py_func.__name__, called)
"""


@pytest.fixture(scope="module")
def scored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sample")
    write_study(folder / "study", 1, suit="none", logs=[plan for plan in log_plans("none") if plan.name in LOGS])
    done = subprocess.run([sys.executable, "-c", EVALUATED, folder], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "", "loops were called with types for which they are not compiled ahead"
    results = json.loads((folder / "out" / "results.json").read_text())
    assert results["discrepancy"]["verdict"] == "none"  # nothing is hidden in it
    return results["identification"], json.loads((folder / "study" / "truth.json").read_text())["parameters"]


def pooled(results, channels, key):
    chosen = [v for v in results["validation"] if v["held_out"] and v["channel"] in channels and v.get(key) is not None]
    assert chosen
    return np.sqrt(np.mean([v[key] ** 2 for v in chosen]))


@pytest.mark.parametrize(
    "channels", [("base.mx", "base.my", "base.mz"), ("tau.torso_yaw", "tau.torso_pitch")], ids=["base", "torso"]
)
def test_held_out_error_falls_below_half_of_the_makers(scored, channels):
    results, _ = scored
    assert pooled(results, channels, "rmse_identified") < 0.5 * pooled(results, channels, "rmse_prior")


def test_where_friction_is_the_modelled_one_the_error_is_the_sensors_noise(scored):
    results, _ = scored
    for channel in {v["channel"] for v in results["validation"]}:
        assert pooled(results, (channel,), "rmse_moving") < 1.1 * pooled(results, (channel,), "noise_floor"), channel


def test_intervals_hold_the_truth_as_often_as_they_say(scored):
    results, truth = scored
    inside = []
    for p in results["parameters"]:
        if p["identifiable"]:
            true = sum(c * truth[name] for name, c in p.get("combination", {p["name"]: 1.0}).items())
            inside.append(abs(p["value"] - true) < 1.96 * p["std"])
    assert len(inside) > 300
    assert 0.90 <= np.mean(inside) <= 0.99
