"""The doctor that knows the robot: joint by joint, is what was measured what the description leads one to expect?

What needs no comparison: channels without life, efforts and speeds that the robot cannot have.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from exogauge.criteria.examining import Comparing
from exogauge.identification.added_columns import COMPONENTS
from exogauge.identification.preparation import DRIVE
from exogauge.logs.findings import Finding, varies
from exogauge.logs.model import Log
from exogauge.plausibility.base_moments import (
    contact_axes,
    exchanged_contacts,
    late_imu_or_contacts,
    moment_unit,
)
from exogauge.plausibility.contact_points import other_points
from exogauge.plausibility.dead_position import DeadPosition, dead_positions
from exogauge.plausibility.delay import Delay, find_delays, of_another_clock
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.imu_frame import directions, imu_rules, told_on_floor
from exogauge.plausibility.late_gyro import alike, late_gyro
from exogauge.plausibility.search import Slip, find_slips, gravity_left_out, reversed_efforts, unsure_signs
from exogauge.plausibility.snapshot import Snapshot, take
from exogauge.plausibility.soles import turned_leg
from exogauge.plausibility.told_as import (
    as_dead,
    as_delayed,
    as_exchanged,
    as_finding,
    as_late,
    as_moved,
    as_other_axes,
    as_other_points,
    as_turned_leg,
    as_unit,
    as_unlike,
    as_unsure_sign,
    as_zero,
)
from exogauge.plausibility.unlike import Unlike
from exogauge.plausibility.zeros import find_zeros, moved_zeros
from exogauge.robots.description import Robot
from exogauge.side_by_side import each as side_by_side


def examine_against_robot(
    robot: Robot, logs: Sequence[Log], criteria: Comparing | None = None, fitted: Collection[str] = ()
) -> Iterator[tuple[str, Finding]]:
    """(name of the log, finding). Logs in which nothing is worn: what a wear bears, no description knows. fitted: names
    of those that a robot is identified from, which are looked at before others.

    A statement is made only where the one reading explains so much more than the other that no doubt of masses, k_T
    or friction makes up for it (`decisive`); of a joint that stands still, or bears nothing, none is.
    """
    criteria = criteria or Comparing()
    for log in logs:
        for finding in half_measured(robot, log):
            yield log.name, finding
    chosen = looked_at(logs, fitted, criteria.most_logs)
    seen = [each for each in side_by_side(partial(take, robot, criteria=criteria), chosen) if each is not None]
    seen = yield from _of_the_base(robot, logs, seen)
    if not any(joint.actuation != "none" for joint in robot.joints):
        return
    slips, unlike, expected = find_slips(robot, seen)
    if not slips and (bare := gravity_left_out(robot, expected)):
        slips, unlike = [bare], []
    for finding in not_judged(robot, expected):
        for log in logs:
            yield log.name, finding
    told = set[tuple[str, str]]()
    slips, unlike, delays = _late_and_no_slip(slips, unlike, expected)
    slips, unlike, dead = _dead_and_no_slip(slips, unlike, expected)
    for each in dead:
        yield each.log, as_dead(robot, each)
    for slip in slips:
        names = [log.name for log in logs] if len(slip.logs) == len(seen) else slip.logs
        for name in names:
            finding = as_finding(robot, slip, of_one=len(slip.logs) == 1 < len(seen))
            told.add((name, finding.channel))
            yield name, finding
    moved = list(moved_zeros(robot, expected)) if not slips and not delays and not dead else []
    unlike = [each for each in unlike if not {*each.logs} <= {name for name, _ in moved}]
    for name, zero in moved:
        yield name, as_moved(robot, zero)
    by_channel = [(each.seen.log, finding) for each in expected for finding in channel_rules(robot, each)]
    elsewhere = {finding.channel for _, finding in by_channel}
    for odd in unlike:
        if (finding := as_unlike(robot, odd)).channel not in elsewhere:
            for name in [log.name for log in logs] if len(odd.logs) == len(seen) else odd.logs:
                yield name, finding
    if expected and not slips and not delays:  # what is wrong otherwise may look late
        delays = list(find_delays(expected))
    for delay in delays:
        for name in [delay.log] if delay.log else [log.name for log in logs]:
            yield name, as_delayed(robot, delay)
    if not slips and not delays and not unlike and not dead and not moved:
        for finding in _signs_and_zeros(robot, expected):
            for log in logs:
                yield log.name, finding
    for name, finding in by_channel:
        if (name, finding.channel) not in told:
            yield name, finding


def _of_the_base(
    robot: Robot, logs: Sequence[Log], seen: list[Snapshot]
) -> Generator[tuple[str, Finding], None, list[Snapshot]]:
    """What feet and IMU tell of the base, before any joint is asked; returned are the snapshots with it undone."""
    leg = turned_leg(robot, seen)
    if leg is not None:  # before all that feet tell of the base
        seen = [leg.remedy.undo(each) for each in seen]
        for log in logs:
            yield log.name, as_turned_leg(robot, leg)
    axes = contact_axes(robot, seen)
    if axes is not None:  # before the IMU, which is told by the contacts
        seen = [axes.undo(each) for each in seen]
        for log in logs:
            yield log.name, as_other_axes(robot, axes)
    turned = imu_findings(robot, seen)
    for name in [log.name for log in logs] if turned and len(turned) == len(seen) else turned:
        yield name, turned.get(name) or next(iter(turned.values()))
    seen = [each for each in seen if each.log not in turned]  # loads are compared where the base is known
    gyros = [late_gyro(robot, each) for each in seen]
    every = alike(gyros, seen)
    known = {one.log: late for one, late in zip(seen, gyros, strict=True) if late}
    for name in [log.name for log in logs] if every else known:
        yield name, as_late(known.get(name) or next(iter(known.values())), every)
    seen = [late.undo(each) if late else each for late, each in zip(gyros, seen, strict=True)]
    unit = moment_unit(robot, seen)
    if unit is not None:
        seen = [unit.undo(each) for each in seen]
        for log in logs:
            yield log.name, as_unit(unit)
    sides = exchanged_contacts(robot, seen)
    if sides is not None:  # what legs bear would contradict it joint by joint
        seen = [sides.undo(each) for each in seen]
        for log in logs:
            yield log.name, as_exchanged(robot, sides)
    points = other_points(robot, seen)
    if points is not None:
        seen = [points.undo(each) for each in seen]
        for log in logs:
            yield from ((log.name, finding) for finding in as_other_points(robot, points))
    for place, (one, gyro) in enumerate(zip(seen, gyros, strict=True)):
        if (late := late_imu_or_contacts(robot, one)) and not (gyro and late.of_imu):
            seen[place] = late.undo(one)
            yield one.log, as_late(late)
    return seen


def _signs_and_zeros(robot: Robot, expected: Sequence[Expected]) -> Iterator[Finding]:
    """What is asked where nothing else was found."""
    if not expected:
        return
    for joint, better in unsure_signs(robot, expected).items():
        yield as_unsure_sign(robot, joint, better)
    for zero in find_zeros(robot, expected):
        yield as_zero(robot, zero)


def looked_at(logs: Sequence[Log], fitted: Collection[str], most: int) -> list[Log]:
    """As many, spread over the fitted ones and then over the others, in their order: those that are held together."""
    chosen = list[int]()
    for own in (True, False):
        places = [k for k, log in enumerate(logs) if (log.name in fitted) is own]
        spread = np.linspace(0, len(places) - 1, min(len(places), most - len(chosen))).astype(int)
        chosen += [places[k] for k in spread]
    return [logs[k] for k in sorted(chosen)]


def examine_one_by_one(
    robot: Robot, logs: Sequence[Log], criteria: Comparing | None = None, imu_late_s: float | None = None
) -> Iterator[tuple[str, Finding]]:
    """(name of the log, finding) of logs with a device on, and of those beyond the ones that are held together: what
    feet and IMU tell of the base, in whose balance no band and no motor is. What a joint bears may be a device's too:
    no more is told of it than a sign. imu_late_s: by which the IMU is late in all other logs."""
    criteria = criteria or Comparing()
    for log, seen in zip(logs, side_by_side(partial(take, robot, criteria=criteria), logs), strict=True):
        yield from ((log.name, finding) for finding in half_measured(robot, log))
        if seen is None:
            continue
        if leg := turned_leg(robot, [seen]):
            yield log.name, as_turned_leg(robot, leg)
        elif turned := imu_findings(robot, [seen]):
            yield log.name, turned[log.name]
        elif sides := exchanged_contacts(robot, [seen]):
            yield log.name, as_exchanged(robot, sides)
        elif late := late_gyro(robot, seen) or late_imu_or_contacts(robot, seen):
            as_others = imu_late_s is not None and abs(late.seconds - imu_late_s) < criteria.delay_least_s
            yield log.name, as_late(late, alike=late.of_imu and as_others)
        elif points := other_points(robot, [seen]):
            yield from ((log.name, finding) for finding in as_other_points(robot, points))
        else:
            for slip in reversed_efforts(Expected(robot, seen)):
                yield log.name, as_finding(robot, slip)


def half_measured(robot: Robot, log: Log) -> Iterator[Finding]:
    """Contact sensors of which some numbers never change while others do, under a robot whose drives are logged: the
    base's moments, which set the scale of every torque, would be wrong by what is not measured."""
    if not robot.tree.floating or not any(joint.actuation != "none" for joint in robot.joints):
        return
    for sensor in robot.contacts:
        told = {axis: log.channels[name] for axis in COMPONENTS if (name := f"ft.{sensor.name}.{axis}") in log.channels}
        still = [axis for axis, values in told.items() if not varies(values)]
        if still and len(still) < len(told):
            detail = f"tells nothing of {', '.join(still)}: what motors give per ampere, and masses, rest on all six"
            advice = (
                "record all six; a robot of whose feet less is known is described as `base: fixed`, if its base stands "
                "still, without what bears it"
            )
            yield Finding("error", f"ft.{sensor.name}", "wrench_incomplete", detail, advice)


def not_judged(robot: Robot, expected: Sequence[Expected]) -> Iterator[Finding]:
    """Of which joints nothing can be said, as none of the logs moves them for long enough."""
    asked = [a for a, joint in enumerate(robot.joints) if joint.actuation != "none" and expected]
    silent = [a for a in asked if not any(each.tells(a) for each in expected)]
    advice = "nothing was held against the description there: record a motion of it before its numbers are believed"
    for a in silent if len(silent) < len(asked) else ():
        channel = f"{DRIVE[robot.joints[a].actuation]}.{robot.joints[a].name}"
        yield Finding(
            "note", channel, "not_judged", "moves too little for its sign, unit and zero to be judged", advice
        )
    if asked and len(silent) == len(asked):
        detail = "no joint moves long enough for signs, units, zeros and columns to be judged"
        yield Finding("warning", "q.*", "not_judged", detail, advice.replace("of it ", ""))


def _late_and_no_slip(
    slips: Sequence[Slip], unlike: Sequence[Unlike], expected: Sequence[Expected]
) -> tuple[list[Slip], list[Unlike], list[Delay]]:
    """Without what is told of single logs whose efforts are of another clock: there some sign or column fits better."""
    of_one = {logs[0] for logs in [*(each.logs for each in slips), *(each.logs for each in unlike)] if len(logs) == 1}
    found = [of_another_clock(each) for each in expected if each.seen.log in of_one and len(expected) > 1]
    delays = [each for each in found if each is not None]
    for slip in slips:  # what leaves less is likelier
        delays = [
            each for each in delays if slip.logs != (each.log,) or each.before * slip.after > each.after * slip.before
        ]
    late = {(each.log,) for each in delays}
    left = [each for each in slips if each.logs not in late]
    return left, [each for each in unlike if each.logs not in late], delays


def _dead_and_no_slip(
    slips: Sequence[Slip], unlike: Sequence[Unlike], expected: Sequence[Expected]
) -> tuple[list[Slip], list[Unlike], list[DeadPosition]]:
    """Without what a position that stays at one number explains; a slip without a free number is told all the same."""
    weak = [slip for slip in slips if not slip.settled or slip.remedy.rule in ("effort_scale", "position_offset")]
    doubted = {(each.axis, log) for each in unlike for log in each.logs}
    doubted |= {(joint, log) for slip in weak for joint in slip.remedy.joints for log in slip.logs}
    named = {(joint, log) for slip in slips if slip not in weak for joint in slip.remedy.joints for log in slip.logs}
    doubted |= {(axis, each.seen.log) for each in expected for axis in each.in_doubt()} - named
    dead = dead_positions(expected, doubted)
    explained = {(axis, each.log) for each in dead for axis in each.axes}

    def stands(axes: Sequence[int], logs: Sequence[str]) -> bool:
        return not explained & {(axis, log) for axis in axes for log in logs}

    left = [slip for slip in slips if slip not in weak or stands(slip.remedy.joints, slip.logs)]
    return left, [each for each in unlike if stands([each.axis], each.logs)], dead


def imu_findings(robot: Robot, seen: Sequence[Snapshot]) -> dict[str, Finding]:
    """log -> what its accelerometer contradicts."""
    found = [(each, up) for each in seen if (up := directions(robot, each)) is not None]
    if world := told_on_floor([up for _, up in found]):  # as a mapping has it: a log that tilts little does not show it
        return {each.log: world for each in seen}
    rules = {each.log: told_on_floor([up]) or next(imu_rules(robot, up), None) for each, up in found}
    return {
        each.log: replace(finding, advice=finding.advice + _or_held(robot, each))
        for each, _ in found
        if (finding := rules[each.log])
    }


def _or_held(robot: Robot, seen: Snapshot) -> str:
    names = [f"q.{joint.name}" for k, joint in enumerate(robot.joints) if seen.held[:, k].any() and seen.alive[k]]
    return f", or a position that stays at one number: {', '.join(names)}" if names else ""


def channel_rules(robot: Robot, expected: Expected) -> Iterator[Finding]:
    seen, tree, criteria = expected.seen, robot.tree, expected.seen.criteria
    moves = expected.moving.sum(axis=0) > 0
    for k, joint in enumerate(robot.joints):
        speed = float(np.quantile(np.abs(seen.dq[:, k]), criteria.high))
        if 0.05 < tree.velocity_limit[k] < np.inf and speed > criteria.beyond_speed * tree.velocity_limit[k]:
            detail = f"turns at {speed:.3g}, {speed / tree.velocity_limit[k]:.2g} times the limit of the description"
            advice = "is it in degrees, on the motor's side of the gear, or is t not in seconds? State it in a mapping"
            yield Finding("error", f"q.{joint.name}", "position_scale", detail, advice, value=speed)
        if joint.actuation == "none":
            continue
        channel, effort = f"{DRIVE[joint.actuation]}.{joint.name}", expected.effort[:, k]
        varies, load = float(np.std(effort)), float(np.std(expected.load[:, k]))
        largest = float(np.quantile(np.abs(effort), criteria.high))
        if (
            seen.still[k]
            and seen.alive[k]
            and varies > criteria.driven * load
            and varies > 0.01 * _limit(tree.effort_limit[k])
            and (moves.any() or varies > 0.1 * _limit(tree.effort_limit[k]))  # where nothing moves, noise varies, too
        ):
            detail = f"is {seen.q[0, k]:.4g} throughout, yet the joint's effort varies by {varies:.3g} N·m"
            advice = "the column is empty or another's: name the one that holds the position"
            yield Finding("error", f"q.{joint.name}", "position_dead", detail, advice, value=float(seen.q[0, k]))
        if not seen.alive[k] and moves[k] and not seen.still[k]:
            detail = "is one number throughout, yet the joint moves, which takes friction at least"
            advice = "name the column that holds it, or say `actuation: none` in robot.yaml"
            passive = joint.actuation == "torque"  # of a joint without a motor a torque of 0 is what it says
            yield Finding("warning" if passive else "error", channel, "effort_dead", detail, advice, value=0.0)
        elif seen.zeros[k] > criteria.mostly:
            detail = f"is exactly 0 in {100 * seen.zeros[k]:.0f} % of the samples in which the joint moves"
            advice = "the drive or its logging was off: cut the log there, or say `actuation: none` in robot.yaml"
            yield Finding("error", channel, "effort_mostly_zero", detail, advice, value=float(seen.zeros[k]))
        elif largest > criteria.beyond_effort * max(_limit(tree.effort_limit[k]), np.abs(expected.load[:, k]).max()):
            detail = f"comes to {largest:.3g} N·m, {largest / tree.effort_limit[k]:.2g} times the description's limit"
            advice = "check its unit (mA, N·mm), its side of the gear and k_T"
            yield Finding("error", channel, "effort_scale", detail, advice, value=largest)


def _limit(stated: float) -> float:
    """inf where none, or no earnest one, is stated."""
    return float(stated) if stated > 1e-3 else np.inf
