"""Bodies that can exist, whatever the data call for."""

import numpy as np

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.identification.physical import possible_parameters
from exogauge.robots.consistency import is_physical


def test_every_link_is_possible_where_the_data_call_for_an_impossible_one(small, statistics_for):
    equations, _, prior = small
    phi = equations.robot.tree.phi.copy()
    phi[:, [4, 6]] *= 0.1  # two moments of inertia that together are less than the third
    impossible = np.concatenate([equations.base.regroup @ phi.ravel(), prior.seen_mean[equations.base_size :]])
    statistics = statistics_for(impossible)
    solved = PriorLeastSquares(statistics.square_root(np.full(len(equations.columns()), 1e4)), prior, 1.0)
    free = solved.prior.lift(solved.x)[: phi.size].reshape(phi.shape)
    assert not all(is_physical(one) for one in free)
    standard, _ = possible_parameters(equations.robot, solved, np.zeros(0, dtype=np.intp))
    assert all(is_physical(one) for one in standard[: phi.size].reshape(phi.shape))
    known = prior.std == 0.0
    np.testing.assert_array_equal(standard[known], prior.mean[known])
