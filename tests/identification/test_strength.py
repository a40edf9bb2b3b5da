"""How strong the prior is: what is left out decides, and where it does not, the maker."""

import numpy as np

from exogauge.criteria.identifying import Identifying
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.solution import choose_strength

ASKED = ("per_parameter", Identifying())


def folds_of(rng, truth, noise, folds=6, rows=12):
    made = [Statistics.empty(len(truth), [np.arange(len(truth))]) for _ in range(folds)]
    for fold in made:
        A = rng.normal(size=(rows, len(truth)))
        fold.add_rows(0, np.asfortranarray(np.column_stack([A, A @ truth + noise * rng.normal(size=rows)])))
    return made


def test_a_prior_that_is_true_is_not_weakened():
    rng = np.random.default_rng(0)
    truth = rng.normal(size=30)
    prior = Prior(truth, np.full(30, 0.3), np.eye(30))
    strength, curve = choose_strength(
        folds_of(rng, truth, noise=1.0), np.ones(1), prior, "per_parameter", Identifying()
    )
    score = dict(curve)
    assert strength >= 1.0
    assert score[100.0] < score[0.01]


def test_a_prior_that_is_wrong_and_sure_of_it_is_weakened():
    rng = np.random.default_rng(0)
    truth = rng.normal(size=30)
    prior = Prior(truth + rng.normal(size=30), np.full(30, 0.02), np.eye(30))
    strength, _ = choose_strength(folds_of(rng, truth, noise=0.1), np.ones(1), prior, *ASKED)
    assert strength < 1.0


def test_where_the_strength_does_not_matter_the_makers_word_counts():
    rng = np.random.default_rng(0)
    truth = rng.normal(size=5)
    prior = Prior(truth + 0.1, np.full(5, 1.0), np.eye(5))
    strength, _ = choose_strength(
        folds_of(rng, truth, noise=0.1, rows=500), np.ones(1), prior, "per_parameter", Identifying()
    )
    assert strength == 1.0
