"""What needs no comparison: channels without life, efforts and speeds that the robot cannot have."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from exogauge.identification.preparation import DRIVE
from exogauge.logs.findings import Finding
from exogauge.plausibility.expectation import Expected
from exogauge.robots.description import Robot


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
