"""About which point a foot's moments are told: the frame of its sensor, or the ankle, or another place of the foot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.plausibility.base_fit import BaseFit
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot, WrenchSensor

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class OtherPoints:
    """places: of each contact sensor, where its moments fit: the name of a frame or a joint, and (3,) [m] the place
    in the sensor's frame; None where they fit as described. evidence: gain in log likelihood."""

    places: tuple[tuple[str, Array] | None, ...]
    evidence: float

    def undo(self, seen: Snapshot) -> Snapshot:
        """The moment about the frame's origin is that about a place p, and p × F."""
        wrenches, late = seen.wrenches.copy(), seen.late_wrenches.copy()
        for sensor, place in enumerate(self.places):
            if place is not None:
                for each in (wrenches, late):
                    each[..., sensor, 3:] += np.cross(place[1], each[..., sensor, :3])
        return replace(seen, wrenches=wrenches, late_wrenches=late)


def other_points(robot: Robot, seen: Sequence[Snapshot]) -> OtherPoints | None:
    """In all of the logs. None where bodies that are off by as much as stated, and sensors' zeros, explain it, or where
    some other point explains far more than any of those that are tried."""
    if not robot.tree.floating or not robot.contacts or not seen:
        return None
    if not all(_measured(each.wrenches) for each in seen):
        return None
    criteria = seen[0].criteria
    places = [_places(robot, sensor, criteria.apart_m) for sensor in robot.contacts]
    fit = BaseFit(robot, seen, about_contacts=True)
    if fit.swings <= 0.0 or all(len(each) == 1 for each in places):
        return None
    columns = []
    for sensor, axis in product(range(len(robot.contacts)), np.eye(3)):
        levers = [np.zeros_like(each.wrenches) for each in seen]
        for lever, each in zip(levers, seen, strict=True):
            lever[:, sensor, 3:] = np.cross(axis, each.wrenches[:, sensor, :3])
        columns.append(fit.of_wrenches(levers))
    tried = list(product(*places))
    found, most = fit.likelihood(
        np.stack(columns, axis=1), np.array([np.concatenate([p for _, p in each]) for each in tried])
    )
    best = int(np.argmax(found))
    evidence = float(found[best] - found[0])
    if evidence < criteria.decisive or most - found[best] > criteria.decisive:
        return None
    return OtherPoints(tuple(each if each[1].any() else None for each in tried[best]), evidence)


def _measured(wrenches: Array) -> bool:
    """Whether moments are: of a foot that tells forces alone they are one number."""
    force, moment = (np.ptp(wrenches[..., some], axis=0) for some in (slice(3), slice(3, 6)))
    return bool(np.all(moment.min(axis=1) > 0.0, where=force.max(axis=1) > 0.0))


def _places(robot: Robot, sensor: WrenchSensor, apart_m: float) -> list[tuple[str, Array]]:
    """The sensor's own frame first; then the joint that moves its link, the joint before it, where that is with the
    joint at zero, and other frames of the link."""
    body, pose = robot.tree.frames[sensor.frame]
    found = [(sensor.frame, np.zeros(3))]
    if body < 0 or robot.tree.dof[body] < 0:
        return found
    near = [(f"the joint {robot.tree.joints[robot.tree.dof[body]]}", np.zeros(3))]
    parent = int(robot.tree.parent[body])
    if parent >= 0 and robot.tree.dof[parent] >= 0:
        before = (robot.tree.T_before[body] * robot.tree.T_after[body]).inverse().translation
        near.append((f"the joint {robot.tree.joints[robot.tree.dof[parent]]}", before))
    near += [(name, each.translation) for name, (of, each) in robot.tree.frames.items() if of == body]
    for name, place in near:
        seen = np.asarray(pose.actInv(place))
        if all(float(np.linalg.norm(seen - other)) > apart_m for _, other in found):
            found.append((name, seen))
    return found
