"""What is hidden in a sample of MuJoCo is named with its size; what stands in no list is not."""

import json

import numpy as np
import pytest

from exogauge.payload.evaluate import evaluate
from exogauge.payload.intake import open_payload
from exogauge.payload.results import results
from exogauge.synthetic import write_payload_sample
from exogauge.synthetic.payload_hidden import CHANNELS

ALLOWED = 3.5  # standard deviations: one in two thousand is further off


def found_in(folder, seed, hidden=None):
    write_payload_sample(folder, seed, hidden)
    return evaluate(open_payload(folder))


def one(missing):
    assert missing.decision.verdict == "effects"
    assert not missing.suspected
    (finding,) = missing.found
    return finding


def off(finding, truth):
    """Deviations of the parameters from their truth, in standard deviations."""
    return np.array([(p.value - truth[p.name]) / p.std for p in finding.parameters if p.name in truth])


def hidden_in(folder):
    (each,) = json.loads((folder / "truth.json").read_text(encoding="utf-8"))["hidden"]
    return each


def test_where_nothing_is_hidden_nothing_is_missing(tmp_path):
    missing = found_in(tmp_path / "p", 3).missing
    assert missing.decision.verdict == "none"
    assert not missing.found
    assert not missing.suspected
    assert all(np.all(np.abs(ratios - 1.0) < 0.15) for ratios in missing.after.values())


def test_a_late_wrench_is_named_and_no_longer_taken_for_a_touch(tmp_path):
    evaluation = found_in(tmp_path / "p", 3, ["delay"])
    finding = one(evaluation.missing)
    assert (finding.effect, finding.rivals) == ("delay", ())
    assert np.all(np.abs(off(finding, {"late": 1e3 * hidden_in(tmp_path / "p")["seconds"]})) < ALLOWED)
    assert not any("touched" in each for each in evaluation.warnings)


def test_a_zero_that_jumps_is_named_with_its_moment(tmp_path):
    finding = one(found_in(tmp_path / "p", 3, ["zero_step@excitation"]).missing)
    assert (finding.effect, finding.place) == ("zero_step", "excitation")
    truth = dict(zip(CHANNELS, hidden_in(tmp_path / "p")["wrench"], strict=True)) | {"at": 4.998}
    assert np.all(np.abs(off(finding, truth)) < ALLOWED)


@pytest.mark.slow
@pytest.mark.parametrize(("hidden", "effect", "place"), [
    ("zero_of_log@fast", "zero_of_log", "fast"), ("zero_drift", "zero_drift", "sensor"),
    ("crosstalk@my_fx", "crosstalk", "my of fx"), ("gain@fz", "gain", "fz"), ("spring", "spring", "xy"),
])  # fmt: skip
def test_what_is_hidden_is_named_with_its_size(tmp_path, hidden, effect, place):
    finding = one(found_in(tmp_path / "p", 4, [hidden]).missing)
    assert (finding.effect, finding.place) == (effect, place)
    truth = hidden_in(tmp_path / "p")
    values = truth.get("wrench") or truth.get("rate")
    truth |= dict(zip(CHANNELS, values, strict=True)) if values else {}
    assert np.all(np.abs(off(finding, truth)) < ALLOWED)
    assert finding.after < 1.05 < finding.before


@pytest.mark.slow
def test_with_a_spring_named_mass_and_inertia_are_those_of_the_truth_again(tmp_path):
    evaluation = found_in(tmp_path / "p", 4, ["spring"])
    missing = evaluation.missing
    truth = json.loads((tmp_path / "p" / "truth.json").read_text(encoding="utf-8"))
    x = np.array([truth["mass"], *truth["first_moment"]])
    std = np.sqrt(np.diag(missing.covariance))[:4]
    assert np.all(np.abs(missing.x[:4] - x) < 4.0 * std)
    assert abs(missing.x[3] - x[3]) < 0.2 * abs(evaluation.excitation.chosen.value[3] - x[3])


@pytest.mark.slow
def test_what_stands_in_no_list_is_unexplained(tmp_path):
    evaluation = found_in(tmp_path / "p", 4, ["hose"])
    missing = evaluation.missing
    assert missing.decision.verdict == "unexplained"
    assert not missing.found
    assert "nothing here explains" in results(evaluation).missing.said


@pytest.mark.slow
def test_a_body_that_hangs_loose_is_named_or_unexplained_and_its_size_not_told_where_errors_look_like_it(tmp_path):
    missing = found_in(tmp_path / "p", 8, ["second_body"]).missing
    assert missing.decision.verdict in ("effects", "unexplained")
    assert all(each.effect == "second_body" for each in missing.found)
    truth = hidden_in(tmp_path / "p")
    for each in missing.found:
        assert np.all(np.abs(off(each, truth | dict(zip("xyz", truth["point"], strict=True)))) < ALLOWED)


def test_of_an_exact_wrench_nothing_is_missing(tmp_path, monkeypatch):
    """No noise at all: what rounding and smoothing leave is less than any sensor's."""
    from exogauge.synthetic import payload as generator

    monkeypatch.setattr(generator, "measured", lambda q, wrench, _rng: (q, wrench))
    missing = found_in(tmp_path / "p", 3).missing
    assert not missing.found
    assert all(np.isfinite(each).all() for each in missing.after.values())


def test_without_a_log_that_was_kept_from_the_fit_nothing_is_called_nothing(tmp_path):
    write_payload_sample(tmp_path / "p", 3)
    file = tmp_path / "p" / "payload.yaml"
    kept = [line for line in file.read_text(encoding="utf-8").splitlines() if "role: test" not in line]
    file.write_text("\n".join(kept), encoding="utf-8")
    missing = evaluate(open_payload(tmp_path / "p")).missing
    assert missing.decision.verdict == "undecided"
    assert missing.decision.reason.why == "not_held_out"
