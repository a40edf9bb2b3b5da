"""Which log without the device each log with it is compared with, and whether both hold the same motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.devices.routing import Routing
from exogauge.errors import BadStudy, Fault
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot
from exogauge.robots.tree import IntArray
from exogauge.support.result import JointEquality
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import PlainLog, SupportSettings, WornLog


@final
@dataclass(frozen=True)
class Pair:
    """reference: place among the logs without the device; None where none has this motion."""

    worn: WornLog
    reference: int | None


def pairs(worn: Sequence[WornLog], plain: Sequence[PlainLog]) -> list[Pair]:
    """The k-th trial with a device goes with the k-th log without it; there may be fewer of those."""
    seen: dict[tuple[str, str], int] = {}
    result = []
    for each in worn:
        candidates = [place for place, other in enumerate(plain) if other.motion == each.motion]
        trial = seen.get((each.device.name, each.motion), 0)
        seen[each.device.name, each.motion] = trial + 1
        result.append(Pair(each, candidates[trial % len(candidates)] if candidates else None))
    return result


def acted_joints(robot: Robot, worn: Sequence[WornLog]) -> IntArray:
    """(D,) columns of q on which the bands of any device can act and whose torque is logged."""
    columns = {int(c) for each in worn for c in Routing(robot.tree, each.device.bands).columns}
    return np.array(sorted(c for c in columns if robot.joints[c].actuation != "none"), dtype=np.intp)


def require_same_motions(
    robot: Robot, worn: Sequence[WornLog], plain: Sequence[PlainLog], settings: SupportSettings
) -> None:
    """BadStudy where a log with the device and the one it would be compared with do not hold the same motion."""
    names = [robot.joints[j].name for j in acted_joints(robot, worn)]
    postures: dict[int, Posture] = {}
    faults: list[Fault] = []
    for pair in pairs(worn, plain):
        if pair.reference is None:
            continue
        other = plain[pair.reference].log
        if pair.reference not in postures:
            postures[pair.reference] = Posture(other, names)
        found = match(Posture(pair.worn.log, names), postures[pair.reference], settings)
        faults += [
            _fault(pair.worn, other.name, each, settings) for each in found.equality if each.verdict == "different"
        ]
    if faults:
        raise BadStudy(faults)


def doubts(trials: Mapping[str, tuple[str, Sequence[JointEquality]]], settings: SupportSettings) -> list[Remark]:
    """Of motions that are only nearly the same. trials: log -> (its reference, equality)."""
    return [
        Remark(
            About.MOTION_DOUBTFUL,
            (log, reference),
            beside=(each.joint,),
            numbers=(each.dq_share, settings.doubtful, each.q_rms),
        )
        for log, (reference, equality) in trials.items()
        for each in equality
        if each.verdict == "doubtful"
    ]


def _fault(worn: WornLog, reference: str, found: JointEquality, settings: SupportSettings) -> Fault:
    return Fault(
        f"{found.joint} does not move as in {reference}, the log without the device of the same motion "
        f"{worn.motion!r}: rms difference {found.q_rms:.3g} rad and {found.dq_rms:.3g} rad/s, "
        f"{100 * found.dq_share:.0f} % of its rms velocity, after the best alignment in time",
        "motions_differ",
        f"Approach A needs the same motion in both. Record it again, give the log its own `motion`, or raise "
        f"`motion_different` (now {settings.different:g}) if you know what you do.",
        worn.log.name,
        None,
        f"q.{found.joint}",
        f"{found.dq_share:.3g}",
    )
