"""Contact sensors whose columns were exchanged: moments about the base tell, as the load goes from one to the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot
from exogauge.robots.regressor import regressor

Array = NDArray[np.float64]

MOMENTS = slice(3, 6)  # of the base's rows


@final
@dataclass(frozen=True)
class Exchanged:
    """Two contact sensors, by number. before, after: of how much the moments that they give change, the share that
    bodies as described do not ask for; as it was read, and the other way round."""

    pair: tuple[int, int]
    before: float
    after: float

    def undo(self, seen: Snapshot) -> Snapshot:
        wrenches = seen.wrenches.copy()
        wrenches[:, list(self.pair)] = seen.wrenches[:, list(self.pair[::-1])]
        return replace(seen, wrenches=wrenches)


def exchanged_contacts(robot: Robot, seen: Sequence[Snapshot]) -> Exchanged | None:
    """In all of the logs. None where the load does not go from one to another, so that no moment tells them apart."""
    if not robot.tree.floating or len(robot.contacts) < 2 or not seen:
        return None
    criteria = seen[0].criteria
    asked = [regressor(robot.tree, each.motion)[:, MOMENTS] @ robot.phi_in(each.recording).ravel() for each in seen]
    given = [_moments(robot, each) for each in seen]
    swings = _rms(given)
    before = _rms([a - b for a, b in zip(asked, given, strict=True)])
    if swings <= 0.0 or before < criteria.sides_before * swings:
        return None
    found = []
    for pair in combinations(range(len(robot.contacts)), 2):
        tried = Exchanged(pair, before / swings, 0.0)
        other = [_moments(robot, tried.undo(each)) for each in seen]
        found.append(replace(tried, after=_rms([a - b for a, b in zip(asked, other, strict=True)]) / swings))
    best = min(found, key=lambda each: each.after)
    return best if best.after < criteria.sides_falls * best.before else None


def _moments(robot: Robot, seen: Snapshot) -> Array:
    """(N, 3)"""
    return ContactPaths(robot).effect(seen.q, seen.wrenches)[:, MOMENTS]


def _rms(logs: Sequence[Array]) -> float:
    """About each log's mean: where a centre of mass is not as described, a constant is left."""
    return float(np.sqrt(np.mean(np.concatenate([each - each.mean(axis=0) for each in logs]) ** 2)))
