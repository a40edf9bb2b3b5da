"""What is declared, and how bands sit, on the device: what counts again, what averages out, what moves the bands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.support.declared.conftest import DECLARED, EVERY, FORCES, changed

from exogauge.criteria.identifying import DECLARED as DEFAULT_DOUBTS
from exogauge.devices.routing import Routing
from exogauge.support.balance import balance
from exogauge.support.band_doubt import contributions
from exogauge.support.band_fit import best_start, fit_device, starts
from exogauge.support.band_inputs import nuisance_torques
from exogauge.support.band_model import Belief, Setting, fit, shared
from exogauge.support.band_rows import WearLogs, band_wires, stretches, taut
from exogauge.support.inputs import Doubts, Inputs, sloped_samples, variance_of_mean
from exogauge.support.repeatability import Plain, repeatability
from exogauge.support.rows_of_approach import rows_with
from exogauge.support.same_motion import Posture
from exogauge.support.settings import SupportSettings

NAMES = ["torso_pitch", "torso_yaw"]


def problem(biped, bands, evidences):
    columns = np.array([biped.robot.tree.joints.index(name) for name in NAMES])
    logs = rows_with(evidences, "B", columns, NAMES, biped.known().cutoff_hz)
    wires = band_wires(logs, Routing(biped.robot.tree, bands))
    setting = Setting(logs, wires, logs.used / 0.09, float(logs.used.sum()), Belief(np.zeros(3), np.zeros((3, 3))))
    return setting, fit(setting, best_start(setting, starts(shared(bands), wires, ())))


def in_nothing(model, logs, doubts=None):
    """What is found on two runs of one motion without a device. doubts: what is known of it, where that is asked."""
    names = [joint.name for joint in model.robot.joints]
    runs = [Plain(balance(model, model.prepare(log), EVERY), Posture(log, names), "wander") for log in logs]
    return repeatability(runs, np.ones(len(EVERY)), SupportSettings(), doubts)


@pytest.mark.slow
@pytest.mark.parametrize(("taken", "p"), [(None, DEFAULT_DOUBTS.partner_alike), ("log", 0.0)])
def test_what_is_declared_does_not_count_again_where_logs_without_the_device_show_it(biped, wander, taken, p):
    """Zeros of both feet drawn as declared, alike in two runs as partners' are, or not at all where they were taken
    anew before each log: means in steady motion scatter as much as is taken off them, and samples too."""
    nothing_else = replace(
        DECLARED, ft_gain=0.0, ft_gain_common=0.0, kt_drift=0.0, viscous_drift=0.0, coulomb_drift=0.0
    )
    stated = replace(nothing_else, zeros_taken=taken)
    model = replace(biped, robot=replace(biped.robot, declared=stated)).known()
    rng, draws = np.random.default_rng(0), 40
    clean = [biped.record(wander(1, base_seed=k), f"run{k}").log for k in range(2)]
    names = [f"ft.{sensor.name}.{each}" for sensor in biped.robot.contacts for each in FORCES]
    size = np.tile(np.repeat([DECLARED.ft_zero_force, DECLARED.ft_zero_moment], 3), len(biped.robot.contacts))
    scattered, left = {"a": [], "b": [], "paired": []}, {"a": [], "b": [], "paired": []}
    samples = {True: [], False: []}
    for _ in range(draws):
        zeros = (np.sqrt(p) * rng.normal(size=len(names)) + np.sqrt(1.0 - p) * rng.normal(size=(2, len(names)))) * size
        runs = [
            changed(log, {name: log.channels[name] + zero for name, zero in zip(names, each, strict=True)})
            for log, each in zip(clean, zeros, strict=True)
        ]
        for squares, doubts in ((scattered, None), (left, Doubts(model, EVERY))):
            for approach, found in in_nothing(model, runs, doubts).by_approach.items():
                squares[approach].append(found.mean**2)
                samples[doubts is None].append((found.steady if doubts is None else found.beyond["steady"]) ** 2)
    legs = biped.places(*(f"{side}_{joint}" for side in "lr" for joint in ("hip", "knee")))
    for approach, squares in scattered.items():
        of_legs = np.mean(squares, axis=0)[legs]
        share = np.mean(left[approach], axis=0)[legs] / of_legs
        assert of_legs.min() > 0.01
        # of a normal number's square .22 lie beyond its own variance where it is more than two standard deviations
        assert share.max() < 0.45
    own = balance(model, model.prepare(clean[0]), EVERY)
    sloped = sloped_samples(own.prepared)
    doubts = Doubts(model, EVERY)
    taken_off = doubts.of_means(doubts.inputs(own.prepared, sloped), sloped, own.steady & ~own.left_out[:, None])[legs]
    there = np.mean(scattered["b"], axis=0)[legs]
    assert np.all((0.6 * taken_off < there) & (there < 1.6 * taken_off))  # nor is more taken off than there is
    of_samples, beyond = (np.mean(samples[bare], axis=0)[legs] for bare in (True, False))
    assert np.all(beyond < 0.45 * of_samples)


@pytest.mark.slow
def test_what_nobody_declared_stays_where_logs_without_the_device_show_it(biped, model, wander):
    """Friction that the model does not know, one way only, at the left knee."""
    knee = biped.places("l_knee")[0]
    unknown = 5.0 * np.eye(len(EVERY))[knee]
    runs = [
        biped.record(wander(1, base_seed=k), f"run{k}", extra=lambda speed: np.zeros_like(speed) + unknown).log
        for k in range(2)
    ]
    for doubts in (None, Doubts(model, EVERY)):
        assert in_nothing(model, runs, doubts).b.mean[knee] == pytest.approx(5.0, rel=0.05)


@pytest.fixture(scope="module")
def worn(suit, make_evidence, wander):
    return [make_evidence(suit, wander(seed), 0.3, seed=seed) for seed in (1, 2)]


@pytest.mark.parametrize("anew", [False, True])
def test_what_drifts_through_a_session_hardly_averages_out_over_its_logs(biped, suit, worn, anew):
    """One motion in one log, and twice: errors of each log alone are half of the variance, those alike all."""
    drift = np.zeros((len(worn[0].sloped), len(NAMES), 1), dtype=np.float32)
    drift[:, 0, 0] = np.sin(np.linspace(0.0, 9.0, len(drift)))
    inputs = replace(worn[0].inputs_b, own={"ft_zero": drift}, anew=frozenset({"ft_zero"} if anew else ()))
    drifting = replace(worn[0], inputs_b=inputs)
    one, two = (contributions(*problem(biped, suit.bands, [drifting] * times), {})["ft_zero"] for times in (1, 2))
    share = 0.5 if anew else DEFAULT_DOUBTS.alike + 0.5 * (1.0 - DEFAULT_DOUBTS.alike)
    np.testing.assert_allclose(two, share * one, rtol=1e-5, atol=1e-9 * np.abs(one).max())


@pytest.mark.parametrize("anew", [False, True])
def test_of_what_is_anew_in_each_log_means_over_logs_average_out_more(biped, model, anew):
    inputs = Inputs(
        np.zeros((4, model.equations.size + len(model.inputs.names)), dtype=np.float32),
        own={"ft_zero": np.full((4, 2), 1.5, dtype=np.float32)},
        anew=frozenset({"ft_zero"} if anew else ()),
    )
    found = variance_of_mean(model, [(inputs, np.full(4, 0.25))] * 3)["ft_zero"]
    alike = 0.0 if anew else DEFAULT_DOUBTS.alike
    assert found == pytest.approx(2 * 1.5**2 * (alike + (1.0 - alike) / 3.0), rel=1e-6)


def drawn_bands(bands, rng, std):
    """With via points drawn about where they are described."""
    return tuple(
        replace(band, via_points=tuple(
            replace(point, xyz=tuple(np.array(point.xyz) + std * rng.normal(size=3))) for point in band.via_points
        ))
        for band in bands
    )  # fmt: skip


def test_what_is_fitted_beside_the_bands_moves_the_torque_as_via_points_and_lengths_do(biped, suit, worn):
    """Via points drawn as declared, and bands as long as they were put on: RMS over draws of what that adds to the
    torque beside what each band's own natural length would, against the same of the columns."""
    bands = tuple(replace(band, point_std=0.002, donning_std=0.001) for band in suit.bands)
    setting, fitted = problem(biped, bands, worn)
    added, rng, squares = nuisance_torques(setting, fitted), np.random.default_rng(0), []
    k, l_0 = zip(*(fitted.wear.spring(b) for b in range(2)), strict=True)
    pulling = taut(setting.wires, l_0)
    of_lengths = [wire.jacobian * (k[b] * pulling[:, [b]]) for b, wire in enumerate(setting.wires)]

    def torques(moved):
        wires = band_wires(setting.logs, Routing(biped.robot.tree, moved))
        pulls = np.array(k) * stretches(wires, np.array(l_0))
        return [wire.jacobian * pulls[:, [b]] for b, wire in enumerate(wires)]

    def beside(change, own):
        return change - own * np.sum(setting.weight * own * change) / np.sum(setting.weight * own**2)

    as_described, small = torques(bands), 0.05  # when a band comes taut is not looked at here
    for _ in range(60):
        moved, longer = torques(drawn_bands(bands, rng, 0.002 * small)), 0.001 * rng.normal(size=(2, len(worn)))
        one = [own * longer[b, setting.logs.log][:, None] for b, own in enumerate(of_lengths)]
        changes = [(own - was) / small + put_on for own, was, put_on in zip(moved, as_described, one, strict=True)]
        squares.append(sum(beside(*each) for each in zip(changes, of_lengths, strict=True)) ** 2)
    used = setting.logs.used
    drawn, found = (
        np.sqrt(np.mean(np.where(used, each, 0.0), axis=0))
        for each in (np.mean(squares, axis=0), np.sum(added.times(np.eye(added.values.shape[2])) ** 2, axis=2))
    )
    np.testing.assert_allclose(found, drawn, rtol=0.2)


@pytest.mark.slow
def test_springs_of_bands_that_sit_otherwise_than_described_are_found_better_and_doubted_as_much(biped, suit, worn):
    """With little noise: what a fit that knows of no doubt errs by is where the via points are."""
    rng, std, noise = np.random.default_rng(3), 0.005, 0.05
    nothing, sigma = np.zeros((biped.known().equations.size,) * 2), np.full(len(NAMES), noise)
    beside, only = (tuple(replace(band, point_std=each, donning_std=0.0) for band in suit.bands) for each in (std, 0.0))
    setting, _ = problem(biped, beside, worn)
    true = [band.stiffness for band in suit.bands]
    errors, deviations = [], []
    for _ in range(16):
        wires = band_wires(setting.logs, Routing(biped.robot.tree, drawn_bands(beside, rng, std)))
        pulls = np.array(true) * stretches(wires, np.array([band.natural_length for band in suit.bands]))
        torque = -sum(wire.jacobian * pulls[:, [b]] for b, wire in enumerate(wires))
        torque = torque + noise * rng.normal(size=torque.shape)
        spans = setting.logs.spans
        parts = [replace(each, torque=torque[span]) for each, span in zip(setting.logs.logs, spans, strict=True)]
        logs = WearLogs(parts, setting.logs.joints, setting.logs.names)
        found = []
        for bands in (beside, only):
            described = band_wires(logs, Routing(biped.robot.tree, bands))
            seen, _ = fit_device(replace(suit, bands=bands), logs, described, None, nothing, sigma)
            found.append(seen)
        errors.append([seen.fitted.wear.springs[0] - true[0] for seen in found])
        deviations.append(errors[-1][0] / np.sqrt(found[0].covariance(found[0].fitted)[0, 0]))
    better, worse = np.sqrt(np.mean(np.square(errors), axis=0))
    assert better < 0.9 * worse
    assert 0.6 < np.sqrt(np.mean(np.square(deviations))) < 1.4


@pytest.mark.slow
def test_via_points_and_donning_move_the_bands_as_far_as_they_do_when_they_are_moved(biped, suit, worn):
    bands = tuple(replace(band, point_std=0.002, donning_std=0.001) for band in suit.bands)
    setting, fitted = problem(biped, bands, worn)
    found = contributions(setting, fitted, {})
    square = np.zeros(3)
    for b, band in enumerate(bands):
        for p, point in enumerate(band.via_points):
            for axis in range(3):
                xyz = tuple(x + 0.002 * (axis == k) for k, x in enumerate(point.xyz))
                points = (*band.via_points[:p], replace(point, xyz=xyz), *band.via_points[p + 1 :])
                moved = tuple(replace(band, via_points=points) if k == b else one for k, one in enumerate(bands))
                square += (problem(biped, moved, worn)[1].wear.theta - fitted.wear.theta) ** 2
    np.testing.assert_allclose(np.sqrt(np.diag(found["via_points"])), np.sqrt(square), rtol=0.15)
    square, step = np.zeros(3), 1e-5  # more, and samples enter or leave the stretch
    for b in range(2):
        k, l_0 = fitted.wear.spring(b)
        longer = np.subtract(*stretches([setting.wires[b]] * 2, np.array([l_0 - step, l_0])).T)
        for log in range(2):
            in_one = np.where(setting.logs.log == log, k * longer, 0.0)
            pulled = setting.logs.torque.copy()
            setting.logs.torque -= setting.wires[b].jacobian * in_one[:, None]
            square += ((fit(setting, fitted.wear).wear.theta - fitted.wear.theta) * (0.001 / step)) ** 2
            setting.logs.torque = pulled
    np.testing.assert_allclose(np.sqrt(np.diag(found["donning"])), np.sqrt(square), rtol=0.15)
