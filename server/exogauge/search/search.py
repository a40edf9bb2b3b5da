"""Forward step by step: try everything, add what explains most, identify again; then doubt what was added first.

Two effects at one place can look like a third before both are in the model. So where a place holds several, each of
the earlier ones is taken out once more, and whatever explains most beside the others takes its place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from exogauge.effects.soft_coulomb import SOFT_COULOMB
from exogauge.findings.objection import Objection, Why
from exogauge.findings.result import Alternative, Finding
from exogauge.identification.identify import identify
from exogauge.identification.model import AddedEffect, Effect, Extension, Site
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress, Recording, Settings
from exogauge.identification.sites import AxisSite, PairSite
from exogauge.identification.validate import floors_of
from exogauge.search.ambiguity import Undecided
from exogauge.search.baseline import Ground, lay_ground
from exogauge.search.candidates import Candidate
from exogauge.search.creeping import Creeping, creeping, is_soft
from exogauge.search.effect_size import Named, gone, not_worth
from exogauge.search.finding import channel_of, low_passed, name_effect, objection, rejection
from exogauge.search.hints import hinted
from exogauge.search.judge import Judgement, judge
from exogauge.search.locate import channels, pooled
from exogauge.search.may_be_named import not_named
from exogauge.search.refine import closely, closest, refined
from exogauge.search.score import Score, score
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of

ON_LOADS = ("load", "drive")  # coordinates of such effects of a joint

Key = tuple[str, Site]


@final
@dataclass(frozen=True)
class Step:
    """One effect that was added: as it is in the model, as it is told, and the model with it. gone: RMS that it takes
    off the held-out error, low-passed [N·m or N]. undecided: what tells it from what it may be, too."""

    added: AddedEffect
    finding: Finding
    found: Identification
    gone: float
    undecided: Undecided | None = None


@final
@dataclass
class Search:
    """base: the robot identified without missing effects. steps: what was added, in order. ground: the last one laid.

    failed: what was added and taken back. rejected: what the last round judged and did not claim. tried: candidates.
    rounds: grounds laid. done: share of the work, as told. only: number of a log; then nothing is tried but what begins
    with it, or sits in it. eyes: the model whose loads effects see; None: the base, and then what comes of it.
    creeping: joints that were found to creep; then the search has stopped, as it has to begin anew without these rows.
    """

    base: Identification
    recordings: Sequence[Recording]
    effects: Sequence[Effect]
    settings: Settings
    progress: Progress
    steps: list[Step] = field(default_factory=list)
    failed: dict[Key, Alternative] = field(default_factory=dict)
    rejected: list[Alternative] = field(default_factory=list)
    first: Ground | None = None
    last: Ground | None = None
    tried: int = 0
    rounds: int = 0
    done: float = 0.0
    only: int | None = None
    eyes: Identification | None = None
    creeping: Creeping = field(default_factory=lambda: Creeping({}, ()))

    @property
    def current(self) -> Identification:
        return self.steps[-1].found if self.steps else self.base

    def run(self) -> None:
        self._forward()
        if self.creeping.below:
            return
        for number in range(len(self.steps)):
            if self._swap(number):
                self._forward()
                break
        self.drop_what_is_not_needed()

    def resume(self, steps: Sequence[Step]) -> None:
        """From what another search has named, or what is known better now, on."""
        self._again(steps)
        self._forward()

    def _forward(self) -> None:
        ground: Ground | None = self._lay(self.current)
        self.first = self.first or ground
        while ground is not None:
            self.last, ground = ground, self._take(ground)

    def _take(self, ground: Ground) -> Ground | None:
        """Add the best that may be claimed, and lay the next ground; None where there is none."""
        judged, rows = judge_best(ground, self.recordings, self.effects)
        named = [each.added.site for each in self.steps]
        self.creeping = creeping(self.current, judged, self.settings.creeping, named)
        if self.creeping.below:
            return None
        judged = [self._weighed(each) for each in judged if not is_soft(each)]
        self.rejected = [rejection(ground.model, each, each.objection) for each in judged if each.objection]
        claimed = [each for each in judged if not each.objection and each.score.candidate.key not in self.failed]
        for first in claimed if len(self.steps) < self.settings.criteria.search.most_effects else []:
            winner = self._weighed(with_closest_shape(ground, first, rows))
            judged = [winner if each is first else each for each in judged]
            candidate = winner.score.candidate
            self._tell(self.done + 0.05, f"adding {candidate.effect.name}")
            added = as_added(candidate)
            found = self.identified([*(step.added for step in self.steps), added])
            following = self._lay(found)
            kind = self._kind_that_gains(winner, ground, following)
            without, with_it = (low_passed(each, kind, winner.logs) for each in (ground, following))
            size = gone(without, with_it)
            rank = len(self.steps) + 1
            finding, undecided = name_effect(rank, ground, winner, judged, self.current, found, rows, kind)
            refused = objection(finding, without, with_it, self.settings.criteria.judging) or self._not_worth(
                winner, kind, size
            )
            if not refused:
                self.steps.append(Step(added, finding, found, size, undecided))
                return following
            self.failed[candidate.key] = rejection(ground.model, winner, refused)
        return None

    def _tell(self, fraction: float, phrase: str) -> None:
        """How much is done, at a guess; never less than before."""
        self.done = max(self.done, min(fraction, 0.99))
        self.progress(self.done, phrase)

    def _weighed(self, judged: Judgement) -> Judgement:
        """With an objection where the effect is real and not worth a name. What other rows gain is seen once the robot
        is identified with it."""
        if judged.objection or judged.score.elsewhere:
            return judged
        judged = judged.shown_by(self._clearest(judged))
        return replace(judged, objection=self._not_worth(judged, judged.kind, gone(judged.before, judged.after)))

    def _clearest(self, judged: Judgement) -> int:
        """Of the rows that it acts on those that gain most against their noise: of these that lack most, the weights
        know little."""
        told = {judged.kind, *channels(self.base.model.equations)}  # rows at rest have no channel of their own
        floors = {kind: self._floor(kind) for kind in judged.of_kinds if kind in told}
        sizes = {k: gone(*judged.of_kinds[k]) / floor for k, floor in floors.items() if floor > 0.0}
        return max([judged.kind, *sizes], key=lambda kind: sizes.get(kind, 0.0))

    def _kind_that_gains(self, winner: Judgement, before: Ground, after: Ground) -> int:
        """Its own, or where most of the gain lies elsewhere the one that gains most against its noise."""
        if not winner.score.elsewhere:
            return winner.kind
        told = channels(self.base.model.equations)  # rows at rest have no channel of their own
        kinds = [winner.kind, *(kind for kind in told if self._floor(kind) > 0.0 and _is_seen(before, kind, winner))]

        def size(kind: int) -> float:
            return gone(*(low_passed(each, kind, winner.logs) for each in (before, after))) / self._floor(kind)

        return max(kinds, key=size)

    def _floor(self, kind: int) -> float:
        channel = channel_of(self.base.model.equations, kind)
        return pooled([fit for fit in self.base.validation if fit.held_out and fit.channel == channel])[1]

    def _not_worth(self, judged: Judgement, kind: int, size: float) -> Objection | None:
        candidate = judged.score.candidate
        elsewhere = [each for each in self.steps if each.added.effect.name == candidate.effect.name]
        named = [
            Named(each.finding.effect, each.gone, each.added.effect.coordinate == candidate.effect.coordinate)
            for each in self.steps
            if each.added.site == candidate.site and len(elsewhere) < self.settings.criteria.search.common
        ]
        return not_worth(size, self._floor(kind), named, self.settings.criteria.search)

    def _swap(self, number: int) -> bool:
        """Whether another effect at the same place explains more than this step's, once the later ones are there."""
        step, others = self.steps[number], [each.added for k, each in enumerate(self.steps) if k != number]
        site = step.added.site
        if not any(each.site == site for each in others):
            return False
        without = self.identified(others)
        ground = self._lay(without, site)
        judged, _ = judge_best(ground, self.recordings, self.effects, site)
        named = next((each for each in judged if each.score.candidate.effect.name == step.added.effect.name), None)
        best = next((each for each in judged if not each.objection), None)
        if best is None or best is named or best.score.candidate.key in self.failed:
            return False
        if named is not None and best.score.evidence < named.score.evidence + self.settings.criteria.search.better:
            return False
        kept = [each for k, each in enumerate(self.steps) if k != number]
        self._take_out(number, Objection(Why.BETTERED, of=_effects(kept)))
        return True

    def drop_what_is_not_needed(self) -> None:
        """Take back an earlier effect that a later one explains too: at its place, or at one that is nearly alike, such
        as another axis of a sensor on a body that turns."""
        number = 0
        while number < len(self.steps) - 1:
            step, kept = self.steps[number], [each for k, each in enumerate(self.steps) if k != number]
            without = self.identified([each.added for each in kept])
            channel = step.finding.held_out.channel
            now, then = (_held_out_rmse(each, channel) for each in (self.current, without))
            if then > self.settings.criteria.search.not_needed * now:
                number += 1
                continue
            self._take_out(number, Objection(Why.NOT_NEEDED, of=_effects(kept[-1:])))

    def take_back(self, number: int, objection: Objection) -> None:
        """One that turned out not to be worth its name once all others were there."""
        self._take_out(number, objection)
        self.last = self._lay(self.current)

    def _take_out(self, number: int, objection: Objection) -> None:
        step, kept = self.steps[number], [each for k, each in enumerate(self.steps) if k != number]
        self.failed[step.added.effect.name, step.added.site] = not_named(step.finding, objection)
        self._again(kept)

    def _again(self, kept: Sequence[Step]) -> None:
        """The same steps without the one that was taken out; their findings keep what was said of them."""
        self.steps = []
        for each in kept:
            found = self.identified([*(step.added for step in self.steps), each.added])
            finding = replace(each.finding, rank=len(self.steps) + 1)
            self.steps.append(replace(each, finding=finding, found=found))

    def identified(self, effects: Sequence[AddedEffect]) -> Identification:
        floors = floors_of(self.base.validation)
        twice = any(_depends_on_loads(each) for each in effects)
        found, passes = self.base, self.settings.criteria.search.relinearised if twice else 1
        if self.eyes is not None:
            found, passes = self.eyes, 1
        for _ in range(passes):
            extension = Extension(found.model, tuple(effects), floors)
            found = identify(self.base.model.robot, self.recordings, self.settings, extension=extension)
        return found

    def _lay(self, found: Identification, at: Site | None = None) -> Ground:
        share = min(self.rounds / 3.0, 0.9)
        self.rounds += 1

        def tick(fraction: float, phrase: str) -> None:
            self._tell(share + 0.2 * fraction, phrase)

        soft = [SOFT_COULOMB] if at is None and self.only is None and not _all_stored(self.recordings) else []
        ground = lay_ground(found.model, self.recordings, [*self.effects, *soft], tick, self.only, at)
        self.tried = max(self.tried, sum(len(each) for each in ground.candidates.values()))
        return ground


def _all_stored(recordings: Sequence[Recording]) -> bool:
    """Whether all were low-passed before they were stored: a filter that is not quite the model's looks soft, too."""
    return all(each.log.stored is not None for each in recordings)


def _is_seen(ground: Ground, kind: int, judged: Judgement) -> bool:
    """Whether the logs that it was judged on have rows of this kind."""
    return any(np.isfinite(each.residual[kind]).any() for each in ground.residuals
               if each.log in judged.logs and kind in each.residual)  # fmt: skip


def _depends_on_loads(added: AddedEffect) -> bool:
    of_motion = isinstance(added.site, AxisSite | PairSite) and added.effect.coordinate not in ON_LOADS
    return not of_motion


def judge_best(
    ground: Ground, recordings: Sequence[Recording], effects: Sequence[Effect], only: Site | None = None
) -> tuple[list[Judgement], Mapping[Site, Sequence[SiteRows]]]:
    """The best shape of every effect and site that is worth it, refined and judged, most evidence first; and the rows
    of their sites. only: at one site."""
    best: dict[Key, list[Score]] = {}
    least, most = ground.model.criteria.judging.worth_judging, ground.model.criteria.search.judged
    for each in ground.scores:
        key = each.candidate.key
        wanted = only is None or each.candidate.site == only
        if wanted and each.evidence > least and (key in best or len(best) < most):
            best.setdefault(key, []).append(each)
    hints = [each for each in hinted(ground, effects) if only is None or each.site == only]
    rows = collect_rows(
        ground.model, recordings, list(dict.fromkeys([site for _, site in best] + [h.site for h in hints]))
    )
    for candidate in hints:
        sums = sums_of(rows[candidate.site], candidate.effect, candidate.shape)
        tried = score(ground.model, candidate, sums, ground.memory)
        known = best[candidate.key][0].evidence if candidate.key in best else least
        if tried is not None and tried.evidence > known:
            best[candidate.key] = [tried]
    judged = []
    for (_, site), scores in best.items():
        judged.append(judge(ground.model, closest(ground.model, scores, rows[site], ground.memory), rows[site]))
    return sorted(judged, key=lambda one: -one.score.evidence), rows


def with_closest_shape(ground: Ground, judged: Judgement, rows: Mapping[Site, Sequence[SiteRows]]) -> Judgement:
    """What is to be added, its shapes searched to the end, if that may still be claimed."""
    own = rows[judged.score.candidate.site]
    closer = judge(
        ground.model,
        refined(ground.model, judged.score, own, ground.memory, closely(ground.model.criteria.search)),
        own,
    )
    return judged if closer.objection else closer


def as_added(candidate: Candidate) -> AddedEffect:
    return AddedEffect(candidate.effect, candidate.site, candidate.shape)


def _effects(steps: Sequence[Step]) -> tuple[str, ...]:
    return tuple(each.finding.effect for each in steps)


def _held_out_rmse(found: Identification, channel: str) -> float:
    return pooled([fit for fit in found.validation if fit.held_out and fit.channel == channel])[0]
