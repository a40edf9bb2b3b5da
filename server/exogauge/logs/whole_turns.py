"""Angles that begin anew after a turn, as from 359 degrees to 0, become one course: no joint goes round between two
samples. What is told from 0 to a whole turn is told about zero, where only then it stays within the joint's limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.findings import JointLimits, first_row, joint_channels
from exogauge.logs.model import Log, Note

Array = NDArray[np.float64]


def in_one_course(logs: Sequence[Log], joints: Mapping[str, JointLimits]) -> list[Log]:
    """The logs of one recorder, their `notes` telling what was done; as they are where nothing is to be done. joints:
    by name. Where an angle begins anew in any log and limits do not say about where it is, it is told about zero in
    all."""
    courses = [{joint: continued(values) for joint, values in _turning(log, joints).items()} for log in logs]
    anew = {joint for each in courses for joint, (_, row) in each.items() if row is not None}
    return [_told(log, each, joints, anew) for log, each in zip(logs, courses, strict=True)]


def _turning(log: Log, joints: Mapping[str, JointLimits]) -> dict[str, Array]:
    return {
        joint: values
        for joint, values in joint_channels(log, "q").items()
        if joints.get(joint, JointLimits()).turns and values.size and np.isfinite(values).all()
    }


def _told(
    log: Log, courses: Mapping[str, tuple[Array, int | None]], joints: Mapping[str, JointLimits], anew: Set[str]
) -> Log:
    changed, notes = dict[str, Array](), list[Note]()
    for joint, (course, row) in courses.items():
        values, limits = log.channels[f"q.{joint}"], joints.get(joint, JointLimits())
        if row is not None:
            detail = (
                f"q.{joint} begins anew after a turn, first from {values[row - 2]:.4g} to {values[row - 1]:.4g} rad"
            )
            notes.append(Note("turns_continued", f"{detail}: continued across", "", row))
        limited = limits.upper - limits.lower < math.tau
        about_zero = round(float(np.median(course)) / math.tau) if joint in anew else 0
        if turns := _beyond(course, limits) if limited else about_zero:
            where = "a whole turn beyond its limits" if limited else "about another turn than zero"
            notes.append(Note("turn_taken_off", f"q.{joint} is told {where}: {-turns * 360:+d} degrees are added"))
            course = course - turns * math.tau
        if course is not values:
            changed[f"q.{joint}"] = course
    return replace(log, channels={**log.channels, **changed}, notes=(*log.notes, *notes)) if changed else log


def continued(values: Array) -> tuple[Array, int | None]:
    """(T,) [rad] without jumps of whole turns, and the row, from 1, after the first; the values themselves where there
    is none, or what jumps does not jump by whole turns."""
    if not values.size or np.ptp(values) < math.pi:  # nothing jumps by half a turn
        return values, None
    step = np.diff(values)
    turns = np.round(step / math.tau)
    usual = float(np.max(np.abs(step[turns == 0.0]), initial=0.0))
    jumps = turns != 0.0
    if not jumps.any() or usual > 0.5 * np.pi or np.any(np.abs(step - math.tau * turns)[jumps] > 2.0 * usual):
        return values, None
    return values - math.tau * np.concatenate([[0.0], np.cumsum(turns)]), first_row(jumps) + 1


def _beyond(course: Array, limits: JointLimits) -> int:
    """Whole turns by which a course lies beyond the limits, -1, 0 or 1; 0 where it lies as far with them."""
    low, high = float(course.min()), float(course.max())
    margin = 0.02 * (limits.upper - limits.lower) + 0.01

    def within(turns: int) -> bool:
        return low - turns * math.tau >= limits.lower - margin and high - turns * math.tau <= limits.upper + margin

    return next((turns for turns in (0, 1, -1) if within(turns)), 0)
