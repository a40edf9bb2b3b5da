"""What the doctor that knows the robot says: each thing that was found as a finding, with detail and advice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from exogauge.criteria.examining import Comparing
from exogauge.identification.preparation import DRIVE
from exogauge.logs.findings import Finding
from exogauge.plausibility.base_moments import (
    Exchanged,
    Late,
    MomentUnit,
    OtherAxes,
)
from exogauge.plausibility.contact_points import OtherPoints
from exogauge.plausibility.dead_position import DeadPosition
from exogauge.plausibility.delay import Delay
from exogauge.plausibility.remedies import Remedy
from exogauge.plausibility.search import Slip
from exogauge.plausibility.soles import TurnedLeg
from exogauge.plausibility.unlike import Unlike
from exogauge.plausibility.zeros import Zero
from exogauge.robots.description import Robot

OTHER_CLOCK, EFFORT_DELAY = "effort_clock", "effort_delay"
WRENCH_CLOCK = "wrench_clock"
IMU_CLOCK, IMU_LATE = "imu_clock", "imu_late"
MOVED_ZERO, UNSURE_SIGN = "zero_moved", "sign_unsure"
SAID = {
    "effort_reversed": ("runs against what gravity, inertia and friction ask for", "turn its sign in a mapping"),
    "position_reversed": (
        "fits what its effort bears only with its sign turned",
        "turn its sign in a mapping, or the joint's axis in the URDF",
    ),
    "joint_reversed": (
        "and its effort both fit only with their signs turned",
        "turn both in a mapping, or the joint's axis in the URDF",
    ),
    "efforts_exchanged": ("fit only the other way round", "exchange the two columns in a mapping"),
    "positions_exchanged": ("fit only the other way round", "exchange the two columns in a mapping"),
    "joints_exchanged": (
        "and their efforts fit only the other way round",
        "exchange them: the order of `joints` in robot.yaml is that of the columns",
    ),
}


def as_unit(unit: MomentUnit) -> Finding:
    """Of the moments of all contact sensors."""
    times = f"{1.0 / unit.factor:.3g} times too large" if unit.factor < 1.0 else f"{unit.factor:.3g} times too small"
    detail = (
        f"their moments are {times}: {100 * unit.before:.0f} % of how the moments about the base change no body asks "
        f"for as it is, and {100 * unit.after:.0f} % so"
    )
    advice = "state the right `moment_unit` in a mapping: N·m, N·mm, N·cm, kgf·m?"
    return Finding("error", "ft.*", "moment_unit", detail, advice, value=unit.factor)


def as_exchanged(robot: Robot, sides: Exchanged) -> Finding:
    one, other = (f"ft.{robot.contacts[place].name}" for place in sides.pair)
    detail = (
        f"and {other} fit only the other way round: {100 * sides.before:.0f} % of how their moments about the base "
        f"change no body asks for as it is, and {100 * sides.after:.0f} % so"
    )
    advice = f"exchange the columns of {one} and {other} in a mapping, or their frames in robot.yaml"
    return Finding("error", one, "wrenches_exchanged", detail, advice, value=sides.before)


def as_other_axes(robot: Robot, axes: OtherAxes) -> Finding:
    channel = f"ft.{robot.contacts[axes.sensors[0]].name}" if len(axes.sensors) == 1 else "ft.*"
    detail = (
        f"fits only in other axes: {100 * axes.before:.0f} % of how the moments about the base change are not given as "
        f"it is, and {100 * axes.after:.0f} % so"
    )
    advice = f"in a mapping, take for its forces and moments {axes.words}, or turn its frame in the URDF"
    return Finding("error", channel, "wrench_axes", detail, advice, value=axes.before)


def as_turned_leg(robot: Robot, leg: TurnedLeg) -> Finding:
    joint, (one, other) = leg.remedy.joints[0], (robot.contacts[each].frame for each in leg.pair)
    said = "and its effort have their signs turned" if leg.remedy.kind == "both" else "has its sign turned"
    also = "".join(f", or q.{robot.joints[each].name}" for each in leg.rivals)
    detail = (
        f"{said}{also}: {one} and {other}, which both bear the robot, turn against each other by "
        f"{np.degrees(leg.before):.1f}° (rms) as it is, and by {np.degrees(leg.after):.1f}° so"
    )
    advice = SAID[leg.remedy.rule][1]
    return Finding("error", f"q.{robot.joints[joint].name}", leg.remedy.rule, detail, advice, value=-1.0)


def as_other_points(robot: Robot, points: OtherPoints) -> Iterator[Finding]:
    for sensor, place in zip(robot.contacts, points.places, strict=True):
        if place is not None:
            name, at = place[0], ", ".join(f"{each:.3f}" for each in place[1])
            detail = (
                f"tells its moments about {name}, [{at}] m from the origin of {sensor.frame} in its axes: so fit the "
                "moments about the base, and bodies that are off by as much as stated do not make up for it"
            )
            advice = (
                f"state a frame at that place, in the axes of {sensor.frame}, as the sensor's in robot.yaml, or bring "
                "the moments to its origin before they are logged: M + p × F, p that place"
            )
            distance = float(np.linalg.norm(place[1]))
            yield Finding("error", f"ft.{sensor.name}", "wrench_point", detail, advice, value=distance)


def as_late(late: Late, alike: bool = False) -> Finding:
    """alike: an IMU in every log, by as little as the effect `imu_delay` can name."""
    by = "how the contacts' moments about the base change no body near its description asks for as it is"
    if late.by_legs:
        by = "how the base turns by the legs that stand the gyro does not tell as it is"
    detail = (
        f"come {1000.0 * abs(late.seconds):.0f} ms {'late' if late.seconds > 0.0 else 'early'} against the positions: "
        f"{100 * late.before:.0f} % of {by}, and {100 * late.after:.0f} % so"
    )
    if late.of_imu:
        advice = (
            "is the IMU of another clock? In a mapping name its file, or the file once more for it, with a `delay_s`"
        )
        rule = IMU_LATE if alike else IMU_CLOCK
        return Finding("warning", "acc", rule, f"and gyro {detail}", advice, value=late.seconds)
    advice = "are they of another clock? In a mapping name their file with a `delay_s`"
    return Finding("warning", "ft.*", WRENCH_CLOCK, detail, advice, value=late.seconds)


def as_delayed(robot: Robot, delay: Delay) -> Finding:
    """On the first joint; the others that are late alike are told with it."""
    names = [f"{DRIVE[robot.joints[a].actuation]}.{robot.joints[a].name}" for a in delay.axes]
    late = "late" if delay.seconds > 0.0 else "early"
    also = f", and alike {', '.join(names[1:])}" if len(names) > 1 else ""
    detail = (
        f"comes {1000.0 * abs(delay.seconds):.0f} ms {late} against the positions{also} (left unexplained are "
        f"{100 * delay.before:.0f} % as it is and {100 * delay.after:.0f} % so)"
    )
    advice = "shift the column where logs are made, or name `torque_delay` among the effects"
    if delay.log:
        advice = "is it of another clock? In this log's mapping name the file twice, for efforts with a `delay_s`"
        return Finding("warning", names[0], OTHER_CLOCK, detail, advice, value=delay.seconds)
    if delay.far:
        advice = "is it of another clock? In a mapping name its file once more, with a `delay_s`"
    elif delay.seconds < 0.0:
        advice += "; is it the commanded torque, not the measured one?"
    if delay.or_friction:
        advice = (
            f"these logs do not tell it from gears or cables that creep before they slide, whose friction comes late "
            f"by itself: tap the robot and see which stream tells it first; if it is the clock, {advice}"
        )
    return Finding("warning", names[0], EFFORT_DELAY, detail, advice, value=delay.seconds)


def as_zero(robot: Robot, zero: Zero) -> Finding:
    joints = robot.joints
    also = "".join(f", or {np.degrees(angle):+.0f}° to q.{joints[j].name}" for j, angle in zero.rivals)
    axis = joints[zero.axis]
    detail = (
        f"fits what efforts bear better with {np.degrees(zero.angle):+.0f}° added{also} (of "
        f"{DRIVE[axis.actuation]}.{axis.name} {100 * zero.before:.1f} % are left unexplained as it is and "
        f"{100 * zero.after:.1f} % so)"
    )
    advice = (
        "measure the joint's angle in one posture and state the `offset` in a mapping; if it is right, a tool, a cable "
        "or a spring that nobody described pulls alike: these logs do not tell which"
    )
    return Finding("warning", f"q.{joints[zero.joint].name}", "position_offset", detail, advice, value=-zero.angle)


def as_moved(robot: Robot, zero: Zero) -> Finding:
    """In one log alone."""
    axis = robot.joints[zero.axis]
    detail = (
        f"has another zero than in the other logs: {np.degrees(zero.angle):+.0f}° added, {DRIVE[axis.actuation]}."
        f"{axis.name} leaves {100 * zero.after:.1f} % unexplained, as it is {100 * zero.before:.1f} %"
    )
    advice = "was its encoder set anew, or lost it counts? State the `offset` in a mapping of this log"
    return Finding("warning", f"q.{robot.joints[zero.joint].name}", MOVED_ZERO, detail, advice, value=-zero.angle)


def as_finding(robot: Robot, slip: Slip, of_one: bool = False) -> Finding:
    """of_one: in a single log among several, which a slip of a mapping is not."""
    remedy = slip.remedy
    if remedy.up is not None:
        return _as_gravity(robot, slip, remedy.up)
    channels = [channel(robot, remedy, joint) for joint in remedy.joints]
    half = len(channels) // 2  # of two that are exchanged
    left = f"left unexplained are {100 * slip.before:.0f} % as it is and {100 * slip.after:.0f} % so"
    said, advice = SAID.get(remedy.rule) or _with_value(robot, remedy)
    if np.isinf(slip.evidence):  # no loads were compared: another factor may do as well
        said, left = "goes far beyond its limits", f"{remedy.value or 1.0:.3g} times smaller it does not"
    if slip.as_good is not None and slip.as_good.kind != remedy.kind:
        other = channel(robot, slip.as_good, remedy.joints[0])
        said, advice = f"{said}, if {other} is right; these logs cannot tell which of the two is wrong", advice
    if slip.rivals:
        others = ", ".join(channel(robot, remedy, joint) for joint in slip.rivals)
        said = f"{said}, or those of {others}; these logs do not tell which"
    if half == 1:
        said = f"and {channels[1]} {said}"
    elif half:
        said = f"to {channels[half - 1]} and {channels[half]} to {channels[-1]} {said}"
    if of_one:
        advice = f"other logs fit as they are: is this column another recording's? If not, {advice}"
    if not slip.settled:
        advice = (
            f"look for something else first: so much is left that this is only the nearest of what is tried; {advice}"
        )
    return Finding("error", channels[0], remedy.rule, f"{said} ({left})", advice, value=remedy.value)


def _as_gravity(robot: Robot, slip: Slip, up: tuple[float, ...]) -> Finding:
    left = f"left unexplained are {100 * slip.before:.0f} % as it is and {100 * slip.after:.0f} % so"
    if not any(up):
        detail = f"bear no weight: they fit motion and friction alone ({left})"
        advice = (
            "does the controller tell them without its own gravity compensation? Log the whole torque, or add what it "
            "compensates"
        )
        kind = next(DRIVE[joint.actuation] for joint in robot.joints if joint.actuation != "none")
        return Finding("error", f"{kind}.*", slip.remedy.rule, detail, advice)
    down = ", ".join(f"{0.0 - each:.2g}" for each in up)
    detail = f"efforts fit a base on which gravity pulls along [{down}] of its own axes, not [0, 0, -1] ({left})"
    advice = (
        "does the robot hang on a wall or below a ceiling, or stand aslant? Turn it in the URDF: a fixed joint between "
        "a first link, upright, and its base"
    )
    if slip.as_good is not None and slip.as_good.value is not None:
        zero = f"q.{robot.joints[slip.as_good.joints[0]].name}"
        detail += f"; a zero of {zero} that is {np.degrees(slip.as_good.value):.0f}° off explains as much"
        advice = f"these logs do not tell which: state the `offset` of {zero} in a mapping, or: {advice}"
    if not slip.settled:
        advice = f"that direction is the nearest of 26 that are tried; {advice}"
    return Finding("error", "base", slip.remedy.rule, detail, advice, value=slip.remedy.value)


def as_unsure_sign(robot: Robot, joint: int, better: bool) -> Finding:
    """better: with both signs turned they fit better, though not surely."""
    detail = (
        f"and its effort fit {'better, not surely' if better else 'as well'} with both signs turned: whether they are "
        "right these logs do not tell, and no parameter of the joint counts as decided"
    )
    advice = (
        "look which way it turns as its angle grows, and state `sign_checked: true` of it in robot.yaml, or record it "
        "with a weight beside its axis"
    )
    return Finding("warning" if better else "note", f"q.{robot.joints[joint].name}", UNSURE_SIGN, detail, advice)


def as_dead(robot: Robot, dead: DeadPosition) -> Finding:
    joints = robot.joints
    names = [f"{DRIVE[joints[a].actuation]}.{joints[a].name}" for a in dead.axes]
    stays = "throughout" if dead.share == 1.0 else f"for {100 * dead.share:.0f} % of the log"
    left = f"{'of the first ' if len(names) > 1 else ''}{100 * dead.left:.0f} % are left unexplained"
    detail = (
        f"is {dead.at:.4g} {stays}, and {', '.join(names)} {'does' if len(names) == 1 else 'do'} not fit that: {left}"
    )
    advice = (
        "is its encoder dead, or the column empty or another's? If the joint stood still indeed, look at the columns "
        "of the others"
    )
    return Finding("warning", f"q.{joints[dead.joint].name}", "position_dead", detail, advice, value=dead.at)


def as_unlike(robot: Robot, unlike: Unlike) -> Finding:
    joint = robot.joints[unlike.axis]
    left, criteria = f"{100 * unlike.left:.0f} % are left unexplained", Comparing()
    said = f"is unlike what gravity, inertia and friction ask for ({left})"
    if unlike.others is not None:
        said = f"is unlike the other logs: {left}, in them {100 * unlike.others:.0f} % at most"
    elif unlike.left <= criteria.unlike:
        said = f"asks for bodies that are off by far more than stated ({left})"
    detail = f"{said}, and no slip that was tried explains it"
    advice = (
        "look at the columns of both: are they another joint's, another recording's, or lost their sign? Does it carry "
        "what nobody described? Where several joints are so, one position that moves them all is likelier wrong"
    )
    return Finding(
        "warning", f"{DRIVE[joint.actuation]}.{joint.name}", "effort_unlike", detail, advice, value=unlike.left
    )


def channel(robot: Robot, remedy: Remedy, joint: int) -> str:
    described = robot.joints[joint]
    kind = DRIVE[described.actuation] if remedy.kind == "effort" else "q"
    return f"{kind}.{described.name}"


def _with_value(robot: Robot, remedy: Remedy) -> tuple[str, str]:
    value, joint = remedy.value or 0.0, robot.joints[remedy.joints[0]]
    if remedy.rule == "position_offset":
        detail = f"has its zero about {np.degrees(value):.0f}° from where the description has it"
        return detail, "state the offset in a mapping"
    if remedy.rule == "position_scale":
        unit = "is it in degrees?" if value > 1.0 else "was a column in radians declared as degrees?"
        gear = abs(joint.gear_ratio or 1.0)
        if value > 1.0 and gear == 1.0:
            unit = "is it in degrees, or the motor's angle, whose `gear_ratio` robot.yaml does not state?"
        if np.isclose(abs(np.log(value)), np.log(gear)):
            unit = "is it on the motor's side of the gear, and stated as the joint's, or the reverse?"
        return f"is {value:.3g} times what the effort it meets lets one expect", f"{unit} State it in a mapping"
    detail = f"is about {abs(value):.2g} times what gravity, inertia and friction ask for"
    sign = " Its sign is turned too." if value < 0.0 else ""
    if joint.actuation == "current":
        units = "are amperes mA, or a percentage?" if abs(value) > 1.0 else "were amperes declared as mA?"
        return detail, f"check unit, side of the gear, k_T, and masses in the URDF: {units}{sign}"
    units = "is it in N·mm, or a percentage?" if abs(value) > 1.0 else "was N·m declared as N·mm, or mN·m?"
    return detail, f"check unit, side of the gear, and masses in the URDF: {units}{sign}"
