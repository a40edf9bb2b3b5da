"""Motions and plans as series for plots: names, units and values on one set of times."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.motion.fit.body import TRUNK
from exogauge.motion.fit.result import HumanFit
from exogauge.motion.human import HumanMotion
from exogauge.motion.person import Person
from exogauge.motion.plan.judge import Judged
from exogauge.motion.retargeting import Retargeted
from exogauge.robots.moving.robot import MotionRobot
from exogauge.studies.series.write import Columns

Array = NDArray[np.float64]
KINDS = ("position", "velocity", "acceleration", "jerk", "torque")
RADIANS, METRES = "rad", "m"


def of_motion(motion: HumanMotion) -> pa.Table:
    """`marker.<label>.x` …, `bone.<name>.x` …, `angle.<name>`, `stands.left`, as far as the motion has them."""
    columns = Columns(motion.time)
    named = [] if motion.markers is None else [("marker", motion.markers.labels, motion.markers.position)]
    if motion.tree is not None:
        named.append(("bone", motion.tree.names, motion.tree.position))
    for part, names, places in named:
        for k, name in enumerate(names):
            for axis, letter in enumerate("xyz"):
                columns.add(f"{part}.{name}.{letter}", places[:, k, axis], METRES, short=True)
    if motion.angles is not None:
        for k, name in enumerate(motion.angles.names):
            unit = RADIANS if motion.angles.rotational[k] else METRES
            columns.add(f"angle.{name}", motion.angles.value[:, k], unit)
    if motion.contacts is not None:
        columns.add_truth("stands.left", motion.contacts.left)
        columns.add_truth("stands.right", motion.contacts.right)
    return columns.table({"log": motion.name, "version": "1"})


def of_fit(fit: HumanFit) -> pa.Table:
    """`angle.<coordinate>` and its standard deviation `sd.<coordinate>`."""
    columns = Columns(fit.time)
    for k, name in enumerate(fit.body.coordinates):
        unit = METRES if fit.body.prismatic[k] else RADIANS
        columns.add(f"angle.{name}", fit.q[:, k], unit, short=True)
        columns.add(f"sd.{name}", fit.q_sd[:, k], unit, short=True)
    return columns.table({"log": fit.name, "version": "1"})


def of_retargeted(found: Retargeted) -> pa.Table:
    """The trunk as the person turns it (`human.`), as it is asked and given (`trunk.`); then `of_judged`."""
    judged, robot, asked = found.judged, found.robot, found.asked
    columns = Columns(judged.time)
    turns = trunk_angles(found.person)
    for k, name in enumerate(TRUNK):
        shown = np.interp(judged.time - found.lead, found.person.time, turns[:, k], left=np.nan, right=np.nan)
        columns.add(f"human.{name}", shown, RADIANS)
    for j in robot.torso:
        joint, column = robot.joints[j], robot.base + j
        columns.add(f"trunk.asked.{joint}", np.interp(judged.time, asked.time, asked.q[:, column]), RADIANS)
        columns.add(f"trunk.given.{joint}", judged.q[:, column], RADIANS)
    spline = found.planned.spline
    return add_judged(columns, robot, judged, spline.at(judged.time)[2]).table({"log": "motion", "version": "1"})


def add_judged(columns: Columns, robot: MotionRobot, judged: Judged, acceleration: Array) -> Columns:
    """`margin.` what is left of balance and distances, `bound.` the largest share of each kind of bound, `binds` what
    is nearest to its bound, `stands.` of every foot where one lifts, then `pressure.`, `q.` and `tau.` of every joint.
    acceleration: (T, n)."""
    margins = (("pressure_inside", judged.inside, METRES), ("nearest_pair", judged.apart, METRES),
               ("weight_carried", judged.carried, "1"))  # fmt: skip
    for name, values, unit in margins:
        if np.isfinite(values).any():
            columns.add(f"margin.{name}", values, unit)
    shares = bound_shares(robot, judged, acceleration)
    largest = np.stack([shares[kind].max(axis=1) for kind in KINDS], axis=1)
    for k, kind in enumerate(KINDS):
        columns.add(f"bound.{kind}", largest[:, k], "1")
    words = [f"{kind} of {joint}" for kind in KINDS for joint in robot.joints]
    nearest = np.concatenate([shares[kind] for kind in KINDS], axis=1).argmax(axis=1)
    used, index = np.unique(nearest, return_inverse=True)
    columns.add_words("binds", index, tuple(words[k] for k in used))
    if not judged.stands.all():
        for sole, stands in zip(robot.soles, judged.stands.T, strict=True):
            columns.add_truth(f"stands.{sole.link}", stands)
    for axis, letter in enumerate("xy" if np.isfinite(judged.pressure).any() else ""):
        columns.add(f"pressure.{letter}", judged.pressure[:, axis], METRES)
    for j, joint in enumerate(robot.joints):
        slides = "P" in robot.model.joints[1 + robot.base + j].shortname()
        columns.add(f"q.{joint}", judged.q[:, robot.base + j], METRES if slides else RADIANS)
        columns.add(f"tau.{joint}", judged.torque[:, j], "N" if slides else "N*m")
    return columns


def bound_shares(robot: MotionRobot, judged: Judged, acceleration: Array) -> dict[str, Array]:
    """(T, J) of each kind of bound: 1 is at it; a position counts from the middle of its range."""
    limits, own = robot.limits, slice(robot.base, None)
    q, a = judged.q[:, own], acceleration[:, own]
    rate = 1.0 / (judged.time[1] - judged.time[0])
    jerk = np.diff(a, axis=0, append=a[-1:]) * rate
    half = 0.5 * (limits.upper - limits.lower)
    known = np.isfinite(half) & (half > 0.0)
    middle = np.where(known, 0.5 * (limits.upper + limits.lower), 0.0)
    return {
        "position": np.where(known, np.abs(q - middle) / np.where(known, half, 1.0), 0.0),
        "velocity": np.abs(judged.dq[:, own]) / limits.velocity,
        "acceleration": np.abs(a) / limits.acceleration,
        "jerk": np.abs(jerk) / robot.jerk,
        "torque": np.abs(judged.torque) / limits.torque,
    }


def trunk_angles(person: Person) -> Array:
    """(T, 3) [rad] flexion ahead, bend to the right, rotation to the left of the thorax in the pelvis."""
    return np.unwrap(Rotation.from_matrix(person.trunk).as_euler("YXZ"), axis=0)
