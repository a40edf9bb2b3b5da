"""What is asked of the detectors, and what they have found so far: frozen values that each detector takes and gives.

The chain of gaps from the first model to the noise floor, and the models' lineage.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import final

import numpy as np

from exogauge.criteria.criteria import Criteria
from exogauge.findings.result import Alternative, ChainStep, Excess, Finding, Lineage, Link, Place, WithinDeclared
from exogauge.findings.verdict import Caveat, Seen
from exogauge.identification.identify import identify
from exogauge.identification.model import Effect
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.validate import unit_of
from exogauge.progress import Progress, unwatched
from exogauge.search.ambiguity import Undecided
from exogauge.search.locate import pooled


@final
@dataclass(frozen=True)
class Question:
    """found: identification of `recordings` without what may be missing. effects: what that may be. touched: whether
    something may have touched the robot. cannot: what could not be judged so far."""

    found: Identification
    recordings: tuple[Recording, ...]
    effects: Sequence[Effect]
    settings: Settings
    progress: Progress = unwatched
    touched: bool = True
    cannot: tuple[Caveat, ...] = ()


@final
@dataclass(frozen=True)
class Searched:
    """What the search for effects says beside its findings. recordings: those that it ended with, in which a log that
    differs from all others is fitted. before, after: channels above their floors. declared: none of `after`. undecided:
    by effect and place."""

    recordings: tuple[Recording, ...]
    before: tuple[Excess, ...]
    after: tuple[Excess, ...]
    declared: WithinDeclared
    seen: tuple[Seen, ...]
    rejected: tuple[Alternative, ...]
    candidates: int
    notes: tuple[Caveat, ...]
    undecided: Mapping[tuple[str, Place], Undecided]


@final
@dataclass(frozen=True)
class SoFar:
    """recordings: with the band that they were stored in, and without the time in which something touched the robot,
    where either was found; whole: with that time.

    models: one for each link of the chain, the last one with all that was named. findings: what is in them, as
    `additions` have it, with what was added without a name. beside: findings that no model needs. doubtful: what was
    looked at and not named. anew: the question to be asked in place of this one, as the answers so far do not hold.
    """

    question: Question
    recordings: tuple[Recording, ...]
    whole: tuple[Recording, ...]
    models: tuple[Identification, ...]
    findings: tuple[Finding, ...] = ()
    additions: tuple[ChainStep, ...] = ()
    beside: tuple[Finding, ...] = ()
    doubtful: tuple[Alternative, ...] = ()
    searched: Searched | None = None
    anew: Question | None = None

    @staticmethod
    def of(question: Question) -> SoFar:
        return SoFar(question, question.recordings, question.recordings, (question.found,))

    @property
    def current(self) -> Identification:
        return self.models[-1]

    @property
    def criteria(self) -> Criteria:
        return self.question.settings.criteria

    def identified(self, recordings: Sequence[Recording]) -> Identification:
        """The robot without missing effects, from other recordings."""
        return identify(self.current.model.robot, recordings, self.question.settings)

    def having(self, findings: Sequence[Finding], rounds: Sequence[int] = ()) -> SoFar:
        """With further findings that are in the models, ranked behind those that there are. rounds: how many came with
        each of these models; one, if not otherwise said."""
        ranked = tuple(replace(each, rank=len(self.findings) + n) for n, each in enumerate(findings, 1))
        counts = rounds or [1] * len(ranked)
        firsts = [ranked[end - count] for end, count in zip(accumulate(counts), counts, strict=True)]
        steps = tuple(ChainStep("effect", each.effect, each.place, count - 1)
                      for each, count in zip(firsts, counts, strict=True))  # fmt: skip
        return replace(self, findings=(*self.findings, *ranked), additions=(*self.additions, *steps))


Detector = Callable[[SoFar], SoFar]
"""Looks for one sort of cause in what the detectors before it have left."""


FLOORS = "floors"


def link(found: Identification, step: ChainStep, channels: Sequence[str], logs: Set[str]) -> Link:
    """step: what was added last. channels: those in question, none for all joint torques. logs: that errors are told
    of."""
    robot = found.model.robot
    joints = [f"tau.{joint.name}" for joint in robot.joints]
    asked = list(dict.fromkeys(channels)) or joints
    each = {name: pooled([fit for fit in found.validation if fit.log in logs and fit.channel == name])
            for name in dict.fromkeys([*asked, *joints])}  # fmt: skip
    known = {name: values for name, values in each.items() if np.isfinite(values[0]) and values[1] > 0.0}
    worst = max(known, key=lambda name: known[name][0] / known[name][1], default="")
    worst_rmse, worst_floor = known.get(worst, (float("nan"), float("nan")))
    worst_unit = unit_of(worst, robot) if worst else ""
    sorts = {(unit_of(name, robot), name.partition(".")[0]) for name in asked}
    if len(sorts) == 1:  # a sensor's moments would drown among joint torques
        rmse, floor = pooled([fit for fit in found.validation if fit.log in logs and fit.channel in asked])
        return Link(step, rmse, floor, worst, worst_rmse, worst_floor, unit_of(asked[0], robot), worst_unit)
    ratios = [known[name][0] / known[name][1] for name in asked if name in known]
    rmse = float(np.sqrt(np.mean(np.square(ratios)))) if ratios else float("nan")
    return Link(step, rmse, 1.0, worst, worst_rmse, worst_floor, FLOORS, worst_unit)


def lineage(additions: Sequence[ChainStep]) -> tuple[Lineage, ...]:
    lines = [Lineage("identified", None, None)]
    for step in additions:
        lines.append(descendant(lines[-1], step))
    return tuple(lines)


def descendant(parent: Lineage, step: ChainStep) -> Lineage:
    return Lineage(f"{parent.version}+{step.identifier}", parent.version, step)
