"""Currents alone leave one factor open: it comes from what was stated, unbiased, with a doubt that holds."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.errors import BadLog
from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.statistics import Statistics
from exogauge.identification.gain_scale import _decided_by, most_likely
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings

SETTINGS = Settings(cutoff_hz=10.0, prior_strength=1.0, consistency="free")
STUDIES = 12


def stated(truth, rng, doubt):
    """The robot as its maker states it: k_T and every body off by what he doubts of them, drawn."""
    joints = tuple(
        replace(joint, prior={"k_T": k * (1.0 + doubt * rng.normal())}, prior_std={"k_T": doubt * k})
        for joint, k in zip(truth.robot.joints, truth.xi["k_T"], strict=True)
    )
    return replace(truth.robot, joints=joints)


@pytest.fixture(scope="module")
def studies():
    """doubt -> what was found in every study, made once."""
    return {}


@pytest.fixture
def found(studies, make_truth, make_log):
    def of(doubt):
        if doubt not in studies:
            results = []
            for seed in range(STUDIES):
                truth = make_truth(False, seed=seed)
                robot = stated(truth, np.random.default_rng([seed, 5]), doubt)
                logs = [make_log(truth, seed=10 * seed + k, seconds=12.0, noise=1.0) for k in range(2)]
                results.append(
                    (truth, identify(robot, [Recording(logs[0], False), Recording(logs[1], True)], SETTINGS))
                )
            studies[doubt] = results
        return studies[doubt]

    return of


def gains(truth, identification):
    """(J,) k_T over its truth, and the std of that."""
    named = {each.name: each for each in identification.parameters}
    pairs = [(named[f"k_T[{joint.name}]"], k) for joint, k in zip(truth.robot.joints, truth.xi["k_T"], strict=True)]
    return np.array([p.value / k for p, k in pairs]), np.array([p.std / k for p, k in pairs])


@pytest.mark.slow
@pytest.mark.parametrize("doubt", [0.1, 0.4])
def test_the_factor_is_not_biased_and_its_doubt_holds(found, doubt):
    ratios, stds = np.array([gains(*each) for each in found(doubt)]).transpose(1, 0, 2)
    common, spread = ratios.mean(axis=1), stds.mean()
    assert abs(common.mean() - 1.0) < 3.0 * spread / np.sqrt(STUDIES)
    z = (ratios - 1.0) / stds
    assert np.mean(np.abs(z) < 2.0) > 0.85
    assert np.sqrt(np.mean(z**2)) > 0.4  # and is no larger than it has to be


def test_themost_likely_point_alone_would_be_too_small(found):
    """What least squares with the prior gives where the term is left out: the bias that it takes off."""
    results, lower = found(0.4), []
    for _truth, each in results:
        solution = each.model.solution
        plain = PriorLeastSquares(solution.statistics.square_root(solution.weights), solution.prior, solution.strength)
        columns = solution.gains.columns
        lower.append(plain.x[columns] / solution.unbounded.x[columns])
    assert np.mean(lower) < 0.95


def test_errors_in_currents_do_not_depend_on_the_stated_doubt(make_truth, make_log):
    truth = make_truth(False, seed=3)
    logs = [make_log(truth, seed=k, seconds=12.0, noise=1.0) for k in (1, 2)]
    errors = []
    for doubt in (0.02, 0.2, 0.5):
        joints = tuple(
            replace(joint, prior={"k_T": k}, prior_std={"k_T": doubt * k})
            for joint, k in zip(truth.robot.joints, truth.xi["k_T"], strict=True)
        )
        robot = replace(truth.robot, joints=joints)
        one = identify(robot, [Recording(logs[0], False), Recording(logs[1], True)], SETTINGS).by_stated_constants()
        errors.append([each.rmse_identified for each in one.validation if each.held_out])
    np.testing.assert_allclose(errors[1:], [errors[0]] * 2, rtol=0.05)


def test_a_current_of_the_wrong_sign_is_an_error_that_names_the_joint_where_forces_are_measured(make_truth, make_log):
    truth = make_truth(True)
    logs = [make_log(truth, seed=k, seconds=12.0) for k in (1, 2)]
    flipped = [replace(log, channels=log.channels | {"i.j2": -log.channels["i.j2"]}) for log in logs]
    with pytest.raises(BadLog) as caught:
        identify(truth.robot, [Recording(flipped[0], False), Recording(flipped[1], True)], Settings())
    assert {fault.rule for fault in caught.value.faults} == {"torque_constant_impossible"}
    assert [fault.column for fault in caught.value.faults] == ["i.j2"]


def test_measured_forces_leave_next_to_nothing_to_the_term(make_truth, make_log):
    truth = make_truth(True)
    logs = [make_log(truth, seed=k, seconds=12.0, noise=1.0) for k in (1, 2)]
    found = identify(truth.robot, [Recording(logs[0], False), Recording(logs[1], True)], SETTINGS)
    solution = found.model.solution
    plain = PriorLeastSquares(solution.statistics.square_root(solution.weights), solution.prior, solution.strength)
    columns = solution.gains.columns
    moved = (solution.unbounded.x - plain.x)[columns]
    std = np.array([p.std for p in found.parameters if p.name.startswith("k_T")])
    assert np.all(np.abs(moved) < 0.3 * std)
    assert not found.per_stated


def test_the_newton_steps_end_where_the_slope_is_zero():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(4, 4))
    information, k_hat, D = root @ root.T + np.eye(4), np.array([1.0, 0.2, -0.5, 2.0]), np.array([3.0, 1.0, 5.0, 0.1])
    k = most_likely(k_hat, information, D, np.ones(4))
    assert np.all(k > 0.0)
    np.testing.assert_allclose(information @ (k - k_hat), D / k, rtol=1e-6)


def test_what_the_rows_of_one_joint_decide_is_the_trace_of_their_share_in_all_that_is_known() -> None:
    random = np.random.default_rng(4)
    of_kind = [np.array([5, 0, 1]), np.array([1, 2, 3, 6]), np.array([4, 6])]
    statistics = Statistics.empty(7, of_kind)
    rows = [random.normal(size=(30, len(own))) for own in of_kind]
    for kind, A in enumerate(rows):
        statistics.add_rows(kind, np.hstack([A, random.normal(size=(30, 1))]))
    weights, columns = np.array([2.0, 0.5, 3.0]), np.array([0, 1, 2, 4, 5, 6])
    dense = [np.zeros((30, 7)) for _ in of_kind]
    for whole, A, own in zip(dense, rows, of_kind, strict=True):
        whole[:, own] = A
    alone = [w * (A.T @ A)[np.ix_(columns, columns)] for w, A in zip(weights, dense, strict=True)]
    H, counted = sum(alone) + np.eye(6), np.array([True, True, False, True, True, True])
    expected = [np.diag(np.linalg.inv(H) @ each)[counted].sum() for each in alone[:2]]
    assert _decided_by(statistics, weights, [0, 1], columns, H, counted) == pytest.approx(expected, rel=1e-12)
