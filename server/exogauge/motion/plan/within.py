"""A plan that keeps its bounds between the nodes too: where it does not, once more with more kept for there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.motion.plan.asked import Asked, on_its_feet
from exogauge.motion.plan.at_rest import AtRest, at_home
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.solve import Planned, Report, Stop, plan
from exogauge.motion.plan.spline import through
from exogauge.robots.moving.robot import MotionRobot


def plan_within(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, report: Report | None = None,
    rate: float | None = None, stop: Stop | None = None,
) -> tuple[Planned, Judged]:  # fmt: skip
    """Planned and judged at `rate` [Hz]. Of two plans that both break a bound, the one that breaks fewer.

    Where the robot cannot even stand at home nothing is planned, and what is asked is judged. stop: as of `plan`.
    """
    rest = at_home(robot, criteria)
    if rest.hopeless:
        return _as_asked(robot, asked, criteria, rate, rest)
    planned = plan(robot, asked, criteria, report, stop)
    judged = judge(robot, planned.spline, asked.place[0], criteria, rate, planned)
    if not judged.broken or planned.unsettled or float(planned.excess.max()) > criteria.over:
        return planned, _with_unsettled(planned, judged)
    stricter = replace(
        criteria, kept=criteria.kept - criteria.more_kept, margin_m=criteria.margin_m + criteria.more_m
    )  # fmt: skip
    if judged.apart.min() < criteria.clearance_m:
        stricter = replace(stricter, apart_m=criteria.apart_m + criteria.more_m)
    again = plan(robot, asked, stricter, report, stop)
    found = judge(robot, again.spline, asked.place[0], criteria, rate, again)
    if len(found.broken) < len(judged.broken):
        return again, _with_unsettled(again, found)
    return planned, judged


def _with_unsettled(planned: Planned, judged: Judged) -> Judged:
    """Where something is broken: in which stretches no plan was found, which is why."""
    if not judged.broken:
        return judged
    lines = [f"no plan that keeps every bound was found from {a:.2f} to {b:.2f} s; what follows is of the nearest"
             for a, b in planned.unsettled]  # fmt: skip
    return replace(judged, broken=(*lines, *judged.broken))


def _as_asked(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan, rate: float | None, rest: AtRest
) -> tuple[Planned, Judged]:
    """What is asked, on its feet as far as they reach, as if it had been planned."""
    begin = asked.q.copy()
    begin[:, robot.base :] = np.clip(begin[:, robot.base :], robot.limits.lower, robot.limits.upper)
    q = np.stack([on_its_feet(robot, *each) for each in zip(begin, asked.place, strict=True)])
    N = len(q)
    none = np.zeros((N, len(robot.soles), 6))
    whole = ((0.0, float(asked.time[-1])),)
    planned = Planned(through(q, asked.step), none, np.full(N, rest.excess), 0, np.inf, whole, asked.stands)
    judged = judge(robot, planned.spline, asked.place[0], criteria, rate, planned)
    lines = (str(rest), "nothing was planned for that reason; what follows is of the motion as it is asked")
    return planned, replace(judged, broken=(*lines, *judged.broken))
