"""Bounded least squares of blocks that share a few unknowns: against the dense problem, and its conditions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from exogauge.estimation.bounded_arrow import Block, solve_bounded

MOST = 2.5


def problem(seed, S=4, sizes=(6, 3, 9), strength=30.0):
    """Rows of each block hold the shared unknowns and its own, nearly dependent; a prior of 1 beside."""
    rng = np.random.default_rng(seed)
    rows, rights = [], []
    for place, size in enumerate(sizes):
        A = np.zeros((12, S + sum(sizes)))
        first = S + sum(sizes[:place])
        mixed = rng.normal(size=(12, S + size)) @ (np.eye(S + size) + 0.9)
        A[:, :S], A[:, first : first + size] = mixed[:, :S], mixed[:, S:]
        rows.append(strength * A)
        rights.append(strength * rng.normal(size=12) * 6.0)
    return S, sizes, np.vstack(rows), np.concatenate(rights)


def solved(S, sizes, A, y):
    H, g = A.T @ A + np.eye(A.shape[1]), A.T @ y
    edges = np.cumsum([S, *sizes])
    blocks = [Block(H[a:b, a:b], H[:S, a:b], g[a:b]) for a, b in itertools.pairwise(edges)]
    alike, own = solve_bounded(H[:S, :S], g[:S], blocks, MOST)
    return H, g, np.concatenate([alike, *own])


@pytest.mark.parametrize("seed", range(20))
def test_it_is_what_the_dense_problem_gives(seed):
    S, sizes, A, y = problem(seed)
    _, _, u = solved(S, sizes, A, y)
    n = A.shape[1]
    dense = lsq_linear(
        np.vstack([A, np.eye(n)]), np.concatenate([y, np.zeros(n)]), (-MOST, MOST), method="bvls", tol=1e-14
    )
    assert 0 < np.sum(np.abs(dense.x) > MOST - 1e-9) < n
    np.testing.assert_allclose(u, dense.x, atol=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_at_a_bound_the_cost_falls_outwards_and_nowhere_else(seed):
    H, g, u = solved(*problem(seed, strength=1e3))
    pull = g - H @ u
    inside = np.abs(u) < MOST
    assert np.abs(pull[inside]).max() < 1e-6 * np.abs(g).max()
    assert np.all(pull[~inside] * u[~inside] > 0.0)


def test_rows_that_weigh_as_if_exact_leave_numbers():
    S, sizes, A, y = problem(3, strength=1e9)
    _, _, u = solved(S, sizes, A, y)
    assert np.all(np.isfinite(u))
    assert np.abs(u).max() <= MOST
