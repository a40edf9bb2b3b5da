"""Whether two feet that both bear the robot stay at rest against each other, as flat feet on a floor do: a joint of a
leg whose sign is wrong turns them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.imu_frame import CERTAIN
from exogauge.plausibility.pooling import pooled
from exogauge.plausibility.remedies import Remedy, reversals
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class TurnedLeg:
    """remedy: the sign of a position that is turned, or of both position and effort. pair: the feet, by number.
    before, after: [rad] rms by which they turn against each other. rivals: joints that explain it as well."""

    remedy: Remedy
    pair: tuple[int, int]
    before: float
    after: float
    rivals: tuple[int, ...] = ()


def turned_leg(robot: Robot, seen: Sequence[Snapshot]) -> TurnedLeg | None:
    """In all of the logs. None where feet are at rest, or turn whatever sign is turned: in a walk they do."""
    if not robot.tree.floating or not seen:
        return None
    criteria = seen[0].criteria
    for pair in combinations(range(len(robot.contacts)), 2):
        before, count = _turning(robot, pair, seen)
        if count == 0:
            continue
        tried = {
            joint: _turning(robot, pair, [reversals(joint)[1].undo(each) for each in seen])[0]
            for joint in sorted({*_leg(robot, pair[0])} ^ {*_leg(robot, pair[1])})
        }
        if not tried:
            continue
        best = min(tried, key=lambda joint: tried[joint])
        times = 2.0 * criteria.independent * count
        at_rest = tried[best] <= min(criteria.halved * before, 2.0 * CERTAIN)  # feet that are points turn as legs do
        if not at_rest or times * np.log(before / tried[best]) < criteria.decisive:
            continue
        close = [joint for joint, left in tried.items() if times * np.log(left / tried[best]) < criteria.undecided]
        rivals = tuple(joint for joint in close if joint != best)
        return TurnedLeg(_with_effort(robot, best, seen), pair, before, tried[best], rivals)
    return None


def _turning(robot: Robot, pair: tuple[int, int], seen: Sequence[Snapshot]) -> tuple[float, int]:
    """[rad] rms, about each log's mean, and moments in which both feet bear."""
    paths, squares = ContactPaths(robot), list[Array]()
    for each in seen:
        force = np.linalg.norm(each.wrenches[..., :3], axis=2)
        both = np.all(force[:, pair] > each.criteria.bears * force.sum(axis=1)[:, None], axis=1)
        if np.mean(both) < each.criteria.most_moments:
            continue
        one, other = (paths.of_components(each.q[both], sensor)[:, :3, :3] for sensor in pair)
        relative = one @ np.swapaxes(other, 1, 2)
        U, _, Vt = np.linalg.svd(relative.mean(axis=0))
        squares.append(0.5 * np.sum((relative - U @ Vt) ** 2, axis=(1, 2)))
    if not squares:
        return 0.0, 0
    every = np.concatenate(squares)
    return float(np.sqrt(np.mean(every) + CERTAIN**2)), len(every)


def _leg(robot: Robot, sensor: int) -> list[int]:
    """Joints from the base to a contact sensor, by number."""
    tree, found = robot.tree, list[int]()
    body = tree.frames[robot.contacts[sensor].frame][0]
    while body >= 0 and tree.dof[body] >= 0:
        found.append(int(tree.dof[body]))
        body = int(tree.parent[body])
    return found


def _with_effort(robot: Robot, joint: int, seen: Sequence[Snapshot]) -> Remedy:
    """Whether the joint's effort has its sign turned too, as where an axis has it in the URDF."""
    _, position, both = reversals(joint)
    fits = {}
    for remedy in (position, both):
        then = [Expected(robot, remedy.undo(each)) for each in seen]
        if not any(each.tells(joint) for each in then):
            return position
        fits[remedy.rule] = pooled(then, joint).described
    return both if fits[both.rule] > fits[position.rule] else position
