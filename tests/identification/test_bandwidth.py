"""The cut-off that explains most, and the lowest of those that explain alike."""

import numpy as np

from exogauge.identification.bandwidth import LOWEST_HZ, choose_cutoff
from exogauge.identification.preparation import suggested_cutoff


def test_of_cutoffs_that_explain_alike_the_lowest_is_taken(make_truth, make_log):
    truth = make_truth(False)
    log = make_log(truth, seed=1, seconds=10.0)
    first = suggested_cutoff(truth.robot, [log])
    tried = []

    def unexplained(_, cutoff_hz):
        tried.append(cutoff_hz)
        return 0.0 if cutoff_hz > 0.2 * first else 1.0

    assert choose_cutoff(truth.robot, [log], unexplained) == first / 4
    assert tried == [first, first / 2, first / 4, first / 8]  # and none after that made it worse


def test_a_cutoff_that_explains_more_is_not_given_up_for_a_lower_one(make_truth, make_log):
    truth = make_truth(False)
    log = make_log(truth, seed=1, seconds=10.0)
    first = suggested_cutoff(truth.robot, [log])
    assert choose_cutoff(truth.robot, [log], lambda _, hz: float(np.log(first / hz))) == first


def test_the_search_for_a_cutoff_ends_above_what_bodies_move_at(make_truth, make_log):
    truth = make_truth(False)
    log = make_log(truth, seed=1, seconds=10.0)
    assert choose_cutoff(truth.robot, [log], lambda _, hz: 0.0) >= LOWEST_HZ
