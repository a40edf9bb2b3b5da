"""The cut-off explains most of what was left out, is the lowest of those alike, and never takes most of a motion."""

import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from exogauge.errors import NotIdentifiable
from exogauge.identification.bandwidth import LOWEST_HZ, Keeps, Trial, choose_cutoff, noise_of_acceleration
from exogauge.identification.identify import identify
from exogauge.identification.preparation import prepare, suggested_cutoffs
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.turns import rest_detection
from exogauge.remarks import About
from exogauge.side_by_side import CORES

Tried = partial(Trial, keeps=Keeps.BOTH)


def kept(fitted, judged=True):
    """By a cut-off, of the motion of the log that is fitted, and of the one that judges."""
    return Keeps(fitted + (fitted and judged))


@pytest.fixture
def robot_and_log(make_truth, make_log):
    truth = make_truth(False)
    log = make_log(truth, seed=1, seconds=10.0, noise=0.05)
    return truth.robot, log, suggested_cutoffs(truth.robot, [log])[0]


def test_of_cutoffs_that_explain_alike_the_lowest_is_taken(robot_and_log, monkeypatch):
    monkeypatch.setenv(CORES, "1")  # more of them look ahead
    robot, log, first = robot_and_log
    tried = []

    def trial(_, cutoff_hz):
        tried.append(cutoff_hz)
        return Tried(0.0 if cutoff_hz > 0.4 * first else 1.0)

    assert choose_cutoff(robot, [log], log.rate_hz, trial) == first / 2
    assert tried[:3] == [first, first / 2, first / 4]  # and no lower one, once that made it worse
    assert len(tried) == 4  # one step up, which gained nothing


def test_the_fast_log_says_what_serves_and_not_a_longer_calm_one_nor_a_snippet(make_truth, make_log):
    """A calm log of 15 s, a usual one of 10 s and one of 3 s that is faster still."""
    truth = make_truth(False)
    calm, usual, snippet = (
        make_log(truth, seed=seed, seconds=seconds, noise=0.05, fastest=fastest)
        for seed, seconds, fastest in ((1, 15.0, 0.1), (2, 10.0, 0.8), (3, 3.0, 1.6))
    )
    asked = set()

    def trial(log, cutoff_hz):
        asked.add(log.name)
        return Tried(0.0)

    choose_cutoff(truth.robot, [calm, usual, snippet], usual.rate_hz, trial)
    assert asked == {usual.name}


@pytest.mark.parametrize("left", [lambda x: abs(x), lambda x: -x, lambda x: x, lambda x: 0.0, lambda x: np.inf])
def test_what_was_tried_ahead_decides_nothing(robot_and_log, monkeypatch, left):
    """A trial that one processor would not have begun may look as good as it likes."""
    robot, log, first = robot_and_log

    def taken(cores):
        monkeypatch.setenv(CORES, cores)
        begun, said = [], []

        def trial(_, hz):
            begun.append(hz)
            time.sleep(0.01)
            return Tried(float(left(np.log2(hz / first))))

        said.append(choose_cutoff(robot, [log], log.rate_hz, trial))
        return said, begun

    (one, few), (other, many) = taken("1"), taken("4")
    assert one == other
    assert set(few) <= set(many)


def test_a_cutoff_that_explains_more_is_not_given_up_for_a_lower_one(robot_and_log):
    robot, log, first = robot_and_log
    best = 2.0 * first
    found = choose_cutoff(robot, [log], log.rate_hz, lambda _, hz: Tried(float(abs(np.log(best / hz)))))
    assert found == pytest.approx(min(best, 0.2 * log.rate_hz))


def test_a_cutoff_whose_accelerations_are_drowned_in_noise_is_not_taken_though_it_explains_more(robot_and_log):
    robot, log, first = robot_and_log

    def trial(_, hz):
        return Tried(-float(np.log(hz)), quiet=hz < 1.5 * first)

    assert choose_cutoff(robot, [log], log.rate_hz, trial) == first
    found = choose_cutoff(robot, [log], log.rate_hz, lambda _, hz: Tried(-float(np.log(hz)), quiet=False))
    assert found == pytest.approx(0.2 * log.rate_hz)  # where all are noisy, none is refused for it


def test_a_cutoff_at_which_most_accelerations_are_noise_is_not_taken_though_only_it_keeps_most(robot_and_log):
    robot, log, first = robot_and_log

    def trial(_, hz):
        fast = hz > 1.5 * first
        return Trial(-float(np.log(hz)), kept(fast), quiet=False, noise=fast)

    assert choose_cutoff(robot, [log], log.rate_hz, trial) == first


def test_the_share_of_an_acceleration_that_is_noise_is_told(make_truth, make_log):
    robot = make_truth(False).robot
    clean = make_log(make_truth(False), seed=1, seconds=20.0, noise=0.0)
    std, random = 3e-4, np.random.default_rng(1)
    noise = {f"q.{each.name}": std * random.standard_normal(clean.samples) for each in robot.joints}
    noisy = replace(clean, channels={k: v + noise.get(k, 0.0) for k, v in clean.channels.items()})
    at_rest = rest_detection(robot, [noisy], 10.0)
    ready, true = (prepare(robot, each, 10.0, at_rest) for each in (noisy, clean))
    inside = ready.steady & ready.settled[:, None]
    change = np.mean((ready.axis_acceleration - true.axis_acceleration) ** 2, axis=0, where=inside)
    expected = change / np.mean(ready.axis_acceleration**2, axis=0, where=inside)
    assert noise_of_acceleration(robot, ready) == pytest.approx(expected, rel=0.25)
    assert noise_of_acceleration(robot, true).max() < 1e-3 * expected.min()


def test_a_cutoff_at_which_turns_take_most_of_a_motion_is_not_taken(robot_and_log):
    robot, log, first = robot_and_log
    found = choose_cutoff(robot, [log], log.rate_hz, lambda _, hz: Trial(0.0, kept(hz > 1.5 * first)))
    assert found == pytest.approx(min(2.0 * first, 0.2 * log.rate_hz))


def test_a_cutoff_at_which_turns_take_most_of_what_judges_is_not_taken(robot_and_log):
    robot, log, first = robot_and_log
    found = choose_cutoff(robot, [log], log.rate_hz, lambda _, hz: Trial(0.0, kept(hz > 0.7 * first, hz > 1.5 * first)))
    assert found == pytest.approx(min(2.0 * first, 0.2 * log.rate_hz))


def test_where_nothing_lets_judge_the_fitted_motion_decides(robot_and_log):
    robot, log, first = robot_and_log
    assert choose_cutoff(robot, [log], log.rate_hz, lambda _, hz: Trial(0.0, kept(hz > 0.7 * first, False))) == first


def test_where_no_row_is_left_a_higher_cutoff_is_sought(robot_and_log):
    robot, log, first = robot_and_log

    def trial(_, hz):
        if hz < 1.5 * first:
            raise NotIdentifiable("nothing moves steadily")
        return Tried(0.0)

    assert choose_cutoff(robot, [log], log.rate_hz, trial) == pytest.approx(min(2.0 * first, 0.2 * log.rate_hz))


def test_the_search_goes_on_upwards_past_fits_that_keep_no_motion(robot_and_log):
    """Legs that squat slowly ended at 0.5 Hz, with nothing in steady motion: fits of a few rows are no comparison."""
    robot, log, _ = robot_and_log
    slow = {
        name: np.sin(0.6 * log.time) + 1e-3 * np.random.default_rng(1).standard_normal(log.samples)
        for name in log.channels
        if name.startswith("q.")
    }
    slow_log = replace(log, channels={**log.channels, **slow})
    first = suggested_cutoffs(robot, [slow_log])[0]

    def trial(_, hz):
        if hz > 3.0 * first:
            return Tried(-3.1)
        return Trial(-2.0 if hz < 1.5 * first else -1.7, Keeps.NEITHER)

    assert choose_cutoff(robot, [slow_log], log.rate_hz, trial) == pytest.approx(4.0 * first)


def test_the_search_for_a_cutoff_ends_between_what_bodies_move_at_and_what_the_slowest_log_bears(robot_and_log):
    robot, log, _ = robot_and_log
    assert choose_cutoff(robot, [log], log.rate_hz, lambda _, hz: Tried(0.0)) >= LOWEST_HZ
    assert choose_cutoff(robot, [log], 20.0, lambda _, hz: Tried(-hz)) <= 8.0


def test_a_slow_periodic_motion_keeps_most_of_it_for_the_fit(make_truth, make_log):
    """Positions of 0.1 Hz bear 2 Hz of bandwidth, behind which turns leave next to nothing."""
    truth = make_truth(False, actuation="torque")
    logs = [make_log(truth, seed=seed, seconds=24.0, fastest=0.25) for seed in (1, 2)]
    found = identify(truth.robot, [Recording(logs[0], False), Recording(logs[1], True)], Settings())
    for each in found.steady:
        assert each.fitted_s > 0.5 * each.fitted_of_s
        assert each.both_directions
    assert not {each.about for each in found.remarks} & {About.LITTLE_STEADY, About.ONE_DIRECTION}
