"""A log is known again by its joints' angles: where the plan begins, how far it strays, and when nobody can say."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.criteria.following import Following
from exogauge.logs.followed import PlannedSeries, followed
from exogauge.logs.model import Log

RULES = Following()
SECONDS = 8.0


def plan(seed: int, name: str = "bend", seconds: float = SECONDS) -> PlannedSeries:
    """Three joints on sums of sines, out of rest and back; `still` stays."""
    rng, t = np.random.default_rng(seed), np.arange(round(seconds * 200) + 1) / 200.0
    window = np.sin(np.pi * t / seconds) ** 2
    low, high = np.array([0.1, 0.1, 0.0])[:, None], np.array([0.4, 0.7, 6.0])[:, None]  # rad, Hz, rad
    q = {}
    for k in range(3):
        waves = zip(*rng.uniform(low, high, (3, 4)), strict=True)
        q[f"j{k}"] = window * sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in waves)
    return PlannedSeries(name, t, q | {"still": np.full(t.size, 0.3)})


def log_of(
    given: PlannedSeries,
    begins_s: float,
    seconds: float,
    rate: float = 200.0,
    delays: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> Log:
    """Its joints as they follow; before and after they stand. The clock begins at 100 s."""
    t = np.arange(round(seconds * rate) + 1) / rate
    q = {
        f"q.{name}": np.interp(t - begins_s - late, given.time, values)
        for (name, values), late in zip(given.q.items(), (*delays, 0.0), strict=True)
    }
    return Log("run", 100.0 + t, q)


@pytest.mark.parametrize("begins", [2.345, 0.0, -0.8])
def test_a_plan_is_found_where_it_begins(begins: float) -> None:
    found = followed(log_of(plan(1), begins, 12.0), [plan(2, "other"), plan(1)], RULES)
    assert found is not None
    assert (found.sure, found.match.plan, found.log) == (True, 1, "run")
    assert found.match.begins_s == pytest.approx(100.0 + begins, abs=1e-4)
    assert found.match.covered == pytest.approx(1.0 + min(begins, 0.0) / SECONDS, abs=0.01)
    assert max(each.most for each in found.match.strays) < 1e-3


def test_how_far_a_joint_strays_is_told_with_its_moment() -> None:
    log = log_of(plan(1), 1.0, 10.0)
    away = 0.05 * np.exp(-(((log.time - 104.5) / 0.1) ** 2))
    strays = log.channels["q.j1"] + away
    found = followed(Log("run", log.time, {**log.channels, "q.j1": strays}), [plan(1)], RULES)
    assert found is not None
    of = {each.joint: each for each in found.match.strays}
    assert of["j1"].most == pytest.approx(0.05, rel=0.02)
    assert of["j1"].at_s == pytest.approx(104.5, abs=0.02)
    assert of["j1"].rms == pytest.approx(np.sqrt(np.mean(away[200:1801] ** 2)), rel=0.05)
    assert of["j0"].most < 1e-3
    assert np.isnan(of["still"].later_s)


def test_a_joint_that_is_late_is_told_by_how_much() -> None:
    found = followed(log_of(plan(1), 1.0, 10.0, delays=(0.0, 0.0, 0.03)), [plan(1)], RULES)
    assert found is not None
    late = {each.joint: each.later_s for each in found.match.strays}
    assert late["j2"] - late["j0"] == pytest.approx(0.03, rel=0.05)
    assert late["j1"] == pytest.approx(late["j0"], abs=1e-3)


@pytest.mark.parametrize("seed", range(3, 13))
def test_a_log_of_something_else_is_of_no_plan(seed: int) -> None:
    found = followed(log_of(plan(seed), 1.0, 10.0), [plan(1), plan(2)], RULES)
    assert found is None or not found.sure


def test_a_log_between_two_plans_is_left_undecided() -> None:
    one = plan(1)
    two = PlannedSeries("share", one.time, {name: 0.97 * values for name, values in one.q.items()})
    middle = PlannedSeries("run", one.time, {name: 0.985 * values for name, values in one.q.items()})
    found = followed(log_of(middle, 1.0, 10.0), [one, two], RULES)
    assert found is not None
    assert not found.sure
    assert {found.match.plan, *found.rivals} == {0, 1}
    near = PlannedSeries("run", one.time, {name: 0.995 * values for name, values in one.q.items()})
    sure = followed(log_of(near, 1.0, 10.0), [one, two], RULES)
    assert sure is not None
    assert (sure.sure, sure.match.plan) == (True, 0)


def test_half_of_a_plan_is_not_the_plan() -> None:
    assert followed(log_of(plan(1), 0.0, 4.0), [plan(1)], RULES) is None


def test_a_plan_of_other_joints_or_without_motion_is_of_no_log() -> None:
    one = plan(1)
    others = PlannedSeries("arm", one.time, {f"arm_{name}": values for name, values in one.q.items()})
    rests = PlannedSeries("rest", one.time, {name: values * 0.0 for name, values in one.q.items()})
    assert followed(log_of(one, 1.0, 10.0), [others, rests], RULES) is None


def test_another_rate_and_a_clock_that_jitters_do_no_harm() -> None:
    log = log_of(plan(1), 1.5, 11.0, rate=62.5)
    jittered = Log("run", log.time + np.random.default_rng(0).uniform(0.0, 0.002, log.samples), log.channels)
    found = followed(jittered, [plan(1)], RULES)
    assert found is not None
    assert found.sure
    assert found.match.begins_s == pytest.approx(101.5, abs=5e-3)
