"""What would have to give where a motion cannot be had: how much slower, or how much less of the trunk's angle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.errors import BadMotion
from exogauge.motion.plan.asked import Asked, rows_of
from exogauge.motion.plan.at_rest import at_home
from exogauge.motion.plan.within import plan_within
from exogauge.robots.moving.robot import MotionRobot

Tried = Callable[[str, float, int, bool], None]
"""What was changed, by how much, on how many nodes it was planned, and whether it holds."""


@final
@dataclass(frozen=True)
class Possible:
    """slower: the least number of times the time, to `within`; share: of the trunk's angle, at the time asked. None:
    not with `slowest` times the time nor with its root, not with the trunk still."""

    slower: float | None
    share: float | None


Again = Callable[[float, float], tuple[Asked, MotionPlan]]
"""What is planned where the same is asked in so many times the time, with that share of the trunk's angle."""


def paced(criteria: MotionPlan, slow: float, rate: float) -> MotionPlan:
    """A motion that takes `slow` times the time has its nodes as much further apart, as many for the same way; what
    lies between them is judged. So it costs no more, and is planned alike whoever asks for it.

    rate: [Hz] at which it is written: every node is a row of its table, so that the cubic through the rows is the plan
    itself. With nodes between rows its jerk rang to 119 % of what the plan keeps."""
    k = max(slow, 1.0)
    nodes = criteria.nodes_per_s / k
    nodes = rate / rows_of(1.0 / nodes, rate) if rate > nodes else nodes  # fewer rows than nodes hold no plan
    return replace(criteria, nodes_per_s=nodes, stretch_s=k * criteria.stretch_s, ahead_s=k * criteria.ahead_s)


def what_would_do(
    robot: MotionRobot, criteria: MotionPlan, again: Again, rate: float | None = None, tried: Tried | None = None
) -> Possible | None:
    """Both by bisection, each step the very plan that comes of asking for it, but that it ends where its first stretch
    exceeds a bound. rate: [Hz] at which it is judged. Each begins at home, at rest: what is lacking there none can
    have, and another home is what would do: None then."""
    if at_home(robot, criteria).lacks:
        return None

    def holds(what: str, value: float, asked: Asked, own: MotionPlan) -> bool:
        found = kept(robot, asked, own, rate)
        if tried is not None:
            tried(what, value, len(asked.q), found)
        return found

    slower = nearest(lambda k: holds("slower", k, *again(k, 1.0)), 1.0, criteria.slowest, criteria.within,
                     round(criteria.slowest**0.5, 2))  # fmt: skip
    share = nearest(lambda k: holds("share", k, *again(1.0, k)), 1.0, 0.0, criteria.within)
    return Possible(slower, share)


def kept(robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, rate: float | None = None) -> bool:
    """Whether what is asked can be planned within every bound."""
    try:
        _, judged, _ = plan_within(
            robot, asked, criteria, rate=rate,
            stop=lambda made: bool(made.unsettled) or made.excess.max() > criteria.over,
        )  # fmt: skip
    except BadMotion:
        return False
    return not judged.broken


def nearest(
    holds: Callable[[float], bool], wanted: float, safe: float, within: float, else_: float | None = None
) -> float | None:
    """The value nearest to `wanted`, where it does not hold, at which it does, found between there and `safe`, or
    `else_` where that does not hold: what is tried has two decimals, as it is told with no more.

    Much slower is not always easier: the body sways farther over one foot, and between nodes as much further apart a
    foot that stands moved by .15 mm, where JVRC-1 raises a knee in four times the time; in twice the time it is still.
    """
    if not holds(safe):
        return None if else_ is None else nearest(holds, wanted, else_, within)
    while abs(safe - wanted) > within:
        middle = round(0.5 * (safe + wanted), 2)
        if holds(middle):
            safe = middle
        else:
            wanted = middle
    return safe
