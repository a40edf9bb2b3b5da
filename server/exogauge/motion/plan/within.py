"""A plan that keeps its bounds between the nodes too, and by its table: where it does not, anew with more kept."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import HALF_FOOT_M, USUAL, MotionPlan
from exogauge.errors import BadMotion
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.at_rest import AtRest, at_home
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.outcome import PLACES
from exogauge.motion.plan.solve import Planned, Report, Stop, plan
from exogauge.motion.plan.spline import through
from exogauge.motion.plan.written import Written
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import base_on, standing

Array = NDArray[np.float64]
AS_READ = "read from the table"  # what `check` finds of it


@final
@dataclass(frozen=True)
class _Found:
    """What was planned where `asked` was asked of `robot`, with bounds and margins of `criteria`; judged, by those that
    were asked for, with what is broken of both; table: as it is read."""

    asked: Asked
    robot: MotionRobot
    criteria: MotionPlan
    planned: Planned
    judged: Judged
    table: Judged

    @property
    def most(self) -> dict[str, Array]:
        """(J,) largest share of each bound."""
        return {what: np.maximum(share, self.table.most[what]) for what, share in self.judged.most.items()}

    def breaks(self, criteria: MotionPlan) -> tuple[float, int]:
        """By how much the worst bound, as a share of it, 1 for none; how many are told."""
        worst = max(float(share.max()) for share in self.most.values())
        return max(1.0, worst, 1.0 + self.lacks(criteria) / HALF_FOOT_M), len(self.judged.broken)

    @property
    def by_table(self) -> bool:
        """Whether the plan itself keeps every bound."""
        return all(line.startswith(AS_READ) for line in self.judged.broken)

    def lacks(self, criteria: MotionPlan) -> float:
        """[m] by which the centre of pressure is too near to the soles' edge."""
        known = (each.least_inside for each in (self.judged, self.table))
        return max(0.0, *(criteria.inside_m - least for least in known if least is not None))


def plan_within(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, report: Report | None = None,
    rate: float | None = None, stop: Stop | None = None,
) -> tuple[Planned, Judged, Asked]:  # fmt: skip
    """Planned and judged at `rate` [Hz], as it is and as its table is read. Where a bound is broken that the nodes
    keep, it is planned anew, `again` times at most, each time from the best that there is: with what is exceeded, or
    nearly so, bounded by as much less; where that comes no nearer, on more nodes. Best is what breaks its worst bound
    by least, and the fewest; with what is asked on its nodes.

    Where the robot cannot even stand at home no motion keeps its bounds: nothing is planned, what is lacking is told
    first, and standing at home is judged. stop: as of `plan`; a plan that is there already is not lost by it.

    Raises BadMotion where the first plan does.
    """
    rest = at_home(robot, criteria)
    if rest.lacks:
        return *_at_home(robot, asked, criteria, rate, rest), asked

    def made(wanted: Asked, own: MotionRobot, given: MotionPlan, start: Planned | None = None) -> _Found:
        planned = plan(own, wanted, given, report, stop, start)
        return _Found(wanted, own, given, planned, *_judged(robot, wanted, planned, criteria, rate))

    best = made(asked, robot, criteria)
    finer: Asked | None = asked.finer(rate or criteria.judged_hz)
    possible = not best.planned.unsettled and (best.by_table or float(best.planned.excess.max()) <= criteria.over)
    nearer = True
    for _ in range(criteria.again if possible else 0):
        if not best.judged.broken:
            break
        wanted, (own, given) = best.asked, _tightened(best, criteria)
        if not nearer or (own is best.robot and given == best.criteria):
            if finer is None:
                break
            wanted, own, given, finer = finer, best.robot, best.criteria, None
        try:
            found = made(wanted, own, given, best.planned if wanted is best.asked else None)
        except BadMotion:  # none is found, or it is stopped: that which there is stays
            found = best
        nearer = found.breaks(criteria) < best.breaks(criteria)
        best = min(best, found, key=lambda each: each.breaks(criteria))
    return best.planned, _with_reasons(best.planned, best.judged, rest), best.asked


def _tightened(found: _Found, criteria: MotionPlan) -> tuple[MotionRobot, MotionPlan]:
    """As much less of what is exceeded, or swings through half of what is kept of it, and `more_kept` less beside, as a
    plan that was changed swings elsewhere; twice what is lacking of distances. The same where nothing is."""
    robot, given = found.robot, found.criteria
    near, lacks = max(0.0, criteria.clearance_m - float(found.judged.apart.min())), found.lacks(criteria)
    beside = criteria.more_kept * HALF_FOOT_M if lacks else 0.0
    given = replace(given, margin_m=given.margin_m + 2.0 * lacks + beside, apart_m=given.apart_m + 2.0 * near)
    swings = min(0.5 * (criteria.kept + 1.0), 1.0)
    less = {what: np.where(share > swings, share + criteria.more_kept, 1.0)
            for what, share in found.most.items()}  # fmt: skip
    if not any((share > 1.0).any() for share in less.values()):
        return robot, given
    limits = robot.limits
    bounds = {"velocity": limits.velocity, "acceleration": limits.acceleration, "torque": limits.torque,
              "jerk": robot.jerk}  # fmt: skip
    limits = replace(limits, **{what: bounds[what] / share for what, share in less.items()})
    return replace(robot, limits=limits), given


def _judged(
    robot: MotionRobot, asked: Asked, planned: Planned, criteria: MotionPlan, rate: float | None
) -> tuple[Judged, Judged]:
    """Where it begins and ends is looked at too: a robot at home would jump there. So is what `check` finds of its
    table and the plan does not have."""
    judged = judge(robot, planned.spline, asked.place[0], criteria, rate, planned)
    table = read_again(robot, judged, criteria, rate)
    known = {line.split(":")[0] for line in judged.broken}
    read = (f"{AS_READ}: {line}" for line in table.broken if line.split(":")[0] not in known)
    ends = planned.spline.at(np.array([0.0, planned.spline.duration]))[0]
    lines = list[str]()
    for what, posture, home in zip(("begins", "ends"), ends, asked.q[[0, -1]], strict=True):
        aside = np.abs(posture - home)[robot.base :]
        if aside.max() > criteria.aside:
            lines.append(f"the motion {what} beside home: {robot.joints[aside.argmax()]} by {aside.max():.3g}, at most "
                         f"{criteria.aside:g} is asked")  # fmt: skip
    return replace(judged, broken=(*lines, *judged.broken, *read)), table


def read_again(robot: MotionRobot, judged: Judged, criteria: MotionPlan, rate: float | None) -> Judged:
    """What the samples are as a table of them is read, distances aside: its angles are those that were judged. Feet
    that stand are still there, and share the load evenly; between the rows lies a cubic."""
    q = judged.q.copy()
    q[:, robot.base :] = q[:, robot.base :].round(PLACES)
    if robot.floating:
        q[:, : robot.base] = base_on(robot, q, judged.stands)
    table = Written(judged.time, q, (), judged.stands)
    return judge(replace(robot, shapes=()), table, standing(robot), criteria, rate, table)


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
