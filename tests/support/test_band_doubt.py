"""How far identified bands can be believed: against finite differences, repeated draws and what a model lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter
from tests.draws import drawn, met_in

from exogauge.devices.device import Device
from exogauge.devices.routing import Routing
from exogauge.identification.predict import Parameters
from exogauge.support.band_doubt import blocks, score_covariance
from exogauge.support.band_fit import best_start, starts
from exogauge.support.band_inputs import nuisance_torques
from exogauge.support.band_model import Belief, Setting, fit, shared
from exogauge.support.band_rows import WearLog, WearLogs, band_wires
from exogauge.support.coloured import autocovariance
from exogauge.support.evaluate import estimate_support
from exogauge.support.evidence import Nothing
from exogauge.support.rows_of_approach import rows_with
from exogauge.support.settings import PlainLog, WornLog
from exogauge.support.stiffness import fit_springs, identify_bands

SIGMA = np.array([0.3, 0.3])
NAMES = ["torso_pitch", "torso_yaw"]
TRUE = 1500.0


def told_nothing(device: Device) -> Device:
    return replace(device, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in device.bands))


def fitted(biped, device, evidences):
    """With equal weights, as if nothing lasted."""
    columns = np.array([biped.robot.tree.joints.index(name) for name in NAMES])
    logs = rows_with(evidences, "A", columns, NAMES, biped.known().cutoff_hz)
    wires, plan = band_wires(logs, Routing(biped.robot.tree, device.bands)), shared(device.bands)
    belief = Belief(np.zeros(3), np.zeros((3, 3)))
    setting = Setting(logs, wires, logs.used / SIGMA**2, float(logs.used.sum()), belief)
    return setting, fit(setting, best_start(setting, starts(plan, wires, ())))


def in_order(estimates):
    return np.array([estimates[0].stiffness.value, *(each.natural_length.value for each in estimates)])


@pytest.fixture(scope="module")
def logs(biped, suit, wander):
    """One run without and one with the suit, in other motions of the base."""
    plain, worn = biped.record(wander(1, base_seed=7), "plain"), biped.record(wander(1), "worn", bands=suit.bands)
    return [PlainLog(plain.log, "wander", True)], [WornLog(worn.log, "wander", told_nothing(suit))]


def moved(biped, model, direction, size):
    """The model with other parameters, and the step in those of its equations. direction: random φ and ξ."""
    phi, xi = (size * each for each in direction)
    x = np.concatenate([model.equations.base.regroup @ phi.ravel(), xi.ravel()])
    return replace(model, identified=Parameters(model.identified.phi + phi, model.identified.xi + xi)), x


@pytest.mark.slow
@pytest.mark.parametrize("approach", ["A", "B"])
def test_doubt_of_the_robots_parameters_reaches_the_bands_as_the_estimate_follows_them(biped, suit, logs, approach):
    """Their covariance along one random direction; the estimate moved along it, by so little that the joints keep
    their weights."""
    model, rng = biped.known(), np.random.default_rng(0)
    relative = 0.05 * rng.normal(size=model.identified.xi.shape)
    direction = 0.02 * rng.normal(size=biped.phi.shape), relative * model.identified.xi

    def bands(of):
        return next(each for each in estimate_support(of, *logs)[1] if each.approach == approach).bands

    ahead, behind = (in_order(bands(moved(biped, model, direction, size)[0])) for size in (1e-4, -1e-4))
    slope = (ahead - behind) / 2e-4
    x = moved(biped, model, direction, 1.0)[1]
    doubtful = replace(model, covariance=np.outer(x, x))
    found = bands(doubtful)
    std = np.array([found[0].stiffness.std, *(each.natural_length.std for each in found)])
    np.testing.assert_allclose(std, np.abs(slope), rtol=0.1)
    assert std[0] > 10.0


@pytest.mark.slow
def test_what_a_model_lacks_in_logs_without_the_device_counts_as_doubt_of_b(biped, suit, stoop, wander):
    """Friction that no model knows, in both runs: B's stiffness is wrong by it, and says so; A takes it off."""

    def extra(speed):
        return 1.5 * np.tanh(speed / 0.2) ** 3

    model = biped.known()
    plain = [PlainLog(biped.record(stoop(k), f"plain{k}", extra=extra).log, "stoop", True) for k in range(2)]
    worn = [WornLog(biped.record(stoop(5), "worn", bands=suit.bands, extra=extra).log, "stoop", told_nothing(suit))]
    results = {each.approach: each for each in estimate_support(model, plain, worn)[1]}
    a, b = (results[approach].bands[0].stiffness for approach in "AB")
    assert abs(a.value - TRUE) < 0.002 * TRUE
    for estimate, true in zip(results["B"].bands, suit.bands, strict=True):
        assert abs(estimate.stiffness.value - TRUE) < 2.5 * estimate.stiffness.std
        assert abs(estimate.natural_length.value - true.natural_length) < 2.5 * estimate.natural_length.std
    assert b.std > 3.0 * a.std
    once, often = (
        {each.approach: each for each in estimate_support(model, plain[:1] * times, worn)[1]} for times in (1, 6)
    )
    assert often["B"].bands[0].stiffness.std == pytest.approx(once["B"].bands[0].stiffness.std, rel=0.05)


def test_the_score_of_a_log_without_the_device_is_the_bias_that_its_error_makes(biped, suit, make_evidence, stoop):
    """A constant torque that is not the device's, the same on both logs: the doubt grows by the shift it causes."""
    evidence = make_evidence(suit, stoop(1))
    offset = np.array([0.4, -0.2])
    wrong = replace(evidence, b=evidence.b + offset)
    kept = evidence.kept
    null = Nothing("motion", evidence.time[kept], evidence.posture[kept], np.broadcast_to(offset, (len(kept), 2)),
                   np.zeros((len(kept), 2)), np.ones((len(kept), 2), dtype=bool))  # fmt: skip
    model, device = biped.known(), told_nothing(suit)

    def identified(torque, null_logs):
        bands = identify_bands(model, device, "B", [torque], SIGMA, null_logs, NAMES).bands
        stds = [bands[0].stiffness.std, *(each.natural_length.std for each in bands)]
        return in_order(bands), np.array(stds)

    (right, _), (found, alone), (_, twice) = (
        identified(*case) for case in ((evidence, []), (wrong, []), (wrong, [null, null]))
    )
    std = identified(wrong, [null])[1]
    assert abs(found - right)[0] > 5.0
    np.testing.assert_allclose(np.sqrt(std**2 - alone**2), np.abs(found - right), rtol=0.25)
    np.testing.assert_allclose(twice, std, rtol=1e-6)  # two logs without stand for one with it


def test_blocks_are_long_against_the_memory_of_the_errors_and_never_span_two_logs(
    biped, suit, make_evidence, stoop, wander
):
    evidences = [make_evidence(suit, course, noise=0.3, seed=k) for k, course in enumerate([stoop(1), wander(2)])]
    setting, found = fitted(biped, suit, evidences)
    number, log = blocks(setting.logs, found.e), setting.logs.log
    assert np.all(np.diff(number) >= 0)
    assert len(np.unique(number)) == number.max() + 1
    assert not set(number[log == 0]) & set(number[log == 1])
    lengths = np.bincount(number)[:5] / 50.0
    assert lengths.min() > 0.45
    assert len(lengths) >= 5


def test_samples_that_do_not_count_are_left_out_by_approach(biped, suit, make_evidence, stoop):
    evidence = make_evidence(suit, stoop(1))
    steady, compared = evidence.steady.copy(), evidence.compared.copy()
    steady[:600], compared[700:] = False, False
    a = np.where(np.arange(len(evidence.time))[:, None] < 100, np.nan, evidence.a)
    evidence = replace(evidence, steady=steady, compared=compared, a=a)
    time = evidence.time[evidence.kept]
    for approach, chosen in (("A", (time >= 1.0) & (time < 7.0)), ("B", time >= 6.0), ("prior", time >= 6.0)):
        samples = rows_with([evidence], approach, np.array([2, 3]), NAMES, 20.0)
        np.testing.assert_array_equal(samples.used.all(axis=1), chosen)
        assert np.isfinite(samples.torque).all()


def test_autocovariance_is_that_of_errors_with_a_memory_gaps_or_not():
    rng, rho = np.random.default_rng(0), 0.9
    e = lfilter([np.sqrt(1 - rho**2)], [1.0, -rho], rng.normal(size=200_000))
    used = np.ones(len(e), dtype=bool)
    used[rng.integers(0, len(e), 40_000)] = False
    for mask in (np.ones(len(e), dtype=bool), used):
        found = autocovariance(2.0 * e * mask, mask)
        np.testing.assert_allclose(found[:20], 4.0 * rho ** np.arange(20), atol=0.1)
    assert len(autocovariance(rng.normal(size=400), np.ones(400, dtype=bool))) < 20


def test_the_doubt_of_the_score_is_no_less_than_either_of_its_two_estimates_says(biped, suit, make_evidence, stoop):
    setting, found = fitted(biped, suit, [make_evidence(suit, stoop(1), noise=0.5)])
    rows, number = np.einsum("ndp,nd->np", found.A, setting.weight * found.e), blocks(setting.logs, found.e)
    scores = np.stack([rows[number == each].sum(axis=0) for each in range(number.max() + 1)])
    weighted = found.A * setting.weight[:, :, None]
    whole, size = score_covariance(setting.logs, found.e, weighted), np.sqrt(np.sum(scores**2, axis=0))
    more = (whole - scores.T @ scores) / np.outer(size, size)
    assert np.linalg.eigvalsh(more).min() > -1e-9
    # errors of one joint, alike at all times: Σ g^T C g, with C written out
    expected = np.zeros((3, 3))
    for joint in range(2):
        e = found.e[:, joint]
        c = autocovariance(e, np.ones(len(e), dtype=bool))
        C = toeplitz(np.r_[c, np.zeros(len(e) - len(c))])
        g = found.A[:, joint] / SIGMA[joint] ** 2
        expected += g.T @ C @ g
    assert np.linalg.eigvalsh((whole - expected) / np.outer(size, size)).min() > -1e-9


@pytest.mark.slow
@drawn(50, 200)
@pytest.mark.parametrize("noise", [0.25, 1.0])
def test_95_percent_intervals_hold_the_truth_in_95_of_100_draws(
    biped, suit, make_evidence, stoop, wander, noise, draws
):
    """Errors last 0.2 s."""
    courses, model, hits = [stoop(1), wander(4)], biped.known(), []
    for draw in range(draws):
        evidences = [make_evidence(suit, c, noise=noise, seed=1000 * draw + k) for k, c in enumerate(courses)]
        springs = fit_springs(model, told_nothing(suit), "A", evidences, SIGMA, [], NAMES)
        (stiffness, left), (_, right) = springs.intervals(0), springs.intervals(1)
        told = (stiffness, TRUE), (left, 0.67), (right, 0.68)
        hits.append([low <= true <= high for (low, high), true in told])
    (least, most), share = met_in(0.95, draws), np.mean(hits, axis=0)
    assert np.all(share >= least), share
    assert share[0] <= most


@pytest.mark.slow
@drawn(50, 200)
def test_intervals_hold_the_truth_though_errors_grow_with_the_pull(biped, suit, make_evidence, stoop, draws):
    """As an error of the motor constant would: four times as large at the deepest bend."""
    courses, model, hits = [stoop(k) for k in range(3)], biped.known(), []
    for draw in range(draws):
        evidences = []
        for k, course in enumerate(courses):
            clean, noisy = (make_evidence(suit, course, noise=noise, seed=1000 * draw + k) for noise in (0.0, 0.3))
            growing = 1.0 + 3.0 * np.abs(clean.a) / np.abs(clean.a).max()
            evidences.append(replace(noisy, a=clean.a + growing * (noisy.a - clean.a)))
        (low, high), _ = fit_springs(model, told_nothing(suit), "A", evidences, SIGMA, [], NAMES).intervals(0)
        hits.append(low <= TRUE <= high)
    least, most = met_in(0.94, draws)
    assert least <= np.mean(hits) <= most


@pytest.mark.slow
@drawn(40, 200)
def test_where_doubt_is_skewed_the_profile_holds_the_truth_at_least_as_often(biped, suit, make_evidence, stoop, draws):
    """Errors as large as the pull."""
    model, profile, symmetric = biped.known(), [], []
    course = stoop(1, depth=0.5)
    for draw in range(draws):
        evidence = make_evidence(suit, course, noise=2.5, seed=draw)
        springs = fit_springs(model, told_nothing(suit), "A", [evidence], SIGMA, [], NAMES)
        ((low, high), _), (stiffness, _) = springs.intervals(0), springs.of(0)
        profile.append(low <= TRUE <= high)
        symmetric.append(abs(stiffness.value - TRUE) <= 1.96 * stiffness.std)
    assert np.mean(profile) >= np.mean(symmetric)
    assert np.mean(profile) >= met_in(0.95, draws)[0]


def test_how_the_device_sits_is_no_column_where_the_samples_tell_nothing_of_it(biped, suit, make_evidence, stoop):
    """Springs that pull next to nowhere, as where a via point is on the wrong link: it was a crash."""
    worn = replace(suit, bands=tuple(replace(band, point_std=0.005) for band in suit.bands))
    setting, found = fitted(biped, worn, [make_evidence(worn, stoop(0), noise=0.3, seed=0)])
    assert nuisance_torques(setting, found) is not None
    nothing = replace(setting, weight=1e-9 * setting.weight)
    beside = replace(nothing, added=nuisance_torques(nothing, found)).nuisances
    np.testing.assert_array_equal(beside.without(found.e), found.e)


def minus_one_partner(rng, lags, n=800, memory=12, shared=True):
    """Errors of logs from which the same log was taken off, of unit variance each."""
    kept = 1.0 - 1.0 / memory

    def noise(size):
        return lfilter([np.sqrt(1.0 - kept**2)], [1.0, -kept], rng.normal(size=size + 200))[200:]

    partner = noise(n + max(lags))
    return [noise(n) - (partner[lag : lag + n] if shared else noise(n)) for lag in lags]


@pytest.mark.slow
@pytest.mark.parametrize("shared", [True, False])
def test_what_one_log_errs_by_is_in_all_from_which_it_was_taken_off(shared):
    """A slope that is alike in three logs: their sum errs by thrice the partner, whose variance is nine times, not
    thrice, its own. And not where each had a partner of its own."""
    rng, lags, n, rate = np.random.default_rng(3), (0, 30, 75), 800, 40.0
    wave = np.sin(2.0 * np.pi * np.arange(n + max(lags)) / 300.0)
    A = np.concatenate([wave[lag : lag + n] for lag in lags])[:, None, None]
    nobody = {"used": np.ones((n, 1), dtype=bool), "sloped": np.zeros(0, dtype=int), "slope": None}
    time, posture, kept = np.arange(n) / rate, np.zeros((n, 1)), np.arange(n)
    errors, stated = [], []
    for _ in range(200):
        left = minus_one_partner(rng, lags, n, shared=shared)
        logs = WearLogs(
            [
                WearLog(f"{k}", "any", time, posture, kept, e[:, None], **nobody, ahead=lag / rate,
                        partner="plain" if shared else f"plain {k}")
                for k, (e, lag) in enumerate(zip(left, lags, strict=True))
            ],
            np.arange(1),
            ["joint"],
        )  # fmt: skip
        e = logs.torque
        errors.append(float(np.einsum("ndp,nd->p", A, e)[0]))
        stated.append(score_covariance(logs, e, A)[0, 0])
    ratio = np.sqrt(np.mean(np.square(errors)) / np.median(stated))
    assert 0.8 < ratio < 1.1


@pytest.mark.slow
def test_errors_that_last_for_seconds_are_too_few_in_one_log_to_say_how_large_they_are():
    """First half of one log against its second, of six alike: a log by itself holds few errors, which are small by
    chance now and then, and then a difference looks sure."""
    rng, n, rate, memory, stated = np.random.default_rng(5), 800, 40.0, 60.0, []
    A = np.zeros((6 * n, 1, 1))
    A[: n // 2], A[n // 2 : n] = 1.0, -1.0
    kept = 1.0 - 1.0 / memory
    nobody = {"used": np.ones((n, 1), dtype=bool), "sloped": np.zeros(0, dtype=int), "slope": None}
    time, posture, places = np.arange(n) / rate, np.zeros((n, 1)), np.arange(n)
    for _ in range(300):
        errors = lfilter([1.0], [1.0, -kept], rng.normal(size=(6, n + 400)), axis=1)[:, 400:]
        made = [WearLog(f"{k}", "any", time, posture, places, e[:, None], **nobody) for k, e in enumerate(errors)]
        logs = WearLogs(made, np.arange(1), ["joint"])
        stated.append(float(np.sqrt(score_covariance(logs, logs.torque, A)[0, 0])))
    assert np.quantile(stated, 0.02) > 0.6 * np.median(stated)
