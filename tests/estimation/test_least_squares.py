import numpy as np
import pytest
from scipy.linalg import null_space

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import SquareRoot, Statistics

COLUMNS = [np.arange(6), np.array([1, 3, 5]), np.array([0, 2, 4, 5])]
SIZE = 6


def rows(rng, n, kind, truth, noise=0.0):
    A = rng.normal(size=(n, len(COLUMNS[kind])))
    return np.column_stack([A, A @ truth[COLUMNS[kind]] + noise * rng.normal(size=n)])


def filled(form, rng, truth, noise=0.1, n=200):
    statistics = Statistics.empty(SIZE, COLUMNS, form)
    blocks = [rows(rng, n, kind, truth, noise) for kind in range(3)]
    for kind, block in enumerate(blocks):
        for part in np.array_split(block, 3):
            statistics.add_rows(kind, part)
    return statistics, blocks


def dense(blocks, weights):
    A = np.zeros((sum(len(b) for b in blocks), SIZE))
    y, row = [], 0
    for kind, block in enumerate(blocks):
        A[row : row + len(block), COLUMNS[kind]] = np.sqrt(weights[kind]) * block[:, :-1]
        y.append(np.sqrt(weights[kind]) * block[:, -1])
        row += len(block)
    return A, np.concatenate(y)


@pytest.mark.parametrize("form", ["gram", "factor"])
def test_statistics_give_what_the_stacked_matrix_gives(form):
    rng = np.random.default_rng(1)
    truth, weights = rng.normal(size=SIZE), np.array([1.0, 4.0, 0.25])
    statistics, blocks = filled(form, rng, truth)
    A, y = dense(blocks, weights)
    G, g, yy = statistics.normal(weights)
    np.testing.assert_allclose(G, A.T @ A, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(g, A.T @ y, rtol=1e-12, atol=1e-12)
    assert yy == pytest.approx(y @ y)
    root = statistics.square_root(weights)
    x = rng.normal(size=SIZE)
    assert np.sum((root.R @ x - root.z) ** 2) + root.rest == pytest.approx(np.sum((A @ x - y) ** 2))
    np.testing.assert_allclose(
        statistics.residual_square_sum(x),
        [np.sum((b[:, :-1] @ x[c] - b[:, -1]) ** 2) for b, c in zip(blocks, COLUMNS, strict=True)],
    )


@pytest.mark.parametrize("form", ["gram", "factor"])
def test_statistics_of_two_logs_add_up_to_those_of_both(form):
    rng = np.random.default_rng(2)
    truth = rng.normal(size=SIZE)
    first, blocks_1 = filled(form, rng, truth)
    second, blocks_2 = filled(form, rng, truth)
    A1, y1 = dense(blocks_1, np.ones(3))
    A2, y2 = dense(blocks_2, np.ones(3))
    G, g, _ = (first + second).normal(np.ones(3))
    np.testing.assert_allclose(G, A1.T @ A1 + A2.T @ A2)
    np.testing.assert_allclose(g, A1.T @ y1 + A2.T @ y2)


def stacked_prior_solution(A, y, prior, strength):
    """The textbook form over all parameters, for a prior without exactly known ones."""
    B = np.vstack([A @ prior.seen, np.sqrt(strength) * np.diag(1 / prior.std)])
    target = np.concatenate([y - A @ prior.seen @ prior.mean, np.zeros(len(prior.mean))])
    return prior.mean + np.linalg.lstsq(B, target, rcond=None)[0]


@pytest.mark.parametrize("form", ["gram", "factor"])
@pytest.mark.parametrize("strength", [1e-3, 1.0, 30.0])
def test_solution_equals_the_stacked_system_over_all_parameters(form, strength):
    rng = np.random.default_rng(3)
    seen = np.hstack([np.eye(SIZE), rng.normal(size=(SIZE, 4))])
    prior = Prior(rng.normal(size=10), rng.uniform(0.2, 3.0, size=10), seen)
    weights = np.array([1.0, 9.0, 0.5])
    statistics, blocks = filled(form, rng, rng.normal(size=SIZE))
    solved = PriorLeastSquares(statistics.square_root(weights), prior, strength)
    expected = stacked_prior_solution(*dense(blocks, weights), prior, strength)
    np.testing.assert_allclose(prior.lift(solved.x), expected, rtol=1e-9, atol=1e-9)


def test_prior_decides_what_the_data_cannot():
    rng = np.random.default_rng(4)
    seen = np.hstack([np.eye(SIZE), np.zeros((SIZE, 2))])
    seen[0, 6] = 1.0
    prior = Prior(rng.normal(size=8), np.ones(8), seen)
    statistics, _ = filled("gram", rng, rng.normal(size=SIZE))
    lifted = prior.lift(PriorLeastSquares(statistics.square_root(np.ones(3)), prior, 1.0).x)
    assert lifted[7] == prior.mean[7]
    moved = lifted - prior.mean
    assert moved[0] == pytest.approx(moved[6])


def test_known_parameters_stay_exactly_where_they_are():
    rng = np.random.default_rng(5)
    truth = rng.normal(size=SIZE)
    std = np.full(SIZE, 1e4)
    std[2] = 0.0
    prior = Prior(np.where(std == 0.0, truth, 0.0), std, np.eye(SIZE))
    statistics, _ = filled("gram", rng, truth, noise=0.0)
    solved = PriorLeastSquares(statistics.square_root(np.ones(3)), prior, 1.0)
    assert solved.x[2] == truth[2]
    np.testing.assert_allclose(solved.x, truth, atol=1e-6)


def test_an_unexcited_direction_stays_at_the_prior():
    statistics = Statistics.empty(2, [np.arange(2)], "gram")
    t = np.linspace(0, 1, 50)
    statistics.add_rows(0, np.column_stack([t, 2 * t, 5 * t]))
    prior = Prior(np.array([1.0, 1.0]), np.array([1.0, 1.0]), np.eye(2))
    solved = PriorLeastSquares(statistics.square_root(np.array([1e8])), prior, 1.0)
    assert solved.x @ [1, 2] == pytest.approx(5.0, abs=1e-6)
    assert (solved.x - 1.0) @ [2, -1] == pytest.approx(0.0, abs=1e-9)


def test_intervals_cover_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(6)
    seen = np.hstack([np.eye(SIZE), rng.normal(size=(SIZE, 3))])
    std = rng.uniform(0.3, 2.0, size=9)
    inside, strength, noise = [], 0.3, 0.5
    for _ in range(300):
        belief = Prior(np.zeros(9), std, seen)
        truth = std * rng.normal(size=9)
        statistics, _ = filled("gram", rng, seen @ truth, noise=noise, n=5)
        solved = PriorLeastSquares(statistics.square_root(np.full(3, noise**-2)), belief, strength)
        covariance = belief.lift_covariance(solved.covariance())
        inside.append(np.abs(belief.lift(solved.x) - truth) < 1.96 * np.sqrt(np.diag(covariance)))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.012)


def test_a_weak_belief_keeps_its_digits_where_the_data_say_nothing():
    rng = np.random.default_rng(3)
    R, mean = 1e3 * rng.normal(size=(7, 10)), rng.normal(size=10)
    data = SquareRoot(R, R @ rng.normal(size=10), 0.0)
    x = PriorLeastSquares(data, Prior(mean, np.ones(10), np.eye(10)), strength=1e-14).x
    assert np.abs(null_space(R).T @ (x - mean)).max() < 1e-10


@pytest.mark.parametrize(("decades", "digits"), [(3, 1e-11), (5, 1e-9), (9, 1e-5)])
def test_the_solution_keeps_the_digits_that_squaring_the_data_loses(decades, digits):
    """Squared, the last has a condition number of 1e18, which no normal equations bear."""
    rng = np.random.default_rng(11)
    n = 30
    left, right = (np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(2))
    R, truth, strength = (left * np.logspace(0.0, -decades, n)) @ right, rng.normal(size=n), 1e-24
    x = PriorLeastSquares(SquareRoot(R, R @ truth, 0.0), Prior(np.zeros(n), np.ones(n), np.eye(n)), strength).x
    np.testing.assert_allclose(x, truth, atol=digits)


@pytest.mark.parametrize("strength", [0.05, 1.0, 20.0])
def test_the_covariance_is_that_of_errors_of_the_data_and_of_the_belief_through_the_solver(strength):
    """The estimate is linear in both: unit errors through the solver itself give its two gains, and they the sandwich.

    A belief that is counted more (or less) than it is worth errs with its stated doubt all the same.
    """
    rng = np.random.default_rng(7)
    R, truth = rng.normal(size=(9, SIZE)), rng.normal(size=SIZE)
    std = rng.uniform(0.2, 2.0, size=SIZE)
    colour = rng.normal(size=(9, 9))
    noise = colour @ colour.T + np.eye(9)

    def estimate(data_error, belief_error):
        belief = Prior(truth + belief_error, std, np.eye(SIZE))
        return PriorLeastSquares(SquareRoot(R, R @ truth + data_error, 0.0), belief, strength)

    nothing, none = np.zeros(9), np.zeros(SIZE)
    of_data = np.column_stack([estimate(e, none).x - truth for e in np.eye(9)])
    of_belief = np.column_stack([estimate(nothing, e).x - truth for e in np.eye(SIZE)])
    solved = estimate(nothing, none)
    for meat, errors in ((None, np.eye(9)), (R.T @ noise @ R, noise)):
        expected = of_data @ errors @ of_data.T + of_belief @ np.diag(std**2) @ of_belief.T
        np.testing.assert_allclose(solved.covariance(meat), expected, rtol=1e-9, atol=1e-12)


def test_a_bias_is_taken_off_the_solution_and_off_what_the_data_alone_answer():
    rng = np.random.default_rng(8)
    R, z, step = rng.normal(size=(9, SIZE)), rng.normal(size=9), rng.normal(size=SIZE)
    std = np.ones(SIZE)
    std[4] = 0.0  # known, and stays
    solved = PriorLeastSquares(SquareRoot(R, z, 0.0), Prior(rng.normal(size=SIZE), std, np.eye(SIZE)), 0.7)
    before = solved.x.copy(), np.linalg.lstsq(solved.information, solved.target, rcond=None)[0]
    solved.shift(step)
    alone = np.linalg.lstsq(solved.information, solved.target, rcond=None)[0]
    free = np.delete(np.arange(SIZE), 4)
    np.testing.assert_allclose(alone - before[1], step[free], atol=1e-12)
    np.testing.assert_allclose((solved.x - before[0])[free], step[free], atol=1e-12)
    assert solved.x[4] == before[0][4]
