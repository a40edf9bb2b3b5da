"""Bodies that can exist, whatever the data call for."""

import numpy as np

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.identification.identify import identify
from exogauge.identification.prior import inertial_std
from exogauge.identification.ranges import possible_parameters
from exogauge.identification.settings import Recording, Settings
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


def body_as_believed(rng, phi, std):
    """All ten numbers as far off as is believed; what no body has is drawn anew."""
    while not is_physical(body := phi + std * rng.standard_normal(10)):
        pass
    return body


def test_the_doubt_that_is_stated_holds_where_links_must_be_possible(make_truth, make_log):
    """Hardly shaken: what is not seen hangs on what is believed, which has to be the same for doubt and value."""
    z = []
    for seed in range(4):
        truth, rng = make_truth(False, seed=seed, actuation="torque"), np.random.default_rng(seed)
        believed = zip(truth.robot.tree.phi, inertial_std(truth.robot), strict=True)
        truth.phi = np.array([body_as_believed(rng, *each) for each in believed])
        log = make_log(truth, seed, seconds=12.0, noise=1.0, pause=False, fastest=0.3)
        found = identify(truth.robot, [Recording(log, False)], Settings(cutoff_hz=5.0, prior_strength=1.0))
        names = [each.name for each in found.parameters][: truth.phi.size]
        true = dict(zip(names, truth.phi.ravel(), strict=True))
        for each in found.parameters:
            if each.combination:
                value = sum(factor * true[name] for name, factor in each.combination.items())
                z.append((each.value - value) / each.std)
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.3
