"""From logs to supporting torque and bands in one call: what the result says against what was recorded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from exogauge.studies.words.remark_words import sentence
from exogauge.support.evaluate import consequences, estimate_support, with_values
from exogauge.support.settings import PlainLog, SupportSettings, WornLog

PITCH, YAW = 0, 1  # of a trial's joints
BENT = (3.2, 4.3)  # [s] in which the torso holds its bend


def told_nothing(device):
    return replace(device, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in device.bands))


def anyhow(seed):
    return lambda t: np.random.default_rng([seed, round(100 * t)]).uniform(-1.0, 1.0, 6)


def swaying(k):
    return lambda t: 0.5 + 0.3 * np.sin(t + k)


@pytest.fixture(scope="module")
def recorded(biped, suit, stoop):
    """Two runs without and two with the suit: other base motions, other loads on the feet, other friction at rest."""
    plain = [biped.record(stoop(k), f"plain{k}", share=swaying(k), stuck=anyhow(k)) for k in range(2)]
    worn = [
        biped.record(stoop(5 + k), f"worn{k}", suit.bands, share=swaying(3 * k), stuck=anyhow(9 + k)) for k in range(2)
    ]
    return plain, worn


def asked(recorded, device, motions=("stoop", "stoop")):
    plain, worn = recorded
    without = [PlainLog(each.log, motions[0], True) for each in plain]
    return without, [WornLog(each.log, motions[1], device) for each in worn]


@pytest.fixture(scope="module")
def found(biped, suit, recorded):
    return estimate_support(biped.known(), *asked(recorded, suit))


@pytest.fixture(scope="module")
def truths(biped, recorded, low_passed):
    """(T, D) per worn log, joints in the order of the trials'."""
    return [low_passed(each.support)[:, biped.places("torso_pitch", "torso_yaw")] for each in recorded[1]]


@pytest.mark.slow
def test_trials_are_on_the_logs_own_times_and_name_what_they_were_compared_with(found, recorded):
    trials = found[0].trials
    assert [(t.log, t.reference, t.motion, t.device) for t in trials] == [
        ("worn0", "plain0", "stoop", "suit"), ("worn1", "plain1", "stoop", "suit"),
    ]  # fmt: skip
    for trial, each in zip(trials, recorded[1], strict=True):
        np.testing.assert_array_equal(trial.time, each.log.time)
        assert trial.joints == ("torso_pitch", "torso_yaw")
        assert all(joint.verdict == "equal" for joint in trial.equality)
        assert abs(trial.lag_s) < 1e-3


def test_both_approaches_meet_the_truth_in_steady_motion(found, truths, inner):
    for trial, truth in zip(found[0].trials, truths, strict=True):
        for estimate, counts in ((trial.support_a, trial.compared), (trial.support_b, trial.steady)):
            assert np.abs(estimate - truth)[inner][counts[inner]].max() < 0.02
            assert counts[inner].mean(axis=0).min() > 0.15
        assert np.abs(trial.support_prior - truth)[inner][trial.steady[inner]].max() > 1.0


@pytest.mark.slow
def test_the_ends_of_a_log_in_full_motion_are_not_steady(biped, suit, wander):
    """There the low-pass leans on what was never measured."""
    model, plain = biped.known(), biped.record(wander(1), "plain")
    worn = biped.record(wander(1), "worn", bands=suit.bands)
    logs = [PlainLog(plain.log, "wander", True)], [WornLog(worn.log, "wander", suit)]
    trial = estimate_support(model, *logs)[0].trials[0]
    prepared = model.prepare(worn.log)
    first, last = prepared.kept[0], prepared.kept[-1]
    moving = np.abs(trial.q[1:] - trial.q[:-1]).max(axis=1) > 1e-4
    assert first > 0
    assert moving[: first - 1].any()
    assert moving[last + 1 :].any()
    assert trial.steady[first : last + 1].any()
    assert not trial.steady[:first].any()
    assert not trial.steady[last + 1 :].any()


def test_the_band_model_is_the_torque_that_the_bands_gave(found, truths, suit, inner):
    for trial, truth in zip(found[0].trials, truths, strict=True):
        assert (
            np.abs(trial.band_model - truth)[inner].max() < 0.03
        )  # a low-pass rounds the corner where bands come taut
        for band in suit.bands:
            expected = band.stiffness * np.maximum(trial.length[band.name] - band.natural_length, 0.0)
            np.testing.assert_allclose(trial.tension[band.name], expected, atol=1e-9)
    assert sentence(found[0].band_model["suit"]) == "stiffness and natural length of the device file"


def test_intervals_hold_the_truth_and_the_numbers_lie_in_them(found, truths, biped, inner):
    most = biped.xi["tau_s"].max()
    for trial, truth in zip(found[0].trials, truths, strict=True):
        for low, high, number in (
            (trial.low_a, trial.high_a, trial.support_a),
            (trial.low_b, trial.high_b, trial.support_b),
            (trial.low_paired, trial.high_paired, trial.support_paired),
        ):
            outside = np.maximum(low - truth, truth - high)[inner]
            assert outside[trial.rest[inner]].max() < 0.2 * most  # filters ring where friction jumps
            assert np.mean(outside[trial.rest[inner]] > 1e-3) < 0.05
            assert np.all((low <= number + 1e-9) & (number <= high + 1e-9))


def test_bands_are_identified_by_all_approaches(found, suit):
    by = {each.approach: each for each in found[1]}
    assert set(by) == {"A", "B", "paired", "prior"}
    for approach in ("A", "B", "paired"):
        for estimate, band in zip(by[approach].bands, suit.bands, strict=True):
            assert estimate.stiffness.value == pytest.approx(band.stiffness, rel=1e-3)
            assert estimate.natural_length.value == pytest.approx(band.natural_length, rel=1e-4)
    assert abs(by["prior"].bands[0].stiffness.value - 1500.0) > 10.0


def test_summary_says_what_the_trials_say(found):
    trials, joints = found[0].trials, found[0].joints
    assert [(j.joint, j.motion, j.device) for j in joints] == [
        ("torso_pitch", "stoop", "suit"), ("torso_yaw", "stoop", "suit"),
    ]  # fmt: skip
    for d, joint in enumerate(joints):
        assert joint.logs == ("worn0", "worn1")
        assert joint.references == ("plain0", "plain1")
        for name, own in (
            ("a", "support_a"), ("b", "support_b"), ("paired", "support_paired"), ("prior", "support_prior"),
        ):  # fmt: skip
            lines = [getattr(trial, own)[:, d] for trial in trials]
            errors = np.concatenate([x - trial.band_model[:, d] for x, trial in zip(lines, trials, strict=True)])
            assert joint.rmse[name] == pytest.approx(np.sqrt(np.mean(errors**2)))
            over_a_fifth_of_a_second = [sliding_window_view(x, 20).mean(axis=1) for x in lines]
            side = np.sign(sum(x.max() + x.min() for x in over_a_fifth_of_a_second))  # the same of both runs
            places = [np.argmax(side * x) for x in over_a_fifth_of_a_second[::-1]]  # of one run, read in the other
            peaks = [x[k] for x, k in zip(over_a_fifth_of_a_second, places, strict=True)]
            assert joint.by[name].peak.value == pytest.approx(np.mean(peaks), rel=0.01)
            assert joint.by[name].mean.value == pytest.approx(np.mean([x.mean() for x in lines]))
            seconds = len(trials[0].time) / 100.0
            assert joint.by[name].integral.value == pytest.approx(
                np.mean([x.mean() * seconds for x in lines]), rel=1e-3
            )
            assert joint.spread[name] == pytest.approx(np.std([x.mean() for x in lines], ddof=1))
        steady = np.concatenate([t.steady[:, d] & t.compared[:, d] for t in trials])
        errors = np.concatenate([(t.support_b - t.band_model)[:, d] for t in trials])[steady]
        assert joint.rmse_steady["b"] == pytest.approx(np.sqrt(np.mean(errors**2)))
        assert joint.rest_share == pytest.approx(np.mean([t.rest[:, d].mean() for t in trials]))
        assert joint.masked_share == pytest.approx(np.mean([~t.compared[:, d] for t in trials]))


def test_support_by_phase_is_that_of_the_bend(found, truths):
    trial, pitch = found[0].trials[0], found[0].joints[PITCH]
    assert trial.phase_names == ("standing", "lowering", "holding", "raising")
    holding = (trial.time > BENT[0]) & (trial.time < BENT[1])
    assert np.all(trial.phase[holding] == 2)
    phases = {each.phase: each for each in pitch.phases}
    assert set(phases) == {"standing", "lowering", "holding", "raising"}
    lowering = trial.phase == 1
    assert phases["lowering"].duration_s == pytest.approx(lowering.sum() / 100.0, rel=0.05)
    assert phases["lowering"].by["a"].mean.value == pytest.approx(truths[0][lowering, PITCH].mean(), rel=0.02)
    assert phases["holding"].by["b"].mean.value == pytest.approx(truths[0][holding, PITCH].mean(), rel=0.05)
    assert phases["holding"].by["a"].mean.std > 10.0 * phases["lowering"].by["a"].mean.std  # friction holds


def test_what_approaches_give_without_a_device_is_told_beside(found, biped):
    pitch = found[0].joints[PITCH]
    assert pitch.null["b"] < 0.05
    assert 0.1 < pitch.null["a"] < 2.0 * biped.xi["tau_s"].max()
    assert pitch.rest_half_width >= biped.xi["tau_s"][biped.torso[1]]


def test_without_a_log_of_the_same_motion_there_is_b_alone(biped, suit, recorded, truths, inner):
    result, stiffness = estimate_support(biped.known(), *asked(recorded, suit, ("stoop", "lift")))
    for trial, truth in zip(result.trials, truths, strict=True):
        assert (trial.reference, trial.support_a, trial.support_a_std, trial.low_a, trial.equality) == (None,) * 4 + (
            (),
        )
        assert not trial.compared.any()
        assert np.abs(trial.support_b - truth)[inner][trial.steady[inner]].max() < 0.02
    assert [each.approach for each in stiffness] == ["B", "prior"]
    assert "a" not in result.joints[PITCH].rmse
    assert stiffness[0].bands[0].stiffness.value == pytest.approx(1500.0, rel=1e-3)


def test_a_shifted_run_is_aligned(biped, suit, recorded, truths, inner):
    """The reference begins 0.513 s later in the motion: the same posture comes that much earlier in it."""
    plain, worn = recorded
    late = plain[0].log
    cut = replace(late, time=late.time[51:] - late.time[51], channels={k: v[51:] for k, v in late.channels.items()})
    result, _ = estimate_support(biped.known(), [PlainLog(cut, "stoop", True)], [WornLog(worn[0].log, "stoop", suit)])
    (trial,) = result.trials
    assert trial.lag_s == pytest.approx(-0.51, abs=1e-3)
    assert np.isnan(trial.support_a[:50]).all()
    counts = trial.compared[inner]
    assert np.abs(trial.support_a - truths[0])[inner][counts].max() < 0.05


def test_a_device_without_values_gets_those_identified(biped, suit, recorded, truths, inner):
    unknown = replace(suit, bands=(suit.bands[0], replace(suit.bands[1], stiffness=None, natural_length=None)))
    result, stiffness = estimate_support(biped.known(), *asked(recorded, unknown))
    assert "as identified by approach A" in sentence(result.band_model["suit"])
    assert np.abs(result.trials[0].band_model - truths[0])[inner].max() < 0.05
    filled, _ = with_values(unknown, stiffness)
    assert filled.bands[0] == suit.bands[0]
    assert filled.bands[1].stiffness == stiffness[0].bands[1].stiffness.value
    nothing, why = with_values(told_nothing(suit), ())
    assert nothing is None
    assert sentence(why).startswith("none")


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False])
def test_what_hangs_on_the_model_is_what_the_whole_evaluation_says_of_it(biped, suit, recorded, stated):
    blank = suit if stated else told_nothing(suit)
    result, stiffness = estimate_support(biped.known(), *asked(recorded, blank))
    told = consequences(biped.known(), *asked(recorded, blank))
    assert told.rmse == {(each.device, each.motion, each.joint): each.rmse["b"] for each in result.joints}
    assert told.stiffness == {
        (each.device, each.approach): {band.group: band.stiffness for band in each.bands}
        for each in stiffness
        if each.approach != "prior"
    }


@pytest.mark.slow
def test_two_devices_in_one_study_are_kept_apart(biped, suit, recorded, stoop):
    stiff = replace(suit, name="stiff", bands=tuple(replace(b, stiffness=3000.0) for b in suit.bands))
    more = biped.record(stoop(8), "stiffer", stiff.bands)
    without, worn = asked(recorded, suit)
    result, stiffness = estimate_support(biped.known(), without, [*worn, WornLog(more.log, "stoop", stiff)])
    by = {(each.device, each.approach): each.bands[0].stiffness.value for each in stiffness}
    assert by["suit", "A"] == pytest.approx(1500.0, rel=1e-3)
    assert by["stiff", "A"] == pytest.approx(3000.0, rel=1e-3)
    assert [t.reference for t in result.trials if t.device == "stiff"] == ["plain0"]
    assert {(j.device, j.joint) for j in result.joints} == {
        (device, joint) for device in ("suit", "stiff") for joint in ("torso_pitch", "torso_yaw")
    }


@pytest.mark.slow
def test_nearly_the_same_motion_is_used_and_doubted_in_words(biped, suit, recorded, stoop, low_passed, inner):
    """The bend goes a fifth deeper with the suit; what the model says of the difference is taken off."""
    deeper = biped.record(stoop(5, depth=0.98), "deeper", suit.bands)
    without, _ = asked(recorded, suit)
    result, _ = estimate_support(biped.known(), without, [WornLog(deeper.log, "stoop", suit)], SupportSettings())
    (remark,) = result.remarks
    assert (remark.names, remark.beside) == (("deeper", "plain0"), ("torso_pitch",))
    assert remark.numbers[0] > remark.numbers[1] > 0.0  # the share, the limit
    truth = low_passed(deeper.support)[:, biped.places("torso_pitch", "torso_yaw")]
    (trial,) = result.trials
    assert np.abs(trial.support_a - truth)[inner][trial.compared[inner]].max() < 0.05


@pytest.mark.slow
def test_stated_doubt_of_the_torque_covers_the_error_in_steady_motion(biped, suit, stoop, low_passed, inner):
    """With sensor noise and a robot known to 1 %: the error at one standard deviation is of its size."""
    rng, model = np.random.default_rng(0), biped.known()
    step = 0.01 * rng.normal(size=model.identified.xi.shape) * model.identified.xi
    believed = replace(model, identified=replace(model.identified, xi=model.identified.xi + step))
    variance = np.zeros(model.equations.size)
    variance[model.equations.base_size :] = (0.01 * model.identified.xi.ravel()) ** 2
    believed = replace(believed, covariance=np.diag(variance))
    plain = [PlainLog(biped.record(stoop(k), f"plain{k}", noise=1.0, seed=k).log, "stoop", True) for k in range(2)]
    worn = biped.record(stoop(5), "worn", suit.bands, noise=1.0, seed=7)
    result, _ = estimate_support(believed, plain, [WornLog(worn.log, "stoop", suit)])
    truth, (trial,) = low_passed(worn.support)[:, biped.places("torso_pitch", "torso_yaw")], result.trials
    for estimate, std, counts in (
        (trial.support_a, trial.support_a_std, trial.compared),
        (trial.support_b, trial.support_b_std, trial.steady),
    ):
        ratio = ((estimate - truth) / std)[inner][counts[inner]]
        assert 0.3 < np.sqrt(np.mean(ratio**2)) < 2.0


def test_a_number_at_rest_is_believed_no_further_than_it_is_right(biped, suit, recorded, found, truths, inner):
    """The bend's joint rests while a twist stretches the same bands: the line between its motions does not hold."""
    errors = []
    for trial, truth in zip(found[0].trials, truths, strict=True):
        rest = trial.rest[inner]
        twisted = rest[:, PITCH] & ~rest[:, YAW]
        assert twisted.mean() > 0.2
        error = ((trial.support_b - truth) / trial.support_b_std)[inner]
        errors.append([np.sqrt(np.mean(error[mask, PITCH] ** 2)) for mask in (twisted, rest[:, PITCH])])
        held = (trial.time > BENT[0]) & (trial.time < BENT[1])
        assert trial.support_b_std[held, PITCH].max() < 0.3 * trial.support_b_std[inner][twisted, PITCH].max()
    assert np.mean(errors, axis=0).max() < 1.7
