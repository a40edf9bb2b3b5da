"""Numbers of the maker that the data contradict by more than he doubts them: a payload, a part that was changed, a
motor that gives other than its data sheet says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.detect.nominal.nominal_values import Array, Stated, stated_numbers
from exogauge.identification.model import RobotModel
from exogauge.logs.model import Log
from exogauge.robots.kinematics import forward
from exogauge.search.correlation_time import row_memory

THINNED = 500  # samples of a log looked at


@final
@dataclass(frozen=True)
class Change:
    """A number that is let go. evidence: twice the log likelihood ratio for that. value, std: (k,) of the change, of a
    link its ten parameters [kg, kg·m, kg·m²], of a gain its share. sure: enough of it for a name."""

    stated: Stated
    evidence: float
    value: Array
    std: Array
    sure: bool

    @property
    def of_link(self) -> bool:
        return self.stated.sort in ("load", "scaled")


@final
@dataclass(frozen=True)
class Contradiction:
    """The number whose change explains best why the data lie far from the prior, and those that would do as well.

    or_all_gains: one factor on all gains would, too.
    """

    best: Change
    alike: tuple[Change, ...]
    others: tuple[Change, ...]
    or_all_gains: bool


def contradicted(model: RobotModel, logs: Sequence[Log]) -> list[Contradiction]:
    """One after the other: what the first explains is taken out before the next is sought. logs: the fitted ones.

    A link that hardly tilts in them, such as a foot on the ground, is never claimed: its columns hold the noise of the
    measured acceleration, which the residual holds too. Where one factor on all gains explains more than any of them,
    none is to blame.
    """
    criteria = model.criteria
    numbers, data = stated_numbers(model, _tilting(model, logs), row_memory(model, logs))
    found: list[Contradiction] = []
    while len(found) < min(criteria.nominal.most, len({_key(each) for each in numbers if each.sort != "gains"})):
        changes = []
        for stated in numbers:
            let = data.let(stated.columns)
            changes.append(_change(model, stated, let.evidence, let.change * stated.broad, let.std * stated.broad))
        ordered, common = _best_of_each(changes)
        best = ordered[0]
        if not best.sure or (not best.of_link and common > best.evidence):
            break
        alike = tuple(each for each in ordered[1:] if best.evidence - each.evidence < criteria.judging.open)
        others = tuple(each for each in ordered[1:3] if each not in alike)
        found.append(Contradiction(best, alike, others, best.evidence - common < criteria.judging.open))
        data = data.without(best.stated.columns)
        numbers = [each for each in numbers if _key(each) != _key(best.stated)]
    return found


def _change(model: RobotModel, stated: Stated, evidence: float, value: Array, std: Array) -> Change:
    if stated.sort == "scaled":
        own = model.robot.tree.phi[stated.index]
        value, std = value * own, std * np.abs(own)
    criteria = model.criteria
    significant = bool(abs(value[0]) >= criteria.judging.significant * std[0])
    return Change(stated, evidence, value, std, evidence >= criteria.nominal.sure and significant)


def _best_of_each(changes: Sequence[Change]) -> tuple[list[Change], float]:
    """Of every link the change that explains more, of those that say whether it is heavier where there are such, most
    evidence first; and the evidence for all gains alike."""
    first: dict[tuple[bool, int], Change] = {}
    common = -np.inf
    for each in sorted(changes, key=lambda each: (not each.sure, -each.evidence)):
        if each.stated.sort == "gains":
            common = each.evidence
        else:
            first.setdefault(_key(each.stated), each)
    return sorted(first.values(), key=lambda each: -each.evidence), common


def _key(stated: Stated) -> tuple[bool, int]:
    return stated.sort in ("load", "scaled"), stated.index


def _tilting(model: RobotModel, logs: Sequence[Log]) -> list[int]:
    """Indices of bodies across which gravity turns enough to show what they weigh."""
    criteria = model.criteria.nominal
    up, turning = [], []
    for log in logs:
        prepared = model.prepare(log)
        turning.append(prepared.motion.gyro[prepared.kept])
        kept = prepared.kept[:: max(1, len(prepared.kept) // THINNED)]
        pulled = forward(model.robot.tree, prepared.motion.rows(kept)).proper_acceleration
        up.append(pulled / np.maximum(np.linalg.norm(pulled, axis=2, keepdims=True), 1e-12))
    if model.robot.floating and np.sqrt(np.mean(np.concatenate(turning) ** 2)) < criteria.base_turns:
        return []  # all that its accelerometer says beside gravity is noise
    spread = np.sqrt(np.sum(np.var(np.concatenate(up), axis=0), axis=1))
    return [body for body, each in enumerate(spread) if each > criteria.tilts]
