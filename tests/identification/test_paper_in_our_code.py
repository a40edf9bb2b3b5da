"""[Evaluator] (6)-(20) as the code has them, against formulas written out here and pinocchio's dynamics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.effects.catalogue import choose
from exogauge.effects.effect import JointSignals
from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import prepare
from exogauge.identification.prior import as_printed, per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.turns import rest_detection
from exogauge.robots.description import WrenchSensor
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.regressor import contact_effect, regressor
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.rows import RowType

CUTOFF_HZ = 12.0
JOINTS = 3
PAPER = ("motor_gain", "viscous", "coulomb", "static_friction", "motor_offset")  # the five columns of Z, in (12)


@pytest.fixture
def case(make_truth, make_log):
    """(equations, truth, log prepared): floating, currents logged, joints that stop with different signs."""
    truth = make_truth(True)
    log = make_log(truth, seed=2, seconds=14.0)
    base = find_base_parameters(truth.robot.tree)
    rows = RowBlocks(truth.robot.tree, base, truth.robot.axes_from_joints)
    equations = Equations(truth.robot, rows, base, choose(Settings().effects))
    return equations, truth, prepare(truth.robot, log, CUTOFF_HZ, rest_detection(truth.robot, [log], CUTOFF_HZ))


def parameters(equations, truth, **other):
    xi = np.column_stack([other.get(e.coefficient.name, truth.xi[e.coefficient.name]) for e in equations.effects])
    return np.concatenate([equations.base.regroup @ truth.phi.ravel(), xi.ravel()])


def column_of(equations, name):
    return [effect.name for effect in equations.effects].index(name)


def test_columns_are_z_of_12_as_corrected():
    """[u, -θ̇, -sgn θ̇, -(1 - |sgn θ̇|) sgn r, 1]: friction takes energy out of every motion, and at rest opposes r."""
    rng = np.random.default_rng(0)
    u, velocity, r = rng.normal(size=(3, 60))
    velocity[::3] = 0.0
    s = np.sign(velocity)
    rest = 1.0 - np.abs(s)
    signals = JointSignals(u, velocity, rng.normal(size=60), s, rest, rest * np.sign(r))
    Z = np.stack([u, -velocity, -s, -(1.0 - np.abs(s)) * np.sign(r), np.ones(60)])
    columns = {effect.name: effect.column(signals) for effect in choose(Settings().effects)}
    for name, expected in zip(PAPER, Z, strict=True):
        np.testing.assert_array_equal(columns[name], expected)
    k_d, tau_c, tau_s = 0.7, 1.3, 2.1
    delivered = k_d * columns["viscous"] + tau_c * columns["coulomb"] + tau_s * columns["static_friction"]
    moving = velocity != 0.0
    assert np.all(delivered[moving] * velocity[moving] < 0.0)
    np.testing.assert_allclose(delivered[~moving], -tau_s * np.sign(r[~moving]))
    u_k_T = 4.0 * columns["motor_gain"] + 0.3 * columns["motor_offset"]
    np.testing.assert_allclose(u_k_T, 4.0 * u + 0.3)  # (6)


def test_rest_is_one_minus_the_size_of_the_sign_in_both_directions(case):
    """As (12) prints it, it would be 2 in every backward motion."""
    _, _, prepared = case
    for axis in range(JOINTS):
        way, rest = prepared.raw_direction[:, axis], prepared.rest[:, axis]
        for sign in (-1.0, 1.0):
            far = np.convolve(way == sign, np.ones(41), mode="same") > 40.5  # the same way for 0.1 s to either side
            assert far.sum() > 100
            assert np.abs(rest[far]).max() < 0.05
        still = np.convolve(way == 0.0, np.ones(81), mode="same") > 80.5
        assert still.sum() > 10
        np.testing.assert_allclose(rest[still], 1.0, atol=0.05)


def test_static_friction_takes_the_sign_of_the_same_joints_full_residual(case):
    """(8)-(9) as corrected: while joints rest and the base is shaken, every one gets the sign that it was held by."""
    equations, truth, prepared = case
    x = parameters(equations, truth, tau_s=np.zeros(JOINTS))  # the residual is taken with all but what is sought
    held_by = np.sign(np.sin(np.arange(JOINTS) + 2))  # as `make_log` does, of seed 2
    assert len(set(held_by)) == 2  # another joint's sign would be wrong
    place, seen = column_of(equations, "static_friction"), 0
    for _, chunks in equations.rows(prepared, x):
        for chunk in chunks:
            row = equations.layout.rows[chunk.kind]
            if row.type == RowType.AT_REST:
                column = chunk.block[:, len(equations.columns()[chunk.kind]) - len(equations.effects) + place]
                assert np.all(np.sign(column) == held_by[row.place])  # rows are Y φ - Z ξ
                seen += len(column)
    assert seen > 100


def test_right_hand_side_is_the_transposed_jacobians_times_wrench(make_truth, make_log, case):
    """F_o and F_j of (10), with a sensor at the end of the chain: base, and every joint on the way, feel it."""
    _, truth, _ = case
    robot = replace(truth.robot, sensors=(WrenchSensor("plate", "link3", "contact", 1.0),))
    log = make_log(truth, seed=2, seconds=6.0)
    base = find_base_parameters(robot.tree)
    equations = Equations(robot, RowBlocks(robot.tree, base, robot.axes_from_joints), base, choose(Settings().effects))
    prepared = prepare(robot, log, CUTOFF_HZ, rest_detection(robot, [log], CUTOFF_HZ))
    kept = prepared.kept
    expected = contact_effect(robot.tree, prepared.motion.q[kept], "link3", prepared.wrenches[kept, 0])
    assert np.abs(expected).max(axis=0).min() > 0.1
    for _, chunks in equations.rows(prepared, np.zeros(equations.size)):
        for chunk in chunks:
            row = equations.layout.moving(chunk.kind)
            np.testing.assert_allclose(chunk.block[:, -1], expected[chunk.samples, row], atol=1e-9)


def test_information_is_that_of_18_to_20_from_dense_rows(case):
    """Λ_φ adds base and joint rows, each by its own weight; Λ_T and Λ_d are of motor constants and viscosity alone."""
    equations, truth, prepared = case
    tree, axes = truth.robot.tree, equations.layout.axes
    (statistics,) = equations.collect(prepared, np.zeros(equations.size), 1)  # where k_T is 0 the current stays logged
    weights = np.zeros(len(equations.layout))
    weights[equations.layout.base], weights[axes] = np.linspace(0.1, 1.0, 6), np.linspace(2.0, 5.0, JOINTS)
    G, _, _ = statistics.normal(weights)
    kept, steady = prepared.kept, prepared.steady[prepared.kept]
    Y = regressor(tree, prepared.motion.rows(kept))
    lam_phi = np.einsum("trp,r,trq->pq", Y[:, :6], weights[:6], Y[:, :6])
    for axis in range(JOINTS):
        own = Y[steady[:, axis], 6 + axis]
        lam_phi += weights[6 + axis] * own.T @ own
    B = equations.base_size
    found = equations.base.regroup.T @ G[:B, :B] @ equations.base.regroup
    np.testing.assert_allclose(found, lam_phi, atol=1e-7 * np.abs(lam_phi).max())
    for name, signal in (("motor_gain", prepared.drive[kept]), ("viscous", prepared.axis_velocity[kept])):
        own = [equations.effect_columns(axis)[column_of(equations, name)] for axis in range(JOINTS)]
        lam = np.diag(np.sum(np.where(steady, signal, 0.0) ** 2, axis=0) * weights[axes])
        np.testing.assert_allclose(G[np.ix_(own, own)], lam, rtol=1e-9, atol=1e-9 * lam.max())


def test_prior_of_15_has_one_weight_for_each_of_10_n_and_of_the_joint_parameters(case):
    equations, truth, prepared = case
    belief = per_parameter(truth.robot, equations.base, equations.effects, scales(truth.robot, [prepared]))
    assert belief.std.shape == belief.mean.shape == (10 * len(truth.phi) + JOINTS * len(equations.effects),)
    assert belief.std.min() > 0.0


def test_weights_of_16_and_17_leave_the_estimate_where_it_was_when_all_rows_count_more(case):
    equations, truth, prepared = case
    (statistics,) = equations.collect(prepared, parameters(equations, truth), 1)
    belief = per_parameter(truth.robot, equations.base, equations.effects, scales(truth.robot, [prepared]))
    weights = np.concatenate([np.full(6, 0.1), np.full(JOINTS, 3.0), np.zeros(JOINTS)])

    def estimate(scale):
        printed = as_printed(equations, belief, statistics, scale * weights)
        off = Prior(1.2 * printed.mean, printed.std, printed.seen)
        return PriorLeastSquares(statistics.square_root(scale * weights), off, 1e-3).x

    np.testing.assert_allclose(estimate(100.0), estimate(1.0), rtol=1e-5, atol=1e-7)
