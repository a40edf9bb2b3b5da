"""Beside what is left without a name, a joint's parameters are as doubtful as what they may have taken up of it."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.findings.result import Excess
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.search.final_numbers import with_doubt_of_what_is_left
from exogauge.search.locate import pooled

SETTINGS = Settings(cutoff_hz=8.0)
TRUE = {"k_d[j2]": 0.7, "tau_c[j2]": 1.2, "tau_o[j2]": -0.3}  # of the arm in conftest
DRAWS = 8


def of_all_joints(seed):
    """A smooth torque at the second joint that depends on where all three are: no effect of one joint, or of two. Its
    mean over where they go is none: a constant is an offset, whatever it comes of."""
    rng = np.random.default_rng(seed)
    ways, phases = rng.normal(0.0, 0.6, size=(5, 3)), rng.uniform(0.0, 6.28, 5)
    usual = np.sin(rng.normal(0.0, 0.35, size=(4000, 3)) @ ways.T + phases).mean(axis=0)

    def hidden(motion):
        torque = np.zeros_like(motion.q)
        torque[:, 1] = np.sum(np.sin(motion.q @ ways.T + phases) - usual, axis=1)
        return torque

    return hidden


@pytest.fixture(scope="module")
def drawn(robot, record):
    """Of each draw: identified, what is left of the second joint on a log that was not fitted, and the fitted logs."""
    found = []
    for draw in range(DRAWS):
        logs = [(record(10 * draw + k, of_all_joints(draw), seconds=15.0), k == 2) for k in range(3)]
        one = identify(robot, [Recording(log, held_out) for log, held_out in logs], SETTINGS)
        rmse, floor = pooled([fit for fit in one.validation if fit.held_out and fit.channel == "tau.j2"])
        fitted = [log for log, held_out in logs if not held_out]
        found.append((one, Excess("tau.j2", "N·m", rmse, floor, 10.0), fitted))
    return found


def off(found, names):
    known = {each.name: each for each in found.parameters}
    return np.array([(known[name].value - TRUE[name]) / known[name].std for name in names])


@pytest.mark.slow
def test_a_joints_numbers_hold_beside_what_has_no_name(drawn):
    assert all(left.rmse > 2.0 * left.noise_floor for _, left, _ in drawn)
    before = np.array([off(one, TRUE) for one, _, _ in drawn])
    after = np.array([off(with_doubt_of_what_is_left(one, [left]), TRUE) for one, left, _ in drawn])
    assert np.mean(np.abs(before) < 1.96) < 0.8, "blocks of the residuals alone do not show it"
    assert np.mean(np.abs(after) < 1.96) >= 0.9
    assert 0.5 < np.sqrt(np.mean(after**2)) < 1.3, "nor is it wider than what is met"


def test_the_doubt_is_that_of_the_columns_as_they_stand_in_the_rows(drawn):
    """By the rows themselves, without sums: what a torque of this size along each own direction moves."""
    one, left, logs = drawn[0]
    model = one.model
    grown = with_doubt_of_what_is_left(one, [left]).model.covariance - model.covariance
    kind, weight = model.equations.layout.axis(1), model.solution.weights[model.equations.layout.axis(1)]
    parts = [chunk.block[:, :-1].copy() for log in logs
             for _, chunks in model.equations.rows(model.prepare(log), model.solution.x_before) for chunk in chunks
             if chunk.kind == kind]  # fmt: skip
    A = np.zeros((sum(map(len, parts)), model.equations.size))
    A[:, model.equations.columns()[kind]] = np.concatenate(parts)
    own = A[:, model.equations.effect_columns(1)]
    U, sizes, _ = np.linalg.svd(own / np.maximum(np.linalg.norm(own, axis=0), 1e-12), full_matrices=False)
    U = U[:, sizes > 1e-6 * sizes[0]]
    moved = model.solution.unbounded.divided(weight * A.T @ U)
    fits = [fit for fit in one.validation if not fit.held_out and fit.channel == left.channel]
    square = np.mean([fit.rmse_moving**2 for fit in fits]) - np.mean([fit.noise_floor**2 for fit in fits])
    np.testing.assert_allclose(grown, moved @ moved.T * square * len(A) / U.shape[1], rtol=1e-6, atol=1e-12)


def test_other_joints_are_not_in_doubt(drawn):
    one, left, _ = drawn[0]
    before, after = (
        {each.name: each.std for each in found.parameters} for found in (one, with_doubt_of_what_is_left(one, [left]))
    )
    assert after["tau_c[j2]"] > 2.0 * before["tau_c[j2]"]
    assert after["tau_c[j3]"] == pytest.approx(before["tau_c[j3]"], rel=0.2)
    assert with_doubt_of_what_is_left(one, []) is one


def test_a_parameters_budget_says_how_much_of_its_doubt_it_is(drawn):
    one, left, _ = drawn[0]
    found = {each.name: each for each in with_doubt_of_what_is_left(one, [left]).parameters}
    was, told = {each.name: each for each in one.parameters}, found["tau_c[j2]"]
    assert told.parts["robot"] == was["tau_c[j2]"].std
    assert told.std == pytest.approx(np.hypot(told.parts["robot"], told.parts["unexplained"]))
    assert told.parts["unexplained"] > 10.0 * found["tau_c[j3]"].parts["unexplained"]
