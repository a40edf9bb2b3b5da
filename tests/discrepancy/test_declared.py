"""What a foot's sensor has wrong no further than it was declared to is not unexplained; beyond, or elsewhere, it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.discrepancy.test_feet import Wrong, on_two_plates, robot  # noqa: F401
from tests.discrepancy.test_sensor_effects import SEEDS, searched

from exogauge.findings.result import WithinDeclared
from exogauge.findings.verdict import Why
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.progress import unwatched
from exogauge.robots.description import Declared, Robot
from exogauge.search.afterwards import odd_logs
from exogauge.search.baseline import lay_ground
from exogauge.search.declared import within_declared
from exogauge.search.locate import located
from exogauge.search.search import searched as searched_for
from exogauge.search.state import Problem

DECLARED = Declared(ft_zero_force=2.0, ft_zero_moment=0.2)


def pushed(newtons: float) -> Wrong:
    return lambda _t, read: read + np.array([newtons, 0.0, 0.0, 0.0, 0.0, 0.0])


def swinging(newtons: float) -> Wrong:
    def read(t: np.ndarray, w: np.ndarray) -> np.ndarray:
        return w + np.outer(np.sin(1.7 * t), [newtons, 0.0, 0.0, 0.0, 0.0, 0.0])

    return read


def above(robot: Robot, wrong: Wrong) -> tuple[set[str], WithinDeclared]:  # noqa: F811
    logs = [on_two_plates(seed, {"left": wrong}) for seed in SEEDS]
    recordings = [Recording(log, held_out=number == len(logs) - 1) for number, log in enumerate(logs)]
    found = identify(robot, recordings, Settings())
    excesses = located(found.model.equations, found, lay_ground(found.model, recordings, (), unwatched).residuals)
    return {each.channel for each in excesses}, within_declared(found.model, recordings, excesses)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("declared", "wrong", "within"),
    [
        (DECLARED, pushed(3.0), True),
        (Declared(), pushed(3.0), False),  # of a robot that is said to be exact
        (DECLARED, pushed(20.0), False),  # ten times what is declared
        (DECLARED, swinging(3.0), False),  # no zero does that
    ],
)
def test_only_what_declared_inputs_can_do_is_within_them(
    robot: Robot,  # noqa: F811
    declared: Declared,
    wrong: Wrong,
    within: bool,
) -> None:
    seen, found = above(replace(robot, declared=declared), wrong)
    assert "base.fx" in seen
    assert ("base.fx" in {each.channel for each in found.channels}) == within
    if within:
        assert found.sources == ("ft_zero",)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("declared", "newtons", "named"),
    [(DECLARED, 3.0, []), (Declared(), 3.0, ["ft_zero"]), (DECLARED, 20.0, ["ft_zero"])],
)
def test_what_declared_uncertainties_explain_gets_no_name(
    robot: Robot,  # noqa: F811
    declared: Declared,
    newtons: float,
    named: list[str],
) -> None:
    logs = [on_two_plates(seed, {"left": pushed(newtons)}) for seed in SEEDS]
    found = searched(replace(robot, declared=declared), logs).discrepancy
    assert [each.effect for each in found.findings] == named
    assert found.verdict == ("effects" if named else "undecided")
    if not named:
        assert any(each.effect == "ft_zero" and each.objection.why is Why.DECLARED for each in found.rejected)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("declared", "newtons", "asked"), [(DECLARED, 3.0, False), (Declared(), 3.0, True), (DECLARED, 20.0, True)]
)
def test_a_log_whose_zero_is_off_as_declared_is_no_odd_one(
    robot: Robot,  # noqa: F811
    declared: Declared,
    newtons: float,
    asked: bool,
) -> None:
    """Every such log is searched once more as if it were fitted, which takes as long as a whole search."""
    logs = [on_two_plates(seed) for seed in SEEDS[:-1]] + [on_two_plates(SEEDS[-1], {"left": pushed(newtons)})]
    recordings = [Recording(log, held_out=number == len(logs) - 1) for number, log in enumerate(logs)]
    found = identify(replace(robot, declared=declared), recordings, Settings())
    nothing_named = searched_for(Problem(found, recordings, (), Settings()))
    assert [each.log.name for each in odd_logs(nothing_named)] == ([logs[-1].name] if asked else [])


STICKING_BELOW = 0.35  # [rad/s], about half of the speed with which the arm moves


def sticking(log: Log) -> Log:
    """Joint a rubs more at low speed."""
    v = np.gradient(log.channels["q.a"], log.time)
    peak = 1.5 * np.sign(v) * np.exp(-np.abs(v) / STICKING_BELOW)
    return replace(log, channels={**log.channels, "tau.a": log.channels["tau.a"] + peak})


@pytest.mark.slow
def test_feet_that_are_off_as_declared_do_not_hide_what_a_joint_lacks(robot: Robot) -> None:  # noqa: F811
    """They touch many rows, so that each of their effects outweighs the joint's own."""
    zeros = np.random.default_rng(5).standard_normal((len(SEEDS), 2, 6)) * np.repeat([2.0, 0.2], 3)
    logs = [
        sticking(on_two_plates(seed, {"left": lambda _t, w, z=left: w + z, "right": lambda _t, w, z=right: w + z}))
        for seed, (left, right) in zip(SEEDS, zeros, strict=True)
    ]
    found = searched(replace(robot, declared=DECLARED), logs).discrepancy
    assert [(each.effect, each.place.name) for each in found.findings] == [("stribeck", "a")]
