"""What is believed beforehand, by formulas of its own: (16)-(17) from dense rows, spreads from drawn bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from tests.sensor_arm import JOINTS, describe, record, wrist

from exogauge.effects.catalogue import choose
from exogauge.identification.added_columns import zero_columns
from exogauge.identification.equations import Equations
from exogauge.identification.identify import identify
from exogauge.identification.preparation import prepare
from exogauge.identification.prior import as_printed, inertial_std, per_parameter, scales
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.turns import rest_detection
from exogauge.robots.cuts import CutRows
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.regressor import regressor
from exogauge.robots.row_blocks import RowBlocks

CUTOFF_HZ = 8.0


@pytest.fixture(scope="module")
def with_wrist(tmp_path_factory):
    """(equations, prepared log, belief by size, statistics) of an arm that has a sensor at its wrist."""
    sensor = wrist()
    robot, log = describe(tmp_path_factory.mktemp("arm"), [sensor]), record(3, [sensor], 12.0)
    base = find_base_parameters(robot.tree)
    rows = RowBlocks(robot.tree, base, robot.axes_from_joints)
    cuts = [CutRows(robot.tree, base, each.frame) for each in robot.cuts]
    equations = Equations(robot, rows, base, choose(Settings().effects), tuple(zero_columns(robot)), cuts)
    prepared = prepare(robot, log, CUTOFF_HZ, rest_detection(robot, [log], CUTOFF_HZ))
    added = np.full(len(equations.added), 10.0)
    belief = per_parameter(robot, base, equations.effects, scales(robot, [prepared]), added)
    (statistics,) = equations.collect(prepared, np.zeros(equations.size), 1)
    return equations, prepared, belief, statistics


@pytest.fixture(params=[1.0, 1e4])
def weights(request):
    """(kinds,) one per row kind; the sensor's rows count less, or far more than the joints'. None at rest."""
    axes = len(JOINTS)
    return np.concatenate([[3.0, 5.0, 2.0, 4.0], np.zeros(axes), np.full(6, request.param)])


def test_weights_of_friction_and_offset_are_those_of_17_whatever_a_sensor_inside_says(with_wrist, weights):
    """N_T σ_max(W_j): of the joints' rows. A sensor of 0.01 N·m says nothing of Coulomb friction."""
    equations, prepared, belief, statistics = with_wrist
    found = as_printed(equations, belief, statistics, weights)
    names = [effect.coefficient.name for effect in equations.effects]
    first = equations.robot.tree.phi.size
    std = found.std[first : first + len(JOINTS) * len(names)].reshape(len(JOINTS), -1)
    N_T = max(int(prepared.steady[prepared.kept, axis].sum()) for axis in range(len(JOINTS)))
    for name in ("tau_c", "tau_s", "tau_o"):
        np.testing.assert_allclose(std[:, names.index(name)], (N_T * 5.0) ** -0.5, rtol=1e-9)
    W_j = weights[: len(JOINTS)]
    moving = [prepared.kept[prepared.steady[prepared.kept, axis]] for axis in range(len(JOINTS))]
    for name, seen in (("k_d", prepared.axis_velocity), ("J_r", prepared.axis_acceleration)):
        lam = np.diag([w * np.sum(seen[own, j] ** 2) for j, (own, w) in enumerate(zip(moving, W_j, strict=True))])
        np.testing.assert_allclose(std[:, names.index(name)], np.linalg.norm(lam, 2) ** -0.5, rtol=1e-9)
    assert not std[:, names.index("k_T")].any()  # torques are logged


def test_weight_of_the_bodies_is_that_of_16(with_wrist, weights):
    """Λ_φ in the 10 N standard parameters, from the dense regressor; the sensor's rows by their own blocks."""
    equations, prepared, belief, statistics = with_wrist
    tree = equations.robot.tree
    found = as_printed(equations, belief, statistics, weights)
    Y = regressor(tree, prepared.motion.rows(prepared.kept))
    lam = np.zeros((tree.phi.size, tree.phi.size))
    for axis in range(len(JOINTS)):
        own = Y[prepared.steady[prepared.kept, axis], axis]
        lam += weights[axis] * own.T @ own
    for cut in equations.cuts:
        for row, block in enumerate(cut.fill(prepared.motion.rows(prepared.kept))):
            own = block[:, : len(cut.columns[row])] @ equations.base.regroup[cut.columns[row]]
            lam += weights[equations.layout.sensor(0)[row]] * own.T @ own
    np.testing.assert_allclose(found.std[: tree.phi.size], np.linalg.norm(lam, 2) ** -0.5, rtol=1e-6)
    np.testing.assert_array_equal(found.mean, belief.mean)


def test_inertial_spreads_are_those_of_bodies_drawn_within_what_is_stated(make_truth):
    """Mass, centre of mass and lengths are each wrong by a share of their size; nothing of the code's formula is used.

    The claims are of a whole group (first moments, moments, products), so they are held against the group's largest.
    """
    rng, stated, draws = np.random.default_rng(0), 0.1, 4000
    robot = replace(make_truth(False, joints=3).robot, inertial_std={"": stated})
    claimed = inertial_std(robot)
    for phi, claim in zip(robot.tree.phi, claimed, strict=True):
        body = pin.Inertia.FromDynamicParameters(phi)
        g = np.sqrt(np.trace(body.inertia) / (2.0 * body.mass))
        drawn = []
        for e_m, e_l, *e_c in rng.normal(size=(draws, 5)):
            own = body.inertia / body.mass * (1.0 + stated * e_l) ** 2
            m, c = body.mass * (1.0 + stated * e_m), body.lever + stated * g * np.array(e_c)
            drawn.append(pin.Inertia(m, c, m * own).toDynamicParameters())
        seen = np.std(drawn, axis=0)
        assert claim[0] == pytest.approx(seen[0], rel=0.05)
        assert claim[1] == pytest.approx(np.max(seen[1:4]), rel=0.3)
        assert 1.0 < claim[4] / np.max(seen[[4, 6, 9]]) < 2.0  # on the safe side, by less than twice
        assert 1.0 < claim[5] / np.max(seen[[5, 7, 8]]) < 4.0


def test_where_the_maker_states_no_doubt_a_quarter_is_believed(make_truth):
    robot = make_truth(False, joints=2).robot
    np.testing.assert_allclose(inertial_std(robot)[:, 0], 0.25 * robot.tree.phi[:, 0])


def test_what_was_believed_of_a_combination_is_the_spread_of_its_parts_drawn(make_truth, make_log):
    truth = make_truth(False, joints=2, actuation="torque")
    found = identify(truth.robot, [Recording(make_log(truth, 1, seconds=8.0), False)], Settings(cutoff_hz=8.0))
    draws, rng = 4000, np.random.default_rng(0)
    parts = {p.name: p.prior + p.prior_std * rng.normal(size=draws) for p in found.parameters if not p.combination}
    combined = [p for p in found.parameters if p.combination]
    assert max(len(p.combination) for p in combined) >= 4
    for each in combined:
        drawn = sum(factor * parts[name] for name, factor in each.combination.items())
        assert each.prior_std == pytest.approx(np.std(drawn), rel=0.06)
        assert each.prior == pytest.approx(np.mean(drawn), abs=0.06 * each.prior_std)
        assert each.identifiable == (each.std <= 0.5 * each.prior_std)
