"""How strong the prior is: what is left out decides, and where it does not, the maker."""

import numpy as np

from exogauge.criteria.identifying import Identifying
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.solution import Folds, choose_strength

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


def test_parts_beyond_the_most_are_left_out_together_and_none_is_lost():
    rng = np.random.default_rng(0)
    made = folds_of(rng, rng.normal(size=4), noise=0.1, folds=11)
    folds = Folds(len(made), most=4)
    for first in range(0, len(made), 3):
        folds.add(made[first : first + 3])
    assert [part.count[0] for part in folds.parts] == [36, 36, 36, 24]
    np.testing.assert_array_equal(folds.total.store[0], sum(made[1:], made[0]).store[0])  # in the order of the logs
    np.testing.assert_allclose(sum(folds.parts[1:], folds.parts[0]).store[0], folds.total.store[0], rtol=1e-12)
    alone = Folds(4, most=4)
    alone.add(made[:4])
    assert [id(part) for part in alone.parts] == [id(part) for part in made[:4]]
