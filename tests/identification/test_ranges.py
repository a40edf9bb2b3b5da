"""Coefficients that leave what nature allows."""

import numpy as np

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.identification.ranges import solve_within_ranges


def test_friction_that_would_push_is_held_at_zero_and_the_rest_solved_again(small, statistics_for):
    equations, _, prior = small
    x = prior.seen_mean.copy()
    names = [effect.coefficient.name for effect in equations.effects]
    first, second = equations.effect_columns(0), equations.effect_columns(1)
    pushing = first[names.index("k_d")]
    x[pushing], x[second[names.index("k_d")]], x[first[names.index("tau_o")]] = -2.0, 3.0, -4.0
    statistics, weights = statistics_for(x), np.ones(len(equations.columns()))
    data = statistics.square_root(weights)
    free = PriorLeastSquares(data, prior, 1e-3)
    assert free.x[pushing] < -1.5
    solved, held = solve_within_ranges(equations, data, free, np.zeros(equations.size))
    assert "k_d[j1]" in held
    assert solved.x[pushing] == 0.0
    assert solved.x[first[names.index("tau_o")]] < -1.0  # an offset may have any sign
    low = np.tile([effect.coefficient.low for effect in equations.effects], 2)
    assert np.all(solved.x[equations.base_size :] >= low - 1e-5)
    std = prior.std.copy()
    for name in held:
        joint = ("j1", "j2").index(name[-3:-1])
        std[prior.mean.size - 12 + 6 * joint + names.index(name[:-4])] = 0.0
    directly = PriorLeastSquares(statistics.square_root(weights), Prior(prior.mean, std, prior.seen), 1e-3)
    np.testing.assert_allclose(solved.x, directly.x, atol=1e-8)


def test_nothing_is_held_where_nothing_leaves_its_range(small):
    equations, prepared, prior = small
    statistics = equations.collect(prepared, prior.seen_mean, 1)[0]
    weights = np.ones(len(equations.columns()))
    data = statistics.square_root(weights)
    free = PriorLeastSquares(data, prior, 1.0)
    nearest = PriorLeastSquares(data, prior, 1.0)
    solved, held = solve_within_ranges(equations, data, nearest, np.zeros(equations.size))
    assert held == ()
    np.testing.assert_array_equal(solved.x, free.x)
