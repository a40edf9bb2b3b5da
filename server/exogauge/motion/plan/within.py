"""A plan that keeps its bounds between the nodes too: where it does not, once more with more kept for there."""

from __future__ import annotations

from dataclasses import replace

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.solve import Planned, Report, plan
from exogauge.robots.moving.robot import MotionRobot


def plan_within(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, report: Report | None = None,
    rate: float | None = None,
) -> tuple[Planned, Judged]:  # fmt: skip
    """Planned and judged at `rate` [Hz]. Of two plans that both break a bound, the one that breaks fewer."""
    planned = plan(robot, asked, criteria, report)
    judged = judge(robot, planned.spline, asked.place[0], criteria, rate, planned)
    if not judged.broken or float(planned.excess.max()) > criteria.over:
        return planned, judged
    stricter = replace(
        criteria, kept=criteria.kept - criteria.more_kept, margin_m=criteria.margin_m + criteria.more_m
    )  # fmt: skip
    if judged.apart.min() < criteria.clearance_m:
        stricter = replace(stricter, apart_m=criteria.apart_m + criteria.more_m)
    again = plan(robot, asked, stricter, report)
    found = judge(robot, again.spline, asked.place[0], criteria, rate, again)
    return (again, found) if len(found.broken) < len(judged.broken) else (planned, judged)
