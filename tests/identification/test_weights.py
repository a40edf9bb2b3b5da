"""Rows count with the inverse variance of what they leave."""

import numpy as np

from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.solution import weigh


def test_weights_become_the_inverse_variances_of_the_rows():
    rng = np.random.default_rng(0)
    truth, stds = rng.normal(size=8), (5.0, 0.5, 0.05)
    statistics = Statistics.empty(8, [np.arange(8)] * 4)
    for kind, std in enumerate((*stds, 1.0)):
        A = rng.normal(size=(4000, 8))
        statistics.add_rows(kind, np.asfortranarray(np.column_stack([A, A @ truth + std * rng.normal(size=4000)])))
    prior = Prior(np.zeros(8), np.full(8, 10.0), np.eye(8))
    weights = weigh(statistics, prior, 1.0, np.array([1.0, 1.0, 1.0, 0.0]))
    np.testing.assert_allclose(1.0 / np.sqrt(weights[:3]), stds, rtol=0.05)
    assert weights[3] == 0.0  # what does not count is not brought back


def test_rows_without_noise_do_not_count_infinitely():
    rng = np.random.default_rng(0)
    A = rng.normal(size=(200, 4))
    statistics = Statistics.empty(4, [np.arange(4)])
    statistics.add_rows(0, np.asfortranarray(np.column_stack([A, A @ np.ones(4)])))
    weights = weigh(statistics, Prior(np.zeros(4), np.ones(4), np.eye(4)), 1.0, np.ones(1))
    assert np.isfinite(weights).all()
