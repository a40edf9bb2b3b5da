"""What a search has come to: a frozen value. Every step of the search takes one and gives the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import final

from exogauge.criteria.searching import Searching
from exogauge.effects.soft_coulomb import SOFT_COULOMB
from exogauge.findings.result import Alternative, Finding
from exogauge.identification.identify import identify, seen_by_effects
from exogauge.identification.model import AddedEffect, Effect, Extension, Site
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import AxisSite, BaseSite, EncoderSite, PairSite, SensorSite
from exogauge.identification.validate import floors_of
from exogauge.progress import Doing, Progress, unwatched
from exogauge.resident import give_back
from exogauge.search.ambiguity import Undecided
from exogauge.search.baseline import Ground, LogResiduals, lay_ground
from exogauge.search.creeping import Creeping
from exogauge.search.declared import explained

ON_LOADS = ("load", "drive")  # coordinates of effects of a joint that depend on what the bodies weigh

Key = tuple[str, Site]


@final
@dataclass(frozen=True)
class Step:
    """One effect that was added: as it is in the model, as it is told, and the model with it. gone: RMS that it takes
    off the held-out error, low-passed [N·m or N]. undecided: what tells it from what it may be, too. beside: whether it
    was added with the one before it, in one round: then the model is that with all of the round.

    identified: gives that model, the same whenever it is asked. Of a chain that is gone through again only the last may
    ever be asked for, and each takes as long as the whole robot.
    """

    added: AddedEffect
    finding: Finding
    identified: Callable[[], Identification]
    gone: float
    undecided: Undecided | None = None
    beside: bool = False

    @property
    def found(self) -> Identification:
        return self.identified()


def rounds_of(steps: Sequence[Step]) -> list[list[Step]]:
    """Those that were added together."""
    rounds = list[list[Step]]()
    for each in steps:
        if each.beside and rounds:
            rounds[-1].append(each)
        else:
            rounds.append([each])
    return rounds


@final
@dataclass(frozen=True)
class Problem:
    """base: the robot identified without missing effects, from `recordings`. effects: what may be missing. tell: of
    the share of the work that is done, at a guess. only: number of a log; then nothing is tried but
    what begins with it, or sits in it."""

    base: Identification
    recordings: Sequence[Recording]
    effects: Sequence[Effect]
    settings: Settings
    tell: Progress = unwatched
    only: int | None = None

    def identified(self, eyes: Identification | None, effects: Sequence[AddedEffect]) -> Identification:
        """The robot with these effects. eyes: as of `Search`."""
        robot, floors = self.base.model.robot, floors_of(self.base.validation)
        seen_by = (eyes or self.base).model
        for _ in range(0 if eyes else _passes(self.settings.criteria.search, effects) - 1):
            seen = Extension(seen_by, tuple(effects), floors)
            seen_by = seen_by_effects(robot, self.recordings, self.settings, seen)
        found = identify(robot, self.recordings, self.settings, extension=Extension(seen_by, tuple(effects), floors))
        give_back()
        return found


@final
@dataclass(frozen=True)
class Search:
    """steps: what was added, in order. failed: what was added and taken back. rejected: what the last round judged and
    did not claim. first, last: what the first and the last ground have left; memory: of the latter's `Baseline`. tried:
    candidates. rounds: grounds laid. eyes: the model whose loads effects see; None: the base, and then what comes of
    it. creeping: joints that were found to creep; then the search has stopped, as it has to begin anew without these
    rows. declared: of logs that were asked, channels that stand above their noise, and whether declared uncertainties
    explain all of that.
    """

    problem: Problem
    steps: tuple[Step, ...] = ()
    failed: Mapping[Key, Alternative] = field(default_factory=dict)
    rejected: tuple[Alternative, ...] = ()
    first: tuple[LogResiduals, ...] = ()
    last: tuple[LogResiduals, ...] = ()
    memory: Mapping[int, float] = field(default_factory=dict)
    tried: int = 0
    rounds: int = 0
    eyes: Identification | None = None
    creeping: Creeping = field(default_factory=lambda: Creeping({}, ()))
    declared: Mapping[frozenset[str], Mapping[str, bool]] = field(default_factory=dict)

    @property
    def current(self) -> Identification:
        return self.steps[-1].found if self.steps else self.problem.base

    @property
    def added(self) -> list[AddedEffect]:
        return [each.added for each in self.steps]

    def before(self, number: int) -> Identification:
        """The model without this step, and without what was added with it or later."""
        rounds = rounds_of(self.steps[: number + 1])
        return rounds[-2][-1].found if len(rounds) > 1 else self.problem.base

    def without(self, number: int) -> list[Step]:
        """All steps but one."""
        return [each for k, each in enumerate(self.steps) if k != number]

    def asked_of(self, logs: frozenset[str]) -> Search:
        """Knowing what declared uncertainties of the measurement explain in these logs before anything is named."""
        if not self.first or logs in self.declared:
            return self
        found = explained(self.problem.base, self.first, self.problem.recordings, logs)
        return replace(self, declared={**self.declared, logs: found})

    def on(self, ground: Ground) -> Search:
        """With what this ground found left."""
        first = self.first or ground.residuals
        return replace(self, first=first, last=ground.residuals, memory=ground.baseline.memory)

    def having_failed(self, key: Key, why: Alternative) -> Search:
        return replace(self, failed={**self.failed, key: why})

    def when_asked(self, effects: Sequence[AddedEffect]) -> Callable[[], Identification]:
        """The robot with these effects, identified the first time that it is asked for."""
        return cache(partial(self.problem.identified, self.eyes, effects))

    def screened(self, found: Identification, at: Site | None = None) -> tuple[Search, Ground]:
        """Every candidate scored beside this model; at one site only, if it is given."""
        problem, share = self.problem, min(self.rounds / 3.0, 0.9)
        soft = [SOFT_COULOMB] if at is None and problem.only is None and not _all_stored(problem.recordings) else []

        def tick(fraction: float, doing: Doing, of: str = "") -> None:
            problem.tell(share + 0.2 * fraction, doing, of)

        ground = lay_ground(found.model, problem.recordings, [*problem.effects, *soft], tick, problem.only, at)
        give_back()
        tried = max(self.tried, sum(len(each) for each in ground.candidates.values()))
        return replace(self, rounds=self.rounds + 1, tried=tried), ground


def _passes(criteria: Searching, effects: Sequence[AddedEffect]) -> int:
    if any(isinstance(each.site, BaseSite | EncoderSite) for each in effects):
        return criteria.turned
    return criteria.relinearised if any(_depends_on_loads(each) for each in effects) else 1


def _all_stored(recordings: Sequence[Recording]) -> bool:
    """Whether all were low-passed before they were stored: a filter that is not quite the model's looks soft, too."""
    return all(each.log.stored is not None for each in recordings)


def _depends_on_loads(added: AddedEffect) -> bool:
    if isinstance(added.site, SensorSite) and added.site.contact:
        return False
    of_motion = isinstance(added.site, AxisSite | PairSite) and added.effect.coordinate not in ON_LOADS
    return not of_motion
