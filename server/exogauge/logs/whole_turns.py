"""Angles that begin anew after a turn, as from 359 degrees to 0, become one course: no joint goes round between two
samples. What is told from 0 to a whole turn is told about zero, where only then it stays within the joint's limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.findings import JointLimits, first_row, joint_channels
from exogauge.logs.model import Log, Note

Array = NDArray[np.float64]
TURN = 2.0 * np.pi


def in_one_course(log: Log, joints: Mapping[str, JointLimits]) -> Log:
    """The log, its `notes` telling what was done; itself where nothing is to be done. joints: by name."""
    changed, notes = dict[str, Array](), list[Note]()
    for joint, values in joint_channels(log, "q").items():
        limits = joints.get(joint, JointLimits())
        if not limits.turns or not values.size or not np.isfinite(values).all():
            continue
        course, row = continued(values)
        if row is not None:
            detail = (
                f"q.{joint} begins anew after a turn, first from {values[row - 2]:.4g} to {values[row - 1]:.4g} rad"
            )
            notes.append(Note("turns_continued", f"{detail}: continued across", "", row))
        if turns := _too_far(course, limits):
            detail = f"q.{joint} is told a whole turn beyond its limits: {-turns * 360:+d} degrees are added"
            notes.append(Note("turn_taken_off", detail, ""))
            course = course - turns * TURN
        if course is not values:
            changed[f"q.{joint}"] = course
    return replace(log, channels={**log.channels, **changed}, notes=(*log.notes, *notes)) if changed else log


def continued(values: Array) -> tuple[Array, int | None]:
    """(T,) [rad] without jumps of whole turns, and the row, from 1, after the first; the values themselves where there
    is none, or what jumps does not jump by whole turns."""
    step = np.diff(values)
    turns = np.round(step / TURN)
    usual = float(np.max(np.abs(step[turns == 0.0]), initial=0.0))
    jumps = turns != 0.0
    if not jumps.any() or usual > 0.5 * np.pi or np.any(np.abs(step - TURN * turns)[jumps] > 2.0 * usual):
        return values, None
    return values - TURN * np.concatenate([[0.0], np.cumsum(turns)]), first_row(jumps) + 1


def _too_far(course: Array, limits: JointLimits) -> int:
    """Whole turns by which a course lies beyond the limits, -1, 0 or 1; 0 where it lies as far with them."""
    low, high = float(course.min()), float(course.max())
    span = limits.upper - limits.lower
    margin = 0.02 * span + 0.01
    if not np.isfinite(span) or span >= TURN:
        return 0

    def within(turns: int) -> bool:
        return low - turns * TURN >= limits.lower - margin and high - turns * TURN <= limits.upper + margin

    return next((turns for turns in (0, 1, -1) if within(turns)), 0)
