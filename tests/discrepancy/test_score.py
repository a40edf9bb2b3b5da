"""A candidate scored in sums is a candidate fitted beside the whole baseline."""

import numpy as np
import pytest

from exogauge.effects.base_tilt import BaseTilt
from exogauge.effects.catalogue import missing_effects, shaped_effects
from exogauge.effects.imu_tilt import ImuTilt
from exogauge.identification.sites import AxisSite, BaseSite, PairSite, seen_by
from exogauge.search.candidates import Candidate, columns_of, grid, place_kind, sites
from exogauge.search.score import Baseline, residual_memory, score
from exogauge.search.sums import KindSums, Sums, rows_of

MEMORY = dict.fromkeys(range(20), 5.0)


@pytest.fixture(scope="module")
def case(study, on_joint, identified):
    """(baseline, fitted logs prepared, the model's own solution) of an arm whose third joint rubs one way."""
    recordings = study(on_joint(2, lambda m: 0.3 * np.maximum(m.v, 0.0)))
    model = identified(recordings).model
    solution = model.solution
    fitted = [model.prepare(each.log) for each in recordings if not each.held_out]
    return Baseline(model, MEMORY), fitted, solution.unbounded.x


@pytest.fixture(scope="module")
def scored(case):
    baseline, logs, _ = case
    model = baseline.model

    def of(name, axis, shape):
        site = AxisSite(axis)
        candidate, sums = Candidate(shaped_effects()[name], site, shape), Sums()
        for prepared in logs:
            kinds = site.kinds(model.equations)
            _, rows = rows_of(model, prepared, set(kinds))
            sums.take(site, kinds, columns_of([candidate], site.see(model, prepared), prepared, 1), rows)
        return score(baseline, candidate, sums.by_site[site])

    return of


def dense(model, logs, candidate=None):
    """(least cost, its parameters [x_free; coefficients]) of all rows and the prior, stacked and solved at once."""
    equations, prior, strength = model.equations, model.solution.prior, model.solution.strength
    kinds, width = equations.columns(), candidate.width if candidate else 0
    rows, right = [], []
    for prepared in logs:
        if candidate:
            delivered = columns_of([candidate], candidate.site.see(model, prepared), prepared, 1).every[:, :, 0]
        for _, chunks in equations.rows(prepared, np.zeros(equations.size)):
            for chunk in chunks:
                root = np.sqrt(model.solution.weights[chunk.kind] / MEMORY[chunk.kind])
                full = np.zeros((len(chunk.samples), equations.size + width))
                full[:, kinds[chunk.kind]] = chunk.block[:, :-1]
                if candidate and chunk.kind == equations.layout.axis(candidate.site.axis):
                    full[:, equations.size :] = -delivered[chunk.samples]
                rows.append(root * full)
                right.append(root * chunk.block[:, -1])
    A, y = np.vstack(rows), np.concatenate(right)
    y = y - A[:, : equations.size] @ prior.seen_mean
    A = A[:, np.concatenate([prior.free, np.arange(equations.size, equations.size + width)])]
    belief = np.zeros((len(prior.free), A.shape[1]))
    belief[:, : len(prior.free)] = np.sqrt(strength) * prior.whitening
    A, y = np.vstack([A, belief]), np.concatenate([y, np.zeros(len(belief))])
    scale = np.linalg.norm(A, axis=0)
    z = np.linalg.lstsq(A / scale, y, rcond=1e-14)[0]
    left = y - A / scale @ z
    return left @ left, z / scale


@pytest.mark.parametrize(
    ("name", "axis", "shape"), [("asym_viscous", 2, ()), ("torque_ripple", 1, (7.3,)), ("torque_delay", 0, ())]
)
def test_the_gain_is_what_fitting_everything_again_would_take_off_the_cost(case, scored, name, axis, shape):
    baseline, logs, x = case
    model, found = baseline.model, scored(name, axis, shape)
    without, before = dense(model, logs)
    with_it, after = dense(model, logs, found.candidate)
    free, mean = model.solution.prior.free, model.solution.prior.seen_mean
    assert without - with_it > 0.002
    assert found.gain == pytest.approx(without - with_it, rel=1e-6)
    np.testing.assert_allclose(found.coefficients, after[len(free) :], rtol=1e-6)
    scale = 1e-6 * np.abs(after[: len(free)] - before).max()
    np.testing.assert_allclose(found.without[free], (mean - x)[free] + before, atol=scale)
    np.testing.assert_allclose(found.step[free], (mean - x)[free] + after[: len(free)], atol=scale)


def test_an_effect_that_would_have_to_push_is_held_at_nothing(case, scored):
    baseline, logs, _ = case
    found = scored("stribeck", 0, (0.2, 1.0))
    _, x = dense(baseline.model, logs, found.candidate)
    assert x[-1] < 0.0  # what least squares would like
    assert found.coefficients == pytest.approx(0.0, abs=1e-6)
    assert found.gain == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("axis", range(3))
def test_a_column_that_the_baseline_holds_already_gains_nothing(case, axis):
    baseline, logs, at = case
    model = baseline.model
    kind, nothing = model.equations.layout.axis(axis), Candidate(shaped_effects()["asym_viscous"], AxisSite(axis), ())
    names = [effect.name for effect in model.equations.effects]
    for name in ("viscous", "coulomb", "motor_offset", "rotor_inertia"):
        place = len(model.equations.blocks.columns[kind]) + names.index(name)
        sums = KindSums.empty(1, len(model.equations.columns()[kind]))
        for prepared in logs:
            for _, chunks in model.equations.rows(prepared, at):
                for chunk in (each for each in chunks if each.kind == kind):
                    A, y = chunk.block[:, :-1], chunk.block[:, -1]
                    sums.add(A, -A[:, [place]], y - A @ at[model.equations.columns()[kind]])
        found = score(baseline, nothing, {kind: sums})
        assert found is None or (found.left < 1e-4 and found.evidence < 0.0)


def test_what_least_squares_cannot_see_beside_the_baseline_has_no_score(case):
    baseline, _, _ = case
    model = baseline.model
    kind = model.equations.layout.axis(0)
    still = KindSums.empty(1, len(model.equations.columns()[kind]))
    still.add(np.zeros((50, still.cross.shape[1])), np.zeros((50, 1)), np.ones(50))
    assert score(baseline, Candidate(shaped_effects()["asym_viscous"], AxisSite(0), ()), {kind: still}) is None


def test_sums_of_two_halves_are_the_sums_of_the_whole():
    rng = np.random.default_rng(0)
    A, c, e = rng.normal(size=(40, 3)), rng.normal(size=(40, 4)), rng.normal(size=40)
    halves = KindSums.empty(4, 3)
    for part in (slice(0, 15), slice(15, 40)):
        halves.add(A[part], c[part], e[part])
    whole = KindSums.empty(4, 3)
    whole.add(A, c, e)
    joined = KindSums.empty(4, 3)
    for _ in range(2):
        joined.join(whole)
    for sums, times in ((halves, 1.0), (whole, 1.0), (joined, 2.0)):
        cross, with_residual, own = sums.of(np.array([1, 3]))
        np.testing.assert_allclose(cross, -times * c[:, [1, 3]].T @ A)
        np.testing.assert_allclose(own, times * c[:, [1, 3]].T @ c[:, [1, 3]])
        np.testing.assert_allclose(with_residual, -times * c[:, [1, 3]].T @ e)
        assert sums.rows == times * 40


@pytest.mark.parametrize("rho", [0.5, 0.8])
def test_samples_that_count_as_one_are_those_of_an_autoregression(rho):
    rng = np.random.default_rng(1)
    e = np.empty(40000)
    e[0] = rng.normal()
    for k in range(1, len(e)):
        e[k] = rho * e[k - 1] + rng.normal()
    e[rng.random(len(e)) < 0.2] = np.nan  # gaps, where the axis gives no row
    assert residual_memory(e) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.15)


def test_the_grid_holds_every_combination_of_the_shapes():
    stribeck = shaped_effects()["stribeck"]
    assert len(set(grid(stribeck))) == len(stribeck.shapes[0].grid) * len(stribeck.shapes[1].grid)
    assert list(grid(shaped_effects()["asym_viscous"])) == [()]


def test_what_all_sites_see_together_is_what_each_sees(case):
    baseline, logs, _ = case
    model = baseline.model
    places = sites(model)
    assert any(isinstance(site, PairSite) for site in places)
    together, alone = seen_by(model, logs[0], places), {site: site.see(model, logs[0]) for site in places}
    assert together.keys() == alone.keys()
    for site, seen in together.items():
        for effect in missing_effects():
            if effect.place == place_kind(site):
                shape = next(grid(effect))
                own = alone[site].columns(effect, shape)
                np.testing.assert_allclose(
                    seen.columns(effect, shape), own, rtol=0.0, atol=1e-11 * max(np.abs(own).max(), 1e-300)
                )


def test_columns_of_all_candidates_are_each_filtered_by_itself(case):
    baseline, logs, _ = case
    model = baseline.model
    site, prepared = AxisSite(1), logs[1]
    seen = site.see(model, prepared)
    every = [Candidate(effect, site, shape) for effect in shaped_effects().values() for shape in grid(effect)]
    together = columns_of(every, seen, prepared, 1).every[:, :, 0]
    start = 0
    for each in every:
        own = prepared.low_pass.apply(np.ascontiguousarray(each.effect.columns(seen.signals, each.shape)))
        own, of_all = own[prepared.kept], together[:, start : start + each.width]
        np.testing.assert_allclose(of_all, own, rtol=0.0, atol=1e-12 * max(np.abs(own).max(), 1e-300))
        start += each.width
    assert start == together.shape[1]


def test_two_effects_of_one_name_keep_their_own_columns(case):
    baseline, logs, _ = case
    model = baseline.model
    site = BaseSite()
    seen, kinds = site.see(model, logs[0]), len(site.kinds(model.equations))
    neighbours = [Candidate(BaseTilt(), site, ()), Candidate(ImuTilt(), site, ())]
    assert neighbours[0].effect.name == neighbours[1].effect.name
    together = columns_of(neighbours, seen, logs[0], kinds).every
    apart = [columns_of([each], seen, logs[0], kinds).every for each in neighbours]
    np.testing.assert_array_equal(together, np.concatenate(apart, axis=1))
    assert together.shape[1] == sum(each.width for each in neighbours)


def test_candidates_that_are_alike_in_a_log_have_the_sums_that_each_has_by_itself(case):
    baseline, logs, x = case
    model = baseline.model
    site, kind = AxisSite(2), model.equations.layout.axis(2)
    effect = shaped_effects()["friction_shift"]
    every = [Candidate(effect, site, shape) for shape in grid(effect)]
    for number, prepared in enumerate(logs):
        sums, columns = Sums(), columns_of(every, site.see(model, prepared), prepared, 1)
        assert columns.different.shape[1] == (effect.shapes[0].low <= number) * len(effect.coefficients)
        assert columns.every.shape[1] == len(every) * len(effect.coefficients)
        _, rows = rows_of(model, prepared, {kind})
        sums.take(site, site.kinds(model.equations), columns, rows)
        whole = KindSums.empty(columns.every.shape[1], len(model.equations.columns()[kind]))
        for _, chunks in model.equations.rows(prepared, x):
            for chunk in chunks:
                if chunk.kind == kind:
                    whole.add(chunk.block[:, :-1], columns.every[chunk.samples, :, 0], chunk.residual(x))
        found = sums.by_site[site][kind]
        for name in ("cross", "own", "with_residual"):
            one, other = getattr(found, name), getattr(whole, name)
            np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12 * max(np.abs(other).max(), 1e-300))
        assert found.rows == whole.rows
