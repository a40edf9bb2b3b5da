"""The recipe from a capture to a robot's motion: the person, what is asked, the plan, its judgement."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.motion.contract import RetargetEntry
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.human import HumanMotion
from exogauge.motion.person import Person, person_of, person_of_fit
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.frame_by_frame import frame_by_frame
from exogauge.motion.plan.judge import Judged
from exogauge.motion.plan.possible import Again, Possible, Tried, paced, what_would_do
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.solve import Planned, Report
from exogauge.motion.plan.within import plan_within
from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Retargeted:
    """person: as asked for. lead: [s] from home to where its motion begins. missed: (N,) [rad] of the trunk's turn that
    no joints express. could: what would do, None where nobody asked, nothing is broken, or another home is what would
    do. alone: each frame by itself, None where nothing was planned.
    """

    robot: MotionRobot
    person: Person
    lead: float
    asked: Asked
    missed: Array
    planned: Planned
    judged: Judged
    could: Possible | None
    alone: tuple[Planned, Judged] | None


def with_margin(margin_m: float) -> MotionPlan:
    """What decides where the centre of pressure keeps `margin_m` inside the soles at the nodes, as much less between
    them as usual."""
    return replace(USUAL, margin_m=margin_m, inside_m=max(margin_m - (USUAL.margin_m - USUAL.inside_m), 0.0))


def criteria_of(wanted: RetargetEntry) -> MotionPlan:
    """What decides when that is planned."""
    return paced(with_margin(wanted.margin_m), wanted.slow, wanted.rate_hz)


def again(robot: MotionRobot, person: Person, wanted: RetargetEntry) -> Again:
    """For the search of what would do: what `retargeted` plans where that is asked for."""

    def asked_of(slower: float, share: float) -> tuple[Asked, MotionPlan]:
        other = wanted.model_copy(update={"slow": slower * wanted.slow, "share": share * wanted.share})
        criteria = criteria_of(other)
        return ask(robot, changed(person, other), criteria)[0], criteria

    return asked_of


def person_in(motion: HumanMotion, static: HumanMotion | None) -> Person:
    """Of a skeleton as it is, of markers by a body that is fitted to them. Raises BadMotion."""
    return person_of(motion) if motion.markers is None else person_of_fit(fit_human(motion, static), motion.contacts)


def changed(person: Person, wanted: RetargetEntry) -> Person:
    """Cut, slowed, shared, left out, mirrored, repeated: in this order."""
    person = person.cut(wanted.begin, np.inf if wanted.end is None else wanted.end)
    person = person.slowed(wanted.slow).trunk_share(wanted.share)
    for part in wanted.without:
        person = person.without(part)
    person = person.mirrored() if wanted.mirror else person
    return person.repeated(wanted.repeat, USUAL.approach_s) if wanted.repeat > 1 else person


def retargeted(
    robot: MotionRobot, person: Person, wanted: RetargetEntry, report: Report | None = None, tried: Tried | None = None
) -> Retargeted:
    """person: as captured. Raises BadMotion, BadRobot."""
    own, criteria = changed(person, wanted), criteria_of(wanted)
    first, missed = ask(robot, own, criteria)
    planned, judged, asked = plan_within(robot, first, criteria, report, wanted.rate_hz)
    missed = np.interp(asked.time, first.time, missed)
    lead = round(criteria.approach_s / first.step) * first.step
    could = None
    if judged.broken and wanted.what_would_do:
        could = what_would_do(robot, criteria, again(robot, person, wanted), wanted.rate_hz, tried)
    alone = frame_by_frame(robot, asked, criteria, wanted.rate_hz) if planned.rounds else None
    return Retargeted(robot, own, lead, asked, missed, planned, judged, could, alone)
