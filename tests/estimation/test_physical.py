from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.optimize import least_squares

from exogauge.errors import PhysicallyImpossible
from exogauge.estimation.log_cholesky import (
    central_moments,
    from_log_cholesky,
    log_cholesky_jacobian,
    log_det_distance,
    pseudo_inertia,
    to_log_cholesky,
)
from exogauge.estimation.physical import solve_physical
from exogauge.remarks import About, Remark

SPREAD = (((0.4, 0.4), 1), ((-2, 0.3), 3), ((0, 0.02), 3), ((0, 0.1), 3))
UNITS = np.array([1, 0.1, 0.1, 0.1] + [0.01] * 6)


def bodies(rng: np.random.Generator, count: int) -> np.ndarray:
    """Random possible bodies of a few kg and decimetres."""
    scale, size, shear, shift = (rng.normal(*spread, (count, n)) for spread, n in SPREAD)
    return from_log_cholesky(np.column_stack([scale, size, shear, shift]))


def disturbed(rng: np.random.Generator, phi: np.ndarray, size: float) -> np.ndarray:
    scale = np.array([1, 1, 1, 1, 0.1, 0.1, 0.1, 0.3, 0.3, 0.3]) * size
    return from_log_cholesky(to_log_cholesky(phi) + rng.normal(size=phi.shape) * scale)


def measured(
    rng: np.random.Generator, phi: np.ndarray, other: np.ndarray, rows: int, information: float, rank: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """A triangular (R, z) from noisy rows of unit std; `rank` limits what is seen of phi."""
    seen = rng.normal(size=(rows, phi.size))
    if rank is not None:
        seen = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, phi.size)) / np.sqrt(rank)
    A = np.column_stack([information * seen / np.tile(UNITS, len(phi)), rng.normal(size=(rows, len(other)))])
    y = A @ np.r_[phi.ravel(), other] + rng.normal(size=rows)
    triangle = np.linalg.qr(np.column_stack([A, y]), mode="r")
    return triangle[:-1, :-1], triangle[:-1, -1]


def all_possible(phi: np.ndarray) -> bool:
    return bool(np.all(phi[:, 0] > 0) and np.linalg.eigvalsh(pseudo_inertia(phi)).min() > 0)


def plate(mass: float, x: float, y: float, z: float, centre: np.ndarray) -> np.ndarray:
    """A homogeneous box with its centre off the frame's origin."""
    J = np.zeros((4, 4))
    J[:3, :3] = mass * (np.diag([x**2, y**2, z**2]) / 12 + np.outer(centre, centre))
    J[:3, 3] = J[3, :3] = mass * centre
    J[3, 3] = mass
    I = np.trace(J[:3, :3]) * np.eye(3) - J[:3, :3]  # noqa: E741
    return np.r_[mass, mass * centre, I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2]]


def test_a_thin_box_stays_possible_where_plain_least_squares_does_not() -> None:
    truth = plate(2.0, 0.4, 0.3, 0.002, np.array([0.1, -0.05, 0.0]))
    reference = plate(2.2, 0.4, 0.3, 0.02, np.array([0.09, -0.05, 0.01]))
    impossible, errors = 0, []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        R, z = measured(rng, truth[None], np.zeros(0), 60, 0.05)
        free = np.linalg.solve(R, z)
        solution = solve_physical(R, z, reference[None])
        assert solution.converged
        assert all_possible(solution.phi)
        assert solution.margin.min() > 0
        if not all_possible(free[None]):
            impossible += 1
            errors.append([np.linalg.norm((x - truth) / UNITS) for x in (free, solution.phi[0])])
    assert impossible >= 10
    plain, possible = np.mean(errors, axis=0)
    assert possible < plain


def test_little_noise_gives_the_truth_back() -> None:
    rng = np.random.default_rng(1)
    truth, other = bodies(rng, 5), rng.normal(size=7)
    R, z = measured(rng, truth, other, 400, 1e3)
    solution = solve_physical(R, z, disturbed(rng, truth, 0.2), weight=1e-3)
    np.testing.assert_allclose(solution.phi / UNITS, truth / UNITS, atol=2e-3)
    np.testing.assert_allclose(solution.other, other, atol=0.3)
    np.testing.assert_array_equal(solution.x, np.r_[solution.phi.ravel(), solution.other])
    assert solution.cost == pytest.approx(float(np.sum((R @ solution.x - z) ** 2)))


@pytest.mark.parametrize("weight", [1e-6, None])
def test_a_free_solution_that_is_possible_is_the_answer(weight: float | None) -> None:
    rng = np.random.default_rng(2)
    truth, other = bodies(rng, 4), rng.normal(size=3)
    R, z = measured(rng, truth, other, 300, 100.0)
    free = np.linalg.solve(R, z)
    assert all_possible(free[:40].reshape(4, 10))
    solution = solve_physical(R, z, disturbed(rng, truth, 0.2), weight=weight)
    assert np.linalg.norm(R @ (solution.x - free)) < 1e-3
    assert solution.excess < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("weight", [None, 0.5])
def test_log_cholesky_search_finds_the_same_bodies(weight: float | None) -> None:
    rng = np.random.default_rng(3)
    truth, other = bodies(rng, 2), rng.normal(size=2)
    reference = disturbed(rng, truth, 0.2)
    R, z = measured(rng, truth, other, 60, 0.5)
    solution = solve_physical(R, z, reference, weight=weight, tolerance=1e-9)

    def residual(x: np.ndarray) -> np.ndarray:
        phi = from_log_cholesky(x[:20].reshape(2, 10))
        distance = np.sqrt(np.maximum(log_det_distance(phi, reference), 0) * (weight or 0.0))
        return np.r_[R @ np.r_[phi.ravel(), x[20:]] - z, distance]

    start = np.r_[to_log_cholesky(disturbed(rng, truth, 0.05)).ravel(), other]
    searched = least_squares(residual, start, xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=200)
    objective = solution.cost + (weight or 0.0) * float(np.sum(solution.distance))
    assert objective <= 2 * searched.cost * (1 + 1e-8)
    slow = 1e-2 if weight is None else 1e-6  # at the border theta crawls towards -∞
    assert objective == pytest.approx(2 * searched.cost, rel=slow)


def test_the_optimum_is_stationary_in_log_cholesky_coordinates() -> None:
    rng = np.random.default_rng(5)
    truth = bodies(rng, 3)
    reference = disturbed(rng, truth, 0.2)
    R, z = measured(rng, truth, np.zeros(0), 60, 1.0, rank=20)
    solution = solve_physical(R, z, reference, weight=2.0, tolerance=1e-10)
    slope = 2 * (R.T @ (R @ solution.x - z)).reshape(3, 10)
    difference = np.linalg.inv(pseudo_inertia(reference)) - np.linalg.inv(pseudo_inertia(solution.phi))
    slope += 2.0 * np.einsum("nij,kji->nk", difference, pseudo_inertia(np.eye(10)))
    jacobian = log_cholesky_jacobian(to_log_cholesky(solution.phi))
    assert np.abs(np.einsum("nk,nkl->nl", slope, jacobian)).max() < 1e-3


def test_the_reference_decides_what_the_data_cannot() -> None:
    rng = np.random.default_rng(6)
    reference = bodies(rng, 3)
    solution = solve_physical(np.zeros((1, 30)), np.zeros(1), reference, weight=1.0)
    np.testing.assert_allclose(solution.phi, reference, rtol=1e-6, atol=1e-9)


def test_massless_and_held_bodies_do_not_move() -> None:
    rng = np.random.default_rng(8)
    truth = bodies(rng, 4)
    reference = disturbed(rng, truth, 0.2)
    reference[1] = truth[1] = 0.0
    R, z = measured(rng, truth, rng.normal(size=2), 200, 10.0)
    solution = solve_physical(R, z, reference, weight=0.1, held=np.array([False, False, False, True]))
    np.testing.assert_array_equal(solution.held, [False, True, False, True])
    np.testing.assert_array_equal(solution.phi[[1, 3]], reference[[1, 3]])
    assert all_possible(solution.phi[[0, 2]])
    assert np.isnan(solution.margin[[1, 3]]).all()


def test_an_impossible_reference_is_replaced_and_said() -> None:
    rng = np.random.default_rng(9)
    truth = bodies(rng, 2)
    point_mass = truth.copy()
    point_mass[0, 4:] = 0.0
    R, z = measured(rng, truth, np.zeros(0), 200, 100.0)
    solution = solve_physical(R, z, point_mass, weight=1e-3)
    assert solution.remarks[0] == Remark(About.REFERENCE_IMPOSSIBLE, ("0",))
    assert all_possible(solution.phi)
    with pytest.raises(PhysicallyImpossible):
        solve_physical(R, z, truth * np.array([[-1.0], [1.0]]))


def test_undetermined_other_parameters_are_said() -> None:
    rng = np.random.default_rng(10)
    truth = bodies(rng, 1)
    R, z = measured(rng, truth, rng.normal(size=2), 50, 10.0)
    solution = solve_physical(np.column_stack([R, np.zeros(len(R))]), z, truth, weight=1.0)
    assert solution.remarks[0] == Remark(About.UNDECIDED_COMBINATIONS, numbers=(1,))
    assert solution.other[2] == 0.0


@pytest.mark.parametrize(("information", "weight"), [(1.0, 1e-2), (0.03, 1e-2), (100.0, 1.0), (0.1, None)])
def test_a_humanoid_is_solved_within_seconds_and_every_body_is_possible(
    information: float, weight: float | None
) -> None:
    rng = np.random.default_rng(11)
    truth, other = bodies(rng, 33), rng.normal(size=160)
    reference = disturbed(rng, truth, 0.2)
    R, z = measured(rng, truth, other, 1500, information, rank=234)
    if weight is None:  # what is known before, as rows
        rows = np.column_stack([np.diag(1 / np.tile(UNITS, 33)), np.zeros((330, 160))])
        R, z = np.vstack([R, rows]), np.r_[z, reference.ravel() / np.tile(UNITS, 33)]
    began = time.process_time()
    solution = solve_physical(R, z, reference, weight=weight)
    assert time.process_time() - began < 10
    assert solution.converged
    assert all_possible(solution.phi)
    assert np.linalg.eigvalsh(central_moments(solution.phi)).min() > 0
    np.testing.assert_allclose(solution.other, other, atol=0.3)


@pytest.mark.parametrize("digits", [8, 10])
def test_a_search_ends_though_some_rows_are_without_noise(digits: int) -> None:
    """As of logs in which nothing moves and nothing flickers: a few combinations of bodies are known to many digits."""
    rng = np.random.default_rng(3)
    truth = bodies(rng, 4)
    reference = disturbed(rng, truth, 0.2)
    R, z = measured(rng, truth, np.zeros(0), 60, 1.0, rank=12)
    exact = rng.normal(size=(6, truth.size)) / np.tile(UNITS, 4)
    solution, plain = (
        solve_physical(
            np.vstack([R, sure * exact]), np.concatenate([z, sure * exact @ truth.ravel()]), reference, weight=0.5
        )
        for sure in (10.0**digits, 1e4)
    )
    assert solution.converged
    assert all_possible(solution.phi)
    scale = np.linalg.norm(exact, axis=1) * np.linalg.norm(truth)
    assert np.max(np.abs(exact @ (solution.phi - truth).ravel()) / scale) < 1e-6
    assert solution.phi == pytest.approx(plain.phi, rel=1e-3, abs=1e-3)
