"""What a log says as rows: true at the truth, whatever the chunks, the axes and the noise of the currents."""

from dataclasses import replace

import numpy as np
import pytest

import exogauge.identification.equations as module
from exogauge.effects.catalogue import choose
from exogauge.identification.equations import Equations
from exogauge.identification.predict import Parameters, predictions
from exogauge.identification.preparation import View, prepare
from exogauge.identification.prior import per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.static_friction import fill_static_friction
from exogauge.identification.turns import rest_detection
from exogauge.robots.description import WrenchSensor
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.regressor import contact_effect, regressor
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.rows import RowType

CUTOFF_HZ = 12.0
DIFFERENTIAL = np.array([[1.0, 0.0, 0.0], [0.0, 0.9, 0.4], [0.0, -0.5, 1.1]])


def equations_of(robot):
    base = find_base_parameters(robot.tree)
    return Equations(robot, RowBlocks(robot.tree, base, robot.axes_from_joints), base, choose(Settings().effects))


def prepared_of(robot, log):
    return prepare(robot, log, CUTOFF_HZ, rest_detection(robot, [log], CUTOFF_HZ))


def true_parameters(equations, truth):
    xi = np.column_stack([truth.xi[effect.coefficient.name] for effect in equations.effects])
    return np.concatenate([equations.base.regroup @ truth.phi.ravel(), xi.ravel()])


def rows_of(equations, prepared, x):
    """Kind -> (samples, [A | y]) over the whole log."""
    found = {}
    for _, chunks in equations.rows(prepared, x):
        for chunk in chunks:
            samples, blocks = found.setdefault(chunk.kind, ([], []))
            samples.append(chunk.samples)
            blocks.append(chunk.block.copy())
    return {kind: (np.concatenate(samples), np.vstack(blocks)) for kind, (samples, blocks) in found.items()}


def without_gain(equations, x):
    """x with k_T = 0, at which the logged current stays where it is."""
    x = x.copy()
    for axis in range(len(equations.robot.joints)):
        x[equations.effect_columns(axis)[0]] = 0.0
    return x


def static_friction_columns(equations):
    place = [effect.name for effect in equations.effects].index("static_friction")
    return [equations.effect_columns(axis)[place] for axis in range(len(equations.robot.joints))]


@pytest.fixture(params=["floating", "fixed", "coupled"])
def case(request, make_truth, make_log):
    """(equations, truth, noise-free log prepared)"""
    coupling = DIFFERENTIAL if request.param == "coupled" else None
    truth = make_truth(request.param != "fixed", actuation="current", coupling=coupling)
    return equations_of(truth.robot), truth, prepared_of(truth.robot, make_log(truth, seed=1, seconds=14.0))


def test_the_true_parameters_solve_the_rows_of_a_log_without_noise(case):
    equations, truth, prepared = case
    x = true_parameters(equations, truth)
    rows = rows_of(equations, prepared, without_gain(equations, x))
    steady = equations.layout.numbers(RowType.BASE, RowType.AXIS)
    assert set(steady) <= set(rows)
    for kind, (_, block) in rows.items():
        if kind in steady:
            terms = block[:, :-1] * x[equations.columns()[kind]]
            left = block[:, -1] - terms.sum(axis=1)
            size = np.sqrt(np.mean(np.sum(terms**2, axis=1) + block[:, -1] ** 2))
            assert np.sqrt(np.mean(left**2)) < 2e-3 * size
            assert np.abs(left).max() < 2e-2 * size


def test_no_row_comes_from_the_moments_around_starts_stops_and_turns(case):
    equations, truth, prepared = case
    rows, layout = rows_of(equations, prepared, true_parameters(equations, truth)), equations.layout
    around = np.arange(-8, 9)  # half a period of the cut-off to either side
    for axis in range(3):
        steady, resting = rows[layout.axis(axis)][0], rows[layout.resting(axis)][0]
        assert len(steady) > 100
        assert len(resting) > 10
        assert not set(steady) & set(resting)
        assert len(steady) + len(resting) < len(prepared.kept)
        seen = prepared.raw_direction[prepared.kept[steady][:, None] + around, axis]
        assert np.all(np.abs(seen.sum(axis=1)) == len(around))  # one direction all the time
        assert np.all(prepared.raw_direction[prepared.kept[resting], axis] == 0.0)


def test_the_current_that_the_model_calls_for_leaves_every_residual_where_it_is(case):
    equations, truth, prepared = case
    x = true_parameters(equations, truth) * np.random.default_rng(0).uniform(0.8, 1.2, equations.size)
    logged, called_for = (rows_of(equations, prepared, at) for at in (without_gain(equations, x), x))
    for kind in equations.layout.numbers(RowType.BASE, RowType.AXIS):
        own = x[equations.columns()[kind]]
        left, right = (block[:, -1] - block[:, :-1] @ own for block in (logged[kind][1], called_for[kind][1]))
        np.testing.assert_allclose(left, right, atol=1e-10)
        if equations.layout.rows[kind].type == RowType.AXIS:
            assert np.abs(logged[kind][1] - called_for[kind][1]).max() > 1e-3


def test_what_effects_see_of_a_log_is_gathered_once_for_its_predictions(case, monkeypatch):
    equations, truth, prepared = case
    xi = np.column_stack([truth.xi[effect.coefficient.name] for effect in equations.effects])
    gathered, signals = [], View.signals
    monkeypatch.setattr(View, "signals", lambda view, *of: gathered.append(view) or signals(view, *of))
    predictions(equations, prepared, [Parameters(truth.phi, xi), Parameters(truth.phi, 0.9 * xi)])
    assert len(gathered) == 1


def test_what_is_asked_beyond_outside_forces_is_what_the_rows_leave(case):
    """One forward model: predictions and supporting torque take it from the blocks that the fit takes."""
    equations, truth, prepared = case
    x = true_parameters(equations, truth) * np.random.default_rng(0).uniform(0.8, 1.2, equations.size)
    (asked,) = equations.asked(prepared, prepared.low_passed.signals(), prepared.added, x[:, None])
    asked = (asked.T - equations.outside(prepared))[prepared.kept]
    for kind in equations.layout.numbers(RowType.BASE, RowType.AXIS):
        samples, block = rows_of(equations, prepared, x)[kind]
        left = block[:, -1] - block[:, :-1] @ x[equations.columns()[kind]]
        assert np.abs(left).max() > 1e-2
        np.testing.assert_allclose(asked[samples, kind], -left, atol=1e-9)


def test_the_kept_samples_alone_give_the_rows_of_the_log(case):
    equations, truth, prepared = case
    x = true_parameters(equations, truth)
    whole, alone = (rows_of(equations, each, x) for each in (prepared, prepared.at_kept()))
    assert whole.keys() == alone.keys()
    for kind, (samples, block) in whole.items():
        np.testing.assert_array_equal(alone[kind][0], samples)
        np.testing.assert_allclose(alone[kind][1], block, rtol=0, atol=1e-12)


def test_errors_of_the_current_stay_out_of_the_regressor(case):
    equations, truth, prepared = case
    x = true_parameters(equations, truth)
    noise = np.random.default_rng(0).normal(size=prepared.drive.shape)
    quiet, noisy = (rows_of(equations, p, x) for p in (prepared, replace(prepared, drive=prepared.drive + noise)))
    for axis in range(3):
        kind = equations.layout.axis(axis)
        np.testing.assert_allclose(quiet[kind][1][:, :-1], noisy[kind][1][:, :-1], atol=1e-10)
        expected = truth.xi["k_T"][axis] * noise[prepared.kept[quiet[kind][0]], axis]
        np.testing.assert_allclose(noisy[kind][1][:, -1] - quiet[kind][1][:, -1], expected, atol=1e-9)


def test_rows_of_coupled_axes_are_the_joint_rows_through_the_inverse_transposed_matrix(make_truth, make_log):
    truth = make_truth(True, coupling=DIFFERENTIAL)
    log = make_log(truth, seed=2, seconds=8.0)
    robot = replace(truth.robot, sensors=(WrenchSensor("plate", "link3", "contact", 1.0),))
    equations, prepared = equations_of(robot), prepared_of(robot, log)
    rows = rows_of(equations, prepared, np.zeros(equations.size))
    motion, to_axes = prepared.motion.rows(prepared.kept), np.linalg.inv(DIFFERENTIAL).T
    dense = regressor(robot.tree, motion)
    external = contact_effect(robot.tree, motion.q, "link3", prepared.wrenches[prepared.kept, 0])
    phi = np.random.default_rng(0).normal(size=truth.phi.size)
    torque, force = dense[:, 6:] @ phi @ to_axes.T, external[:, 6:] @ to_axes.T
    assert np.abs(force).max() > 1.0
    for axis in range(3):
        samples, block = rows[6 + axis]
        columns = equations.columns()[6 + axis][: -len(equations.effects)]
        own = (equations.base.regroup @ phi)[columns]
        np.testing.assert_allclose(block[:, : len(columns)] @ own, torque[samples, axis], atol=1e-9)
        np.testing.assert_allclose(block[:, -1], force[samples, axis], atol=1e-9)
        velocity = (motion.dq @ DIFFERENTIAL.T)[samples, axis]
        np.testing.assert_allclose(block[:, len(columns) + 1], velocity, atol=1e-12)


def test_what_bodies_ask_of_every_row_is_what_the_dense_regressor_says(make_truth, make_log, monkeypatch):
    truth = make_truth(True, coupling=DIFFERENTIAL)
    equations = equations_of(truth.robot)
    motion = prepared_of(truth.robot, make_log(truth, seed=2, seconds=4.0)).motion
    phi = np.random.default_rng(0).normal(size=(truth.phi.size, 2))
    dense = np.einsum("trp,pm->trm", regressor(truth.robot.tree, motion), phi)
    dense[:, 6:] = np.einsum("ab,tbm->tam", np.linalg.inv(DIFFERENTIAL).T, dense[:, 6:])
    monkeypatch.setattr(module, "CHUNK", 101)
    both = equations.of_bodies(motion, equations.base.regroup @ phi)
    np.testing.assert_allclose(both, dense, atol=1e-9)
    np.testing.assert_allclose(equations.of_bodies(motion, equations.base.regroup @ phi[:, 1]), both[..., 1], atol=1e-9)


def scores_of(equations, prepared, x, weights, length):
    return equations.stretches(prepared, x, weights, length, lambda chunk, _: chunk.residual(x))


def test_statistics_do_not_depend_on_how_the_log_is_cut(case, monkeypatch):
    equations, truth, prepared = case
    x, weights = true_parameters(equations, truth), np.ones(len(equations.columns()))
    (whole,) = equations.collect(prepared, x, 1)
    residual, scores = equations.residuals(prepared, x), scores_of(equations, prepared, x, weights, 37)
    monkeypatch.setattr(module, "CHUNK", 101)
    parts = equations.collect(prepared, x, 5)
    assert len(parts) == 5
    together = sum(parts[1:], parts[0])
    np.testing.assert_array_equal(whole.count, together.count)
    for one, other in zip(whole.normal(weights), together.normal(weights), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(one).max())
    np.testing.assert_allclose(equations.residuals(prepared, x), residual, atol=1e-10)
    again = scores_of(equations, prepared, x, weights, 37)
    np.testing.assert_allclose(again, scores, atol=1e-9 * np.abs(scores).max())


def test_scores_of_all_stretches_add_up_to_the_gradient(case):
    equations, truth, prepared = case
    x, weights = true_parameters(equations, truth) * 1.1, np.arange(1.0, len(equations.columns()) + 1)
    (whole,) = equations.collect(prepared, x, 1)
    G, g, _ = whole.normal(weights)
    total = scores_of(equations, prepared, x, weights, 50).sum(axis=0)
    np.testing.assert_allclose(total, g - G @ x, atol=1e-9 * np.abs(g).max())


def test_static_friction_is_recovered_from_rest_alone(make_truth, make_log):
    truth = make_truth(True, coupling=DIFFERENTIAL)
    equations, x = equations_of(truth.robot), true_parameters(equations_of(truth.robot), truth)
    prepared = prepared_of(truth.robot, make_log(truth, seed=1, seconds=20.0, noise=1.0))
    columns = static_friction_columns(equations)
    wrong = x.copy()
    wrong[columns] = 0.0
    (statistics,) = equations.collect(prepared, wrong, 1)
    prior = per_parameter(truth.robot, equations.base, equations.effects, scales(truth.robot, [prepared]))
    found = fill_static_friction(equations, statistics, prior, wrong)
    np.testing.assert_allclose(found.x[columns], truth.xi["tau_s"], rtol=0.05)
    np.testing.assert_array_equal(np.delete(found.x, columns), np.delete(x, columns))
    assert found.lower_bounds == ()


def test_static_friction_stays_at_the_prior_where_nothing_rests(make_truth, make_log):
    truth = make_truth(True)
    equations = equations_of(truth.robot)
    prepared = prepared_of(truth.robot, make_log(truth, seed=3, seconds=8.0, pause=False))
    x = true_parameters(equations, truth)
    (statistics,) = equations.collect(prepared, x, 1)
    prior = per_parameter(truth.robot, equations.base, equations.effects, scales(truth.robot, [prepared]))
    found = fill_static_friction(equations, statistics, prior, x)
    assert found.x[static_friction_columns(equations)].tolist() == [0.0, 0.0, 0.0]
    assert found.std == {}


def test_static_friction_is_not_known_where_an_axis_rests_for_moments_only(make_truth, make_log):
    """1.5 % of the samples, slow turns, gave a static friction of their own with a small deviation."""
    truth = make_truth(True, coupling=DIFFERENTIAL)
    equations, x = equations_of(truth.robot), true_parameters(equations_of(truth.robot), truth)
    prepared = prepared_of(truth.robot, make_log(truth, seed=1, seconds=20.0, noise=1.0))
    layout = equations.layout
    (statistics,) = equations.collect(prepared, x, 1)
    prior = per_parameter(truth.robot, equations.base, equations.effects, scales(truth.robot, [prepared]))
    for axis in range(len(truth.robot.joints)):
        statistics.count[layout.axis(axis)] = (
            70 * statistics.count[layout.resting(axis)]
        )  # as if it had moved all the rest of a long log
    found = fill_static_friction(equations, statistics, prior, x)
    assert found.std == {}
    columns = static_friction_columns(equations)
    np.testing.assert_array_equal(found.x[columns], prior.seen_mean[columns])
