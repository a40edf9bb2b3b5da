"""What is hidden in a sample of MuJoCo is named with its size; what stands in no list is not."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.payload.conftest import STD

from exogauge.findings.verdict import Caveat, Decision
from exogauge.payload.dynamics import reading_of_mu
from exogauge.payload.evaluate import evaluate
from exogauge.payload.exports.formats import export
from exogauge.payload.intake import open_payload
from exogauge.payload.missing.search import Finding, unjudged
from exogauge.payload.missing.words import cause_of_residual, verdict_of
from exogauge.payload.results import results
from exogauge.synthetic import write_payload_sample
from exogauge.synthetic.payload_hidden import CHANNELS

ALLOWED = 3.5  # standard deviations: one in two thousand is further off


@pytest.fixture(scope="module")
def found_in(tmp_path_factory):
    """(seed, what is hidden) -> (what an evaluation says, its folder): made once, however many tests look at it."""

    @cache
    def made(seed, *hidden):
        folder = tmp_path_factory.mktemp("payload") / "p"
        write_payload_sample(folder, seed, list(hidden) or None)
        return evaluate(open_payload(folder)), folder

    return made


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


@pytest.mark.slow
def test_where_nothing_is_hidden_nothing_is_missing(found_in):
    missing = found_in(3)[0].missing
    assert missing.decision.verdict == "none"
    assert not missing.found
    assert not missing.suspected
    assert all(np.all(np.abs(ratios - 1.0) < 0.15) for ratios in missing.after.values())


@pytest.mark.slow
def test_a_late_wrench_is_named_and_no_longer_taken_for_a_touch(found_in):
    evaluation, folder = found_in(4, "delay")
    finding = one(evaluation.missing)
    assert (finding.effect, finding.rivals) == ("delay", ())
    assert np.all(np.abs(off(finding, {"late": 1e3 * hidden_in(folder)["seconds"]})) < ALLOWED)
    assert not any("touched" in each for each in evaluation.warnings)


@pytest.mark.slow
def test_a_zero_that_jumps_is_named_with_its_moment(found_in):
    evaluation, folder = found_in(4, "zero_step@excitation")
    finding = one(evaluation.missing)
    assert (finding.effect, finding.place) == ("zero_step", "excitation")
    truth = dict(zip(CHANNELS, hidden_in(folder)["wrench"], strict=True)) | {"at": 4.998}
    assert np.all(np.abs(off(finding, truth)) < ALLOWED)


@pytest.mark.slow
@pytest.mark.parametrize(("hidden", "effect", "place"), [
    ("zero_of_log@fast", "zero_of_log", "fast"), ("zero_drift", "zero_drift", "sensor"), ("gain@fz", "gain", "fz"),
    pytest.param("crosstalk@my_fx", "crosstalk", "my of fx", marks=pytest.mark.thorough), ("spring", "spring", "xy"),
])  # fmt: skip
def test_what_is_hidden_is_named_with_its_size(found_in, hidden, effect, place):
    evaluation, folder = found_in(4, hidden)
    finding = one(evaluation.missing)
    assert (finding.effect, finding.place) == (effect, place)
    truth = hidden_in(folder)
    values = truth.get("wrench") or truth.get("rate")
    truth |= dict(zip(CHANNELS, values, strict=True)) if values else {}
    assert np.all(np.abs(off(finding, truth)) < ALLOWED)
    assert finding.after < 1.05 < finding.before


HIDDEN = [
    "delay", "gain@fz", pytest.param("crosstalk@my_fx", marks=pytest.mark.thorough), "zero_step@excitation", "spring",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("hidden", HIDDEN)
def test_the_estimates_come_with_what_was_named(found_in, hidden):
    """Body and inclination within their doubt of the truth, what is left at the noise; uncorrected, they are not."""
    evaluation, folder = found_in(4, hidden)
    found, truth = results(evaluation), json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert found.missing.in_the_model
    tensor = np.array(truth["inertia_about_sensor"])[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    x = np.array([truth["mass"], *truth["first_moment"], *tensor])

    std = np.array([each.std for each in found.dynamic.values[:10]])
    corrected, rigid = (
        np.abs([each.value for each in values[:10]] - x) / std
        for values in (found.dynamic.values, found.missing.without)
    )
    assert np.all(corrected < ALLOWED)
    if found.calibration is None or not hidden.startswith("gain"):  # beside a gain, all others are as doubtful
        assert rigid.max() > 2 * corrected.max()
    tilt = [(each.value - t) / each.std for each, t in zip(found.static.values[10:], truth["tilt_deg"], strict=True)]
    assert np.all(np.abs(tilt) < ALLOWED)
    assert export(found, "json").count(repr(found.dynamic.values[0].value)) == 1
    for ways in found.tests.values():
        left, uncorrected = (np.array(ways[way].rms) / STD for way in ("all", "rigid"))
        assert np.linalg.norm(left) < np.linalg.norm(uncorrected)
        assert np.all(left < [1.2] * 3 + [2.6] * 3)
    assert abs(found.dynamic.mu - 1.0) < 0.1
    assert not [each for each in found.warnings if "residual" in each]


@pytest.mark.slow
def test_the_doubt_of_what_was_named_is_in_the_estimates(found_in):
    """A body that takes a gain's doubt along is less certain than one whose gain is known."""
    evaluation, _ = found_in(4, "gain@fz")
    found = results(evaluation)
    added = evaluation.missing.doubt
    assert np.linalg.eigvalsh(added).min() > -1e-9 * np.linalg.eigvalsh(added).max()
    assert found.dynamic.values[0].std ** 2 > added[0, 0] > 0.0


def test_mu_says_the_cause_that_was_named():
    named = Finding("delay", "sensor", (), 9.0, 2.0, 1.0, (("zero_drift", "sensor"),))
    missing = replace(unjudged(Caveat("not_held_out")), found=(named,))
    assert reading_of_mu(2.0, 0.01, cause_of_residual(missing, noisier=False)).endswith(
        "the wrench is late against the pose."
    )
    unexplained = replace(missing, found=(), decision=Decision("unexplained", "above", None))
    assert "nothing here explains" in cause_of_residual(unexplained, noisier=False)
    none = replace(missing, found=(), decision=Decision("none", "nothing", None))
    assert "stated too small" in cause_of_residual(none, noisier=True)
    assert "too small to be named" in cause_of_residual(none, noisier=False)
    assert "do not hold" in verdict_of(replace(missing, decision=Decision("effects", "nothing", None)))


@pytest.mark.thorough
def test_damping_is_not_less_by_what_the_smoother_took_away(found_in):
    """By the fast part of smoothed accelerations it comes out at 55 to 94 % of the truth."""
    off_by, shares = [], []
    for seed in (4, 301, 302):
        evaluation, folder = found_in(seed, "spring")
        finding, truth = one(evaluation.missing), hidden_in(folder)
        off_by.append(off(finding, truth))
        damping = next(each for each in finding.parameters if each.name == "damping_ratio")
        shares.append((damping.value / truth["damping_ratio"], damping.std / damping.value))
    assert np.abs(off_by).max() < ALLOWED
    assert np.mean(shares, axis=0)[0] == pytest.approx(1.0, abs=0.05)
    assert np.max(shares, axis=0)[1] < 0.2


@pytest.mark.thorough
def test_what_stands_in_no_list_is_unexplained(found_in):
    evaluation, _ = found_in(4, "hose")
    missing = evaluation.missing
    assert missing.decision.verdict == "unexplained"
    assert not missing.found
    assert "nothing here explains" in results(evaluation).missing.said


@pytest.mark.thorough
def test_a_body_that_hangs_loose_is_named_or_unexplained_and_its_size_not_told_where_errors_look_like_it(found_in):
    evaluation, folder = found_in(8, "second_body")
    missing = evaluation.missing
    assert missing.decision.verdict in ("effects", "unexplained")
    assert all(each.effect == "second_body" for each in missing.found)
    truth = hidden_in(folder)
    for each in missing.found:
        assert np.all(np.abs(off(each, truth | dict(zip("xyz", truth["point"], strict=True)))) < ALLOWED)


@pytest.mark.slow
def test_of_an_exact_wrench_nothing_is_missing(tmp_path, monkeypatch):
    """No noise at all: what rounding and smoothing leave is less than any sensor's."""
    from exogauge.synthetic import payload as generator

    monkeypatch.setattr(generator, "measured", lambda q, wrench, _rng: (q, wrench))
    write_payload_sample(tmp_path / "p", 3)
    missing = evaluate(open_payload(tmp_path / "p")).missing
    assert not missing.found
    assert all(np.isfinite(each).all() for each in missing.after.values())


@pytest.mark.slow
def test_without_a_log_that_was_kept_from_the_fit_nothing_is_called_nothing(tmp_path):
    write_payload_sample(tmp_path / "p", 3)
    file = tmp_path / "p" / "payload.yaml"
    kept = [line for line in file.read_text(encoding="utf-8").splitlines() if "role: test" not in line]
    file.write_text("\n".join(kept), encoding="utf-8")
    missing = evaluate(open_payload(tmp_path / "p")).missing
    assert missing.decision.verdict == "undecided"
    assert missing.decision.reason.why == "not_held_out"
