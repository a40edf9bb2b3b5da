"""Forward step by step: try everything, add what explains most, identify again; then doubt what was added first.

Every effect and site that is worth it is screened by its best shape, refined and judged. The best candidate that may be
claimed is added, with the same effect at other joints that show it beyond doubt, and the robot is identified again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from exogauge.findings.verdict import Objection, Why
from exogauge.identification.equations import Equations
from exogauge.identification.model import Site
from exogauge.identification.result import Identification
from exogauge.identification.sites import AxisSite
from exogauge.progress import Doing
from exogauge.resident import give_back
from exogauge.search.baseline import Ground
from exogauge.search.best_shapes import as_added, judge_best, with_closest_shape
from exogauge.search.candidates import of_measurement
from exogauge.search.creeping import creeping, is_soft
from exogauge.search.doubt import Named, gone, not_worth
from exogauge.search.finding import Told, channel_of, low_passed, name_effect, objection, rejection, tell
from exogauge.search.judge import Judgement
from exogauge.search.locate import channels, pooled
from exogauge.search.noise_taken import noise_taken
from exogauge.search.site_rows import SiteRows, collect_rows
from exogauge.search.state import Key, Problem, Search, Step, rounds_of
from exogauge.search.taken_out import identified_again, without_the_first_betters, without_what_is_not_needed


def searched(problem: Problem) -> Search:
    """All that may be named beside the base, one after the other."""
    search = _forward(Search(problem))
    if search.creeping.below:
        return search
    swapped = without_the_first_betters(search)
    return without_what_is_not_needed(search if swapped is None else _forward(swapped))


def resumed(search: Search, steps: Sequence[Step]) -> Search:
    """From what another search has named, or what is known better now, on."""
    return _forward(identified_again(search, steps))


def _forward(search: Search) -> Search:
    ground: Ground | None
    search, ground = search.screened(search.current)
    while ground is not None:
        search, ground = with_the_best(search.on(ground), ground)
    return search


def with_the_best(search: Search, ground: Ground) -> tuple[Search, Ground | None]:
    """The search with the best candidate that may be claimed, and the next ground; None where there is none."""
    problem = search.problem
    judged, rows = judge_best(ground, problem.recordings, problem.effects)
    named = [each.site for each in search.added]
    search = replace(search, creeping=creeping(search.current, judged, problem.settings.creeping, named))
    if search.creeping.below:
        return search, None
    for each in judged:
        if not each.objection and of_measurement(each.score.candidate.site):
            search = search.asked_of(frozenset(each.logs))
    judged = [_weighed(search, _within_declared(search, each)) for each in judged if not is_soft(each)]
    rejected = tuple(rejection(ground.model, each, each.objection) for each in judged if each.objection)
    search = replace(search, rejected=rejected)
    criteria = problem.settings.criteria
    claimed = [each for each in judged if not each.objection and each.score.candidate.key not in search.failed]
    for first in claimed if len(rounds_of(search.steps)) < criteria.search.most_rounds else []:
        if _acting_on(search, _rows_of(first, ground.model.equations)) >= criteria.search.most_effects:
            continue
        rows = rows or collect_rows(ground.model, problem.recordings, [each.score.candidate.site for each in judged])
        together, judged, noise = _with_its_likes(search, ground, first, claimed, judged, rows)
        winner = together[0]
        if noise:
            search = search.having_failed(winner.score.candidate.key, rejection(ground.model, winner, noise))
            continue
        told = {each.score.candidate.key: tell(ground.model, each, judged, rows) for each in together}
        rows = {}
        give_back()  # what the rows held, which the next ground needs
        while together and together[0] is winner:
            problem.tell(0.0, Doing.ADDING_EFFECT, winner.score.candidate.effect.name)
            added = [*search.added, *(as_added(each.score.candidate) for each in together)]
            found = problem.identified(search.eyes, added)
            after, following = search.screened(found)
            after, refused = _named(after, ground, following, together, told, found)
            if not refused:
                return after, following
            search = _having_refused(replace(search, tried=after.tried, rounds=after.rounds), ground, refused)
            together = [each for each in together if each.score.candidate.key not in search.failed]
    return search, None


def _with_its_likes(
    search: Search, ground: Ground, first: Judgement, claimed: Sequence[Judgement], judged: Sequence[Judgement],
    rows: Mapping[Site, Sequence[SiteRows]],
) -> tuple[list[Judgement], list[Judgement], Objection | None]:  # fmt: skip
    """A round: the claim with its shapes searched to the end, and the same effect where it is as clear; all judgements
    with these in their places; and why the first is nothing but noise, if it is."""
    winner = _weighed(search, with_closest_shape(ground, first, rows))
    judged = [winner if each is first else each for each in judged]
    if noise := _noise_alone(search, ground, winner, rows[winner.score.candidate.site]):
        return [winner], judged, noise
    alike = _as_clear(ground, winner, claimed)
    others = {id(each): _weighed(search, with_closest_shape(ground, each, rows)) for each in alike}
    judged = [others.get(id(each), each) for each in judged]
    beside = [each for each in others.values() if not each.objection
              and not _noise_alone(search, ground, each, rows[each.score.candidate.site])]  # fmt: skip
    return [winner, *beside], judged, None


def _having_refused(search: Search, ground: Ground, refused: Sequence[tuple[Judgement, Objection]]) -> Search:
    for each, why in refused:
        search = search.having_failed(each.score.candidate.key, rejection(ground.model, each, why))
    return search


def _as_clear(ground: Ground, winner: Judgement, claimed: Sequence[Judgement]) -> list[Judgement]:
    """The same effect where other joints show it beyond doubt and nothing explains their rows better: drives of one
    make lack the same. They share no row with the winner, nor with each other, so that none can be another's shadow in
    its own rows."""
    equations, clear = ground.model.equations, ground.model.criteria.search.clear
    effect, taken = winner.score.candidate.effect, _rows_of(winner, equations)
    found = list[Judgement]()
    if winner.score.elsewhere or not isinstance(winner.score.candidate.site, AxisSite):
        return found
    for each in claimed:
        own = _rows_of(each, equations)
        first = not own & taken
        taken |= own  # whatever explains these rows best, they are spoken for
        at_joint = isinstance(each.score.candidate.site, AxisSite) and each.score.candidate.effect is effect
        if first and at_joint and not each.score.elsewhere and each.score.evidence > clear:
            found.append(each)
    return found


def _rows_of(judged: Judgement, equations: Equations) -> set[int]:
    return set(judged.score.candidate.site.kinds(equations))


def _named(
    search: Search,
    ground: Ground,
    following: Ground,
    together: Sequence[Judgement],
    told: Mapping[Key, Told],
    found: Identification,
) -> tuple[Search, list[tuple[Judgement, Objection]]]:
    """With those of a round that hold in the model with all of them; and those that do not."""
    before, refused = search.current, list[tuple[Judgement, Objection]]()
    for each in together:
        candidate = each.score.candidate
        kind = _kind_that_gains(search, each, ground, following)
        without, with_it = (low_passed(one, kind, each.logs) for one in (ground, following))
        size, of_it = gone(without, with_it), told[candidate.key]
        finding = name_effect(len(search.steps) + 1, ground.model, each, of_it, before, found, kind)
        why = objection(finding, without, with_it, search.problem.settings.criteria.judging)
        why = why or _not_worth(search, each, kind, size)
        if why:
            refused.append((each, why))
        else:
            beside = each is not together[0]
            step = Step(as_added(candidate), finding, lambda: found, size, of_it.undecided, beside)
            search = replace(search, steps=(*search.steps, step))
    return search, refused


def _acting_on(search: Search, rows: set[int]) -> int:
    """Rounds in which something was added that acts on any of these rows."""
    equations = search.problem.base.model.equations
    return sum(any(rows & set(each.added.site.kinds(equations)) for each in one) for one in rounds_of(search.steps))


def _within_declared(search: Search, judged: Judgement) -> Judgement:
    """With an objection where it is of what measures, and declared uncertainties explain all that stands above the
    noise where it acts, in the logs that it is about. A joint's effect stays: what is declared may be another one in
    each log, and the effect foretold them all alike."""
    if judged.objection or not of_measurement(judged.score.candidate.site):
        return judged
    equations = search.problem.base.model.equations
    own = {channel_of(equations, kind) for kind in judged.score.candidate.site.kinds(equations)}
    known = search.declared.get(frozenset(judged.logs), {})
    there = tuple(channel for channel in known if channel in own)
    if not there or not all(known[each] for each in there):
        return judged
    return replace(judged, objection=Objection(Why.DECLARED, of=there))


def _weighed(search: Search, judged: Judgement) -> Judgement:
    """With an objection where the effect is real and not worth a name. What other rows gain is seen once the robot is
    identified with it."""
    if judged.objection or judged.score.elsewhere:
        return judged
    judged = judged.shown_by(_clearest(search, judged))
    return replace(judged, objection=_not_worth(search, judged, judged.kind, gone(judged.before, judged.after)))


def _clearest(search: Search, judged: Judgement) -> int:
    """Of the rows that it acts on those that gain most against their noise: of these that lack most, the weights know
    little."""
    told = {judged.kind, *_told(search)}
    floors = {kind: _floor(search, kind) for kind in judged.of_kinds if kind in told}
    sizes = {k: gone(*judged.of_kinds[k]) / floor for k, floor in floors.items() if floor > 0.0}
    return max([judged.kind, *sizes], key=lambda kind: sizes.get(kind, 0.0))


def _kind_that_gains(search: Search, winner: Judgement, before: Ground, after: Ground) -> int:
    """Its own, or where most of the gain lies elsewhere the one that gains most against its noise."""
    if not winner.score.elsewhere:
        return winner.kind
    others = (kind for kind in _told(search) if _floor(search, kind) > 0.0 and _is_seen(before, kind, winner))

    def size(kind: int) -> float:
        return gone(*(low_passed(each, kind, winner.logs) for each in (before, after))) / _floor(search, kind)

    return max([winner.kind, *others], key=size)


def _told(search: Search) -> Sequence[int]:
    """Kinds of rows that have a channel of their own, which rows at rest have not."""
    return list(channels(search.problem.base.model.equations))


def _floor(search: Search, kind: int) -> float:
    base = search.problem.base
    channel = channel_of(base.model.equations, kind)
    return pooled([fit for fit in base.validation if fit.held_out and fit.channel == channel])[1]


def _not_worth(search: Search, judged: Judgement, kind: int, size: float) -> Objection | None:
    candidate, criteria = judged.score.candidate, search.problem.settings.criteria.search
    everywhere = [each for each in search.steps if each.added.effect.name == candidate.effect.name]
    named = [
        Named(each.finding.effect, each.gone, each.added.effect.coordinate == candidate.effect.coordinate)
        for each in search.steps
        if each.added.site == candidate.site and len(everywhere) < criteria.common
    ]
    return not_worth(size, _floor(search, kind), named, criteria)


def _noise_alone(search: Search, ground: Ground, winner: Judgement, rows: Sequence[SiteRows]) -> Objection | None:
    """Where an effect that smooths noise takes that off the error, and nothing that is worth a name beside it."""
    if winner.score.elsewhere:
        return None
    fell, most = winner.before**2 - winner.after**2, _floor(search, winner.kind) ** 2

    def too_little(square: float) -> bool:
        little = square < search.problem.settings.criteria.judging.least * winner.before**2
        return little or _not_worth(search, winner, winner.kind, math.sqrt(max(square, 0.0))) is not None

    if not too_little(fell - most):
        return None
    taken = noise_taken(ground.model, winner, rows, search.problem.recordings)
    return Objection(Why.NOISE_ALONE, taken / max(fell, 1e-300)) if too_little(fell - taken) else None


def _is_seen(ground: Ground, kind: int, judged: Judgement) -> bool:
    """Whether the logs that it was judged on have rows of this kind."""
    return any(np.isfinite(each.residual[kind]).any() for each in ground.residuals
               if each.log in judged.logs and kind in each.residual)  # fmt: skip
