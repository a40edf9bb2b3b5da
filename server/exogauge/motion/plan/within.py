"""A plan that keeps its bounds between the nodes too: where it does not, once more with more kept for there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.errors import BadMotion
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.at_rest import AtRest, at_home
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.solve import Planned, Report, Stop, plan
from exogauge.motion.plan.spline import through
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing


def plan_within(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, report: Report | None = None,
    rate: float | None = None, stop: Stop | None = None,
) -> tuple[Planned, Judged]:  # fmt: skip
    """Planned and judged at `rate` [Hz]; where the legs bear it only as the feet share the load in the plan, once more
    with feet that share evenly. Of two plans that both break a bound, the one that breaks fewer.

    Where the robot cannot even stand at home no motion keeps its bounds: nothing is planned, what is lacking is told
    first, and standing at home is judged. stop: as of `plan`; a plan that is there already is not lost by it.

    Raises BadMotion where the first plan does.
    """
    rest = at_home(robot, criteria)
    if rest.lacks:
        return _at_home(robot, asked, criteria, rate, rest)
    planned = plan(robot, asked, criteria, report, stop)
    judged = _judged(robot, asked, planned, criteria, rate)
    uneven = judged.evenly > 1.0
    if not (judged.broken or uneven) or planned.unsettled or float(planned.excess.max()) > criteria.over:
        return planned, _with_reasons(planned, judged, rest)
    stricter = criteria
    if judged.broken:
        stricter = replace(
            stricter, kept=criteria.kept - criteria.more_kept, margin_m=criteria.margin_m + criteria.more_m
        )  # fmt: skip
    if judged.apart.min() < criteria.clearance_m:
        stricter = replace(stricter, apart_m=criteria.apart_m + criteria.more_m)
    if judged.least_inside is not None and judged.least_inside < criteria.inside_m:
        stricter = replace(stricter, calm=criteria.calmer)
    best = planned, judged
    for wrench in criteria.evenly if uneven else (criteria.wrench,):
        try:
            again = plan(robot, asked, replace(stricter, wrench=wrench), report, stop)
        except BadMotion:  # none is found, or it is stopped: that which there is stays
            continue
        best = min(best, (again, _judged(robot, asked, again, criteria, rate)), key=_breaks)
        if _breaks(best) == (0, 1.0):
            break
    return best[0], _with_reasons(*best, rest)


def _breaks(found: tuple[Planned, Judged]) -> tuple[int, float]:
    """Bounds, and how far beyond its own a leg's torque is where the feet share the load evenly."""
    return len(found[1].broken), max(1.0, found[1].evenly)


def _judged(robot: MotionRobot, asked: Asked, planned: Planned, criteria: MotionPlan, rate: float | None) -> Judged:
    """Where it begins and ends is looked at too: a robot at home would jump there. So is what the legs bear where the
    feet share the load evenly, as a table of the motion has them."""
    judged = judge(robot, planned.spline, asked.place[0], criteria, rate, planned)
    alone = replace(planned, wrench=np.zeros_like(planned.wrench))
    even = judge(robot, planned.spline, asked.place[0], criteria, rate, alone)
    legs = np.concatenate([robot.leg(foot) for foot in range(len(robot.soles))]) - robot.base
    share = np.abs(even.torque[:, legs]) / robot.limits.torque[legs]
    judged = replace(judged, evenly=float(share.max()))
    ends = planned.spline.at(np.array([0.0, planned.spline.duration]))[0]
    lines = list[str]()
    for what, posture, home in zip(("begins", "ends"), ends, asked.q[[0, -1]], strict=True):
        aside = np.abs(posture - home)[robot.base :]
        if aside.max() > criteria.aside:
            lines.append(f"the motion {what} beside home: {robot.joints[aside.argmax()]} by {aside.max():.3g}, at most "
                         f"{criteria.aside:g} is asked")  # fmt: skip
    return replace(judged, broken=(*lines, *judged.broken))


def _with_reasons(planned: Planned, judged: Judged, rest: AtRest) -> Judged:
    """Where something is broken: what home itself hardly bears, in which stretches no plan was found."""
    if not judged.broken:
        return judged
    home = [str(rest)] if rest.excess > 0.0 and rest.needs > rest.bears else []
    lines = [f"no plan that keeps every bound was found from {a:.2f} to {b:.2f} s; what follows is of the nearest"
             for a, b in planned.unsettled]  # fmt: skip
    return replace(judged, broken=(*home, *lines, *judged.broken))


def _at_home(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan, rate: float | None, rest: AtRest
) -> tuple[Planned, Judged]:
    """Home throughout: what is asked is no motion before it is planned, so that its forces say nothing."""
    N = len(asked.q)
    none = np.zeros((N, len(robot.soles), 6))
    whole = ((0.0, float(asked.time[-1])),)
    spline = through(np.tile(asked.q[0], (N, 1)), asked.step)
    planned = Planned(spline, none, np.full(N, rest.excess), 0, np.inf, whole)
    judged = judge(robot, spline, standing(robot), criteria, rate, planned)
    lines = (str(rest), "nothing was planned for that reason; what follows is of standing still at home")
    return planned, replace(judged, broken=(*lines, *judged.broken))
