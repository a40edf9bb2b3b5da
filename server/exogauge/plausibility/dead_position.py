"""Positions that stay at one number while other joints bear what they would not, were it true."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.relatives import related


@final
@dataclass(frozen=True)
class DeadPosition:
    """joint: whose effort is alive. log: in which. at: [rad or m] where it stays, for `share` of the log.
    axes: which do not bear what is described, the worst first. left: share of its effort that is left.
    """

    joint: int
    log: str
    at: float
    share: float
    axes: tuple[int, ...]
    left: float


def dead_positions(expected: Sequence[Expected], doubted: Set[tuple[int, str]]) -> list[DeadPosition]:
    """doubted: (axis, log) that nothing else explains. Nothing is said where several joints stay so."""
    found = list[DeadPosition]()
    for each in expected:
        axes = [axis for axis, log in sorted(doubted) if log == each.seen.log and each.tells(axis)]
        near = related(each.robot)
        held = {j: [a for a in axes if a in near[j] and a != j and _explains(each, a, j)] for j in _held(each)}
        dead = [joint for joint, its in held.items() if its]
        if len(dead) == 1:
            found.append(_as_found(each, dead[0], held[dead[0]]))
    return found


def _held(each: Expected) -> list[int]:
    seen = each.seen
    return [j for j in range(len(each.robot.joints)) if seen.held[:, j].any() and seen.alive[j]]


def _explains(each: Expected, axis: int, joint: int) -> bool:
    """Throughout, or at all other moments the axis bears what is described."""
    held = each.seen.held[:, joint]
    free = each.at(each.moving & ~held[:, None])
    if not free.tells(axis):
        return True
    return free.left(axis)[0] <= each.seen.criteria.halved * each.left(axis)[0]


def _as_found(each: Expected, joint: int, axes: Sequence[int]) -> DeadPosition:
    held = each.seen.held[:, joint]
    worst = sorted(axes, key=lambda axis: -each.left(axis)[0])
    at = float(np.median(each.seen.q[held, joint]))
    return DeadPosition(joint, each.seen.log, at, float(held.mean()), tuple(worst), each.left(worst[0])[0])
