"""The doctor's fit of one axis against the same written out: dense covariances, every choice of columns by itself."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from exogauge.criteria.examining import Comparing
from exogauge.plausibility.axis_fit import AS_DESCRIBED, GAINS, AxisFit, explained


def every_choice(M, b):
    """The most, and its coefficients, of one: all but the last at least 0."""
    K, best = len(b), (-np.inf, np.zeros(len(b)))
    for size in range(K):
        for some in combinations(range(K - 1), size):
            columns = [*some, K - 1]
            x = np.linalg.lstsq(M[np.ix_(columns, columns)], b[columns], rcond=None)[0]
            if (x[:-1] >= 0.0).all() and x @ b[columns] > best[0]:
                whole = np.zeros(K)
                whole[columns] = x
                best = x @ b[columns], whole
    return best


@pytest.mark.parametrize("empty", [None, 0, 2])
def test_the_most_is_explained_without_a_negative_coefficient_but_the_last(empty):
    rng = np.random.default_rng(7)
    Z = rng.normal(size=(20, 30, 4))
    if empty is not None:
        Z[:, :, empty] = 0.0
    y = rng.normal(size=(20, 30)) - 2.0
    M, b = np.swapaxes(Z, 1, 2) @ Z, np.einsum("gnk,gn->gk", Z, y)
    most, x = explained(M, b)
    wanted = [every_choice(*each) for each in zip(M, b, strict=True)]
    np.testing.assert_allclose(most, [each for each, _ in wanted], rtol=1e-9)
    np.testing.assert_allclose(x, [each for _, each in wanted], atol=1e-9)
    assert (x[:, 3] < 0.0).any()


@pytest.mark.parametrize("other_bodies", [False, True])
def test_the_likelihood_is_that_of_the_written_model(other_bodies):
    rng, criteria = np.random.default_rng(3), Comparing()
    N = 40
    load, spread = rng.normal(size=N), 0.1 * rng.normal(size=(N, 5))
    dq, ddq = rng.normal(size=N), rng.normal(size=N)
    effort = 1.3 * load + 0.4 * np.sign(dq) - 0.2 + 0.05 * rng.normal(size=N)
    fit = AxisFit(load, spread, dq, np.sign(dq), ddq, np.ones(N, dtype=bool), criteria)
    found = fit.likelihood(effort, other_bodies=other_bodies)
    rms = np.sqrt(np.mean(effort**2))
    Z = np.column_stack([dq, np.sign(dq), ddq, np.ones(N)])
    Z = Z / np.sqrt(np.mean(Z**2, axis=0))
    wanted, misfits = [], []
    told = GAINS < 20.0  # beyond, a dense inverse has no digits left
    for gain in GAINS[told]:
        each = []
        for share in criteria.unmodelled:
            V = gain**2 * spread @ spread.T + (share * rms) ** 2 * np.eye(N)
            W, r = np.linalg.inv(V), effort - (1.0 if other_bodies else gain) * load
            M = Z.T @ W @ Z
            M[3, 3] += 1.0 / (criteria.offset * rms) ** 2
            most, x = every_choice(M, Z.T @ W @ r)
            left = (share * rms) * np.linalg.solve(np.linalg.cholesky(V), r - Z @ x)
            each.append((0.5 * (most - r @ W @ r - np.linalg.slogdet(V)[1]), np.sqrt(np.mean(left**2)) / rms))
        best = max(each)
        wanted.append(criteria.independent * best[0])
        misfits.append(best[1])
    np.testing.assert_allclose(found.logs[told], wanted, rtol=1e-6, atol=1e-6)
    near = np.flatnonzero(AS_DESCRIBED)[np.argmax(found.logs[AS_DESCRIBED])]
    assert found.misfit == pytest.approx(misfits[near], rel=1e-6)
