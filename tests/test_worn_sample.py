"""The suit on the ideal sample: bands pulled by MuJoCo's tendons, evaluated without the truth, scored against it."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.errors import BadStudy
from exogauge.studies.evaluate import evaluate
from exogauge.synthetic.disturbances import IDEAL
from exogauge.synthetic.log_plans import log_plans
from exogauge.synthetic.study import write_study

pytestmark = pytest.mark.slow
TRIALS = ("1", "2")
LEFT_OUT = ("id_3", "id_4", "val_2")  # the robot is known well enough without them
JOINTS = {"bend": "torso_pitch", "twist": "torso_yaw"}


def quiet(*_):
    pass


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    folder = tmp_path_factory.mktemp("worn") / "study"
    plans = [p for p in log_plans("modified") if (p.name[-1] in TRIALS if p.repeats else p.name not in LEFT_OUT)]
    write_study(folder, 4, suit="modified", logs=plans, disturbed=IDEAL)
    return folder


@pytest.fixture(scope="module")
def scored(sample):
    out = sample.parent / "out"
    evaluate(sample / "study.yaml", out, quiet)
    return json.loads((out / "results.json").read_text()), json.loads((sample / "truth.json").read_text()), out


def test_the_bands_are_found_within_what_is_stated(scored):
    results, truth, _ = scored
    limits = {"A": 3.0, "B": 6.0}
    for each in results["stiffness"]:
        if each["approach"] in limits:
            true = truth["bands"][each["band"]]
            for name in ("stiffness_n_per_m", "natural_length_m"):
                low, high = each["interval_95"][name]
                assert low <= true[name] <= high, (each["approach"], each["band"], name)
            if each["group"] == "A":
                error = 100.0 * abs(each["stiffness_n_per_m"]["value"] / true["stiffness_n_per_m"] - 1.0)
                assert error < limits[each["approach"]]
                assert abs(each["error_percent"]) == pytest.approx(error)
    assert {each["approach"] for each in results["stiffness"]} == {"A", "B", "paired", "prior"}


def test_a_beats_b_beats_the_makers_values(scored):
    results, _, _ = scored
    for motion, joint in JOINTS.items():
        (entry,) = [s for s in results["support"] if (s["motion"], s["joint"]) == (motion, joint)]
        assert entry["rmse_a"] < entry["rmse_b"] < entry["rmse_prior"]
        assert entry["motion_equality"]["verdict"] == "equal"
        assert len(entry["logs"]) == len(TRIALS)


def test_the_hidden_friction_is_named_and_approach_b_comes_closer(scored):
    results, truth, _ = scored
    found = results["discrepancy"]
    assert found["verdict"] == "effects"
    named = [(each["effect"], each["where"]) for each in found["findings"]]
    assert (
        named
        == [(each["effect"], each["where"]) for each in truth["effects"]]
        == [("stribeck", {"joint": "torso_pitch"})]
    )
    (finding,) = found["findings"]
    for name in ("tau_b", "v_s"):
        estimate, true = finding["parameters"][name], truth["effects"][0]["parameters"][name]
        assert abs(estimate["value"] - true) < max(4.0 * estimate["std"], 0.05 * true), name
    assert finding["held_out"]["rmse_after"] < 1.1 * finding["held_out"]["noise_floor"]
    closer = [each for name, each in found["before_after"].items() if "RMSE" in name and "torso_pitch" in name]
    assert closer
    assert all(each["after"]["value"] < 0.7 * each["before"]["value"] for each in closer)


def test_where_a_joint_rests_the_interval_holds_the_truth(scored):
    """The device file of the sample is true, so its band model is what MuJoCo's tendons pulled with."""
    _, _, out = scored
    for motion, joint in JOINTS.items():
        for trial in TRIALS:
            table = pq.read_table(out / "series" / f"{motion}_modified_{trial}.parquet")
            rest = np.array(table[f"support_rest.{joint}"])
            true = np.array(table[f"support_band_model.{joint}"])
            low, high = (np.array(table[f"support_b_{end}.{joint}"]) for end in ("low", "high"))
            assert rest.sum() > 200
            assert np.mean((low <= true) & (true <= high), where=rest) > 0.99


def test_in_steady_motion_the_stated_deviation_is_what_is_met(scored):
    _, _, out = scored
    for approach in ("a", "b"):
        errors = []
        for motion, joint in JOINTS.items():
            for trial in TRIALS:
                table = pq.read_table(out / "series" / f"{motion}_modified_{trial}.parquet")
                counts = np.array(table[f"support_compared.{joint}"]) & np.array(table[f"support_steady.{joint}"])
                columns = (
                    f"support_{approach}.{joint}",
                    f"support_band_model.{joint}",
                    f"support_{approach}_std.{joint}",
                )
                value, true, std = (np.array(table[column])[counts] for column in columns)
                errors.append((value - true) / std)
        assert 0.3 < np.sqrt(np.mean(np.concatenate(errors) ** 2)) < 1.5


def test_another_motion_under_the_same_name_is_refused_before_anything_is_computed(sample, tmp_path):
    study = yaml.safe_load((sample / "study.yaml").read_text())
    swapped = {"logs/bend_modified_1.parquet": "logs/twist_modified_1.parquet"}
    for entry in study["logs"]:
        entry["file"] = swapped.get(entry["file"], entry["file"])
        entry["name"] = f"{entry['role']}_{study['logs'].index(entry)}"
    (sample / "swapped.yaml").write_text(yaml.safe_dump(study))
    with pytest.raises(BadStudy) as refused:
        evaluate(sample / "swapped.yaml", tmp_path, quiet)
    fault = refused.value.faults[0]
    assert fault.rule == "motions_differ"
    assert "torso" in fault.column
    assert "rad rms" in fault.detail or "rad/s" in fault.detail
    assert not (tmp_path / "results.json").exists()
