"""Forward step by step: try everything, add what explains most, identify again; then doubt what was added first.

Every effect and site that is worth it is screened by its best shape, refined and judged; shapes that a grid cannot
hold, such as the order of a ripple, are read off the residuals. The best candidate that may be claimed is added, and
the robot is identified again with it.

Two effects at one place can look like a third before both are in the model. So where a place holds several, each of
the earlier ones is taken out once more, and whatever explains most beside the others takes its place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from exogauge.findings.verdict import Objection, Why
from exogauge.identification.equations import Equations
from exogauge.identification.model import AddedEffect, Effect, Site
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording
from exogauge.identification.sites import AxisSite
from exogauge.progress import Doing
from exogauge.resident import give_back
from exogauge.search.baseline import Ground
from exogauge.search.candidates import Candidate
from exogauge.search.creeping import creeping, is_soft
from exogauge.search.doubt import Named, gone, not_worth
from exogauge.search.final_numbers import place_of
from exogauge.search.finding import Told, channel_of, low_passed, name_effect, objection, rejection, tell
from exogauge.search.judge import Judgement, judge, not_named
from exogauge.search.locate import channels, pooled
from exogauge.search.noise_taken import noise_taken
from exogauge.search.refine import closely, closest, refined, with_it
from exogauge.search.score import Score, score
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of
from exogauge.search.state import Key, Problem, Search, Step, rounds_of
from exogauge.side_by_side import each as side_by_side


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
    search = replace(search, first=search.first or ground)
    while ground is not None:
        search = replace(search, last=ground)
        search, ground = with_the_best(search, ground)
    return search


def with_the_best(search: Search, ground: Ground) -> tuple[Search, Ground | None]:
    """The search with the best candidate that may be claimed, and the next ground; None where there is none."""
    problem = search.problem
    judged, rows = judge_best(ground, problem.recordings, problem.effects)
    named = [each.site for each in search.added]
    search = replace(search, creeping=creeping(search.current, judged, problem.settings.creeping, named))
    if search.creeping.below:
        return search, None
    judged = [_weighed(search, each) for each in judged if not is_soft(each)]
    rejected = tuple(rejection(ground.model, each, each.objection) for each in judged if each.objection)
    search = replace(search, rejected=rejected)
    criteria = problem.settings.criteria
    claimed = [each for each in judged if not each.objection and each.score.candidate.key not in search.failed]
    rounds = sum(not each.beside for each in search.steps)
    for first in claimed if rounds < criteria.search.most_effects else []:
        rows = rows or collect_rows(ground.model, problem.recordings, [each.score.candidate.site for each in judged])
        winner = _to_the_end(search, ground, first, rows)
        judged = [winner if each is first else each for each in judged]
        noise = _noise_alone(search, ground, winner, rows[winner.score.candidate.site])
        if noise:
            search = search.having_failed(winner.score.candidate.key, rejection(ground.model, winner, noise))
            continue
        others = {id(each): _to_the_end(search, ground, each, rows) for each in _as_clear(ground, winner, claimed)}
        judged = [others.get(id(each), each) for each in judged]
        beside = [each for each in others.values() if not each.objection
                  and not _noise_alone(search, ground, each, rows[each.score.candidate.site])]  # fmt: skip
        told = {each.score.candidate.key: tell(ground.model, each, judged, rows) for each in (winner, *beside)}
        rows = {}
        give_back()  # what the rows held, which the next ground needs
        search, following = _with_all(search, ground, [winner, *beside], told)
        if following is not None:
            return search, following
    return search, None


def _to_the_end(
    search: Search, ground: Ground, judged: Judgement, rows: Mapping[Site, Sequence[SiteRows]]
) -> Judgement:
    """With its shapes searched to the end, and an objection where it is not worth a name."""
    return _weighed(search, with_closest_shape(ground, judged, rows))


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


def _with_all(
    search: Search, ground: Ground, batch: Sequence[Judgement], told: Mapping[Key, Told]
) -> tuple[Search, Ground | None]:
    """With those of a round that hold once the robot is identified with all of them, and the next ground; None where
    the first does not hold, and with it none is added."""
    begun, before = search, search.current
    search.problem.tell(0.0, Doing.ADDING_EFFECT, batch[0].score.candidate.effect.name)
    after = search.identified([*search.added, *(as_added(each.score.candidate) for each in batch)])
    search, following = search.screened(after)
    refused = dict[Key, Objection]()
    for number, each in enumerate(batch):
        key = each.score.candidate.key
        kind = _kind_that_gains(search, each, ground, following)
        without, with_it = (low_passed(one, kind, each.logs) for one in (ground, following))
        size = gone(without, with_it)
        finding = name_effect(len(search.steps) + 1, ground.model, each, told[key], before, after, kind)
        objecting = objection(finding, without, with_it, search.problem.settings.criteria.judging)
        objecting = objecting or _not_worth(search, each, kind, size)
        if objecting:
            refused[key] = objecting
            continue
        step = Step(as_added(each.score.candidate), finding, after, size, told[key].undecided, beside=number > 0)
        search = replace(search, steps=(*search.steps, step))
    if not refused:
        return search, following
    for each in batch:
        key = each.score.candidate.key
        if key in refused:
            begun = begun.having_failed(key, rejection(ground.model, each, refused[key]))
    held = [each for each in batch if each.score.candidate.key not in refused]
    begun = replace(begun, tried=search.tried, rounds=search.rounds)
    return _with_all(begun, ground, held, told) if batch[0] in held else (begun, None)


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


def judge_best(
    ground: Ground, recordings: Sequence[Recording], effects: Sequence[Effect], only: Site | None = None
) -> tuple[list[Judgement], Mapping[Site, Sequence[SiteRows]]]:
    """The best shape of every effect and site that is worth it, refined and judged, most evidence first; and the rows
    of their sites. only: at one site."""
    best: dict[tuple[str, Site], list[Score]] = {}
    least, most = ground.model.criteria.judging.worth_judging, ground.model.criteria.search.judged
    for each in ground.scores:
        key = each.candidate.key
        wanted = only is None or each.candidate.site == only
        if wanted and each.evidence > least and (key in best or len(best) < most):
            best.setdefault(key, []).append(each)
    hints = [each for each in hinted(ground, effects) if only is None or each.site == only]
    rows = collect_rows(ground.model, recordings, [site for _, site in best] + [each.site for each in hints])
    for candidate in hints:
        sums = sums_of(rows[candidate.site], candidate.effect, candidate.shape)
        tried = score(ground.baseline, candidate, sums)
        known = best[candidate.key][0].evidence if candidate.key in best else least
        if tried is not None and tried.evidence > known:
            best[candidate.key] = [tried]

    def judged(scores: Sequence[Score]) -> Judgement:
        own = rows[scores[0].candidate.site]
        return judge(ground.model, closest(ground.baseline, scores, own), own)

    return sorted(side_by_side(judged, best.values()), key=lambda one: -one.score.evidence), rows


def with_closest_shape(ground: Ground, judged: Judgement, rows: Mapping[Site, Sequence[SiteRows]]) -> Judgement:
    """What is to be added, its shapes searched to the end, if that may still be claimed."""
    own, found = rows[judged.score.candidate.site], judged.score
    baseline = with_it(ground.baseline, found, own)
    begun = score(baseline, found.candidate, sums_of(own, found.candidate.effect, found.candidate.shape))
    if begun is None:
        return judged
    end = refined(baseline, begun, own, closely(ground.model.criteria.search))
    closer = judge(ground.model, replace(end, evidence=found.evidence), own)
    return judged if closer.objection else closer


def as_added(candidate: Candidate) -> AddedEffect:
    return AddedEffect(candidate.effect, candidate.site, candidate.shape)


Array = NDArray[np.float64]


@runtime_checkable
class Promising(Protocol):
    """An effect that can read candidates for its first shape off residuals over the position."""

    def promising(self, position: Array, residual: Array, span: float) -> Sequence[float]: ...


def hinted(ground: Ground, effects: Sequence[Effect]) -> Iterator[Candidate]:
    """Candidates whose shape the fitted residuals suggest, where they would explain more than chance."""
    least = ground.model.criteria.search.hint
    fitted = [each for each in ground.residuals if not each.held_out]
    for effect in effects:
        if not isinstance(effect, Promising):
            continue
        for site in ground.candidates:
            if not isinstance(site, AxisSite) or not any(each.effect is effect for each in ground.candidates[site]):
                continue
            kind = ground.model.equations.layout.axis(site.axis)
            known = [each for each in fitted if kind in each.residual]
            if not known:
                continue
            residual = np.concatenate([each.residual[kind] for each in known])
            position = np.concatenate([each.axes[site.axis].position for each in known])
            ok, span = np.isfinite(residual), float(ground.model.sizes.range[site.axis])
            if ok.sum() < 100:
                continue
            for cycles in effect.promising(position[ok], residual[ok], span):
                if _gain(position[ok], residual[ok], 2.0 * np.pi * cycles / span, ground.baseline.memory[kind]) > least:
                    yield Candidate(effect, site, (cycles,))


def _gain(position: Array, residual: Array, order: float, memory: float) -> float:
    """Twice the log likelihood gained by a sine and a cosine of the position, with coloured residuals."""
    waves = np.column_stack([np.sin(order * position), np.cos(order * position), np.ones_like(position)])
    left = residual - waves @ np.linalg.lstsq(waves, residual, rcond=None)[0]
    centred = residual - residual.mean()
    return float(len(residual) / memory * np.log(max(centred @ centred, 1e-300) / max(left @ left, 1e-300)))


def without_the_first_betters(search: Search) -> Search | None:
    """Without the first step whose place another effect takes better, once the later ones are there; None where all
    hold."""
    for number in range(len(search.steps)):
        why = _bettered(search, number)
        if why is not None:
            return taken_out(search, number, why)
    return None


def _bettered(search: Search, number: int) -> Objection | None:
    """Whether another effect at the same place explains more than this step's."""
    problem, step, others = search.problem, search.steps[number], search.without(number)
    site = step.added.site
    if not any(each.added.site == site for each in others):
        return None
    _, ground = search.screened(search.identified([each.added for each in others]), site)
    judged, _ = judge_best(ground, problem.recordings, problem.effects, site)
    named = next((each for each in judged if each.score.candidate.effect.name == step.added.effect.name), None)
    best = next((each for each in judged if not each.objection), None)
    if best is None or best is named or best.score.candidate.key in search.failed:
        return None
    lead = problem.settings.criteria.search.better
    if named is not None and best.score.evidence < named.score.evidence + lead:
        return None
    return Objection(Why.BETTERED, of=_effects(others))


def without_what_is_not_needed(search: Search) -> Search:
    """An earlier effect that a later one explains too goes: at its place, or at one that is nearly alike, such as
    another axis of a sensor on a body that turns."""
    criteria, number = search.problem.settings.criteria.search, 0
    while number < len(search.steps) - 1 or (search.steps[number:] and search.steps[number].beside):
        step, kept = search.steps[number], search.without(number)
        if _surely_needed(search, number):
            number += 1
            continue
        without = search.identified([each.added for each in kept])
        channel = step.finding.held_out.channel
        now, then = (_held_out_rmse(each, channel) for each in (search.current, without))
        if then > criteria.not_needed * now:
            number += 1
        else:
            search = taken_out(search, number, Objection(Why.NOT_NEEDED, of=_effects(kept[-1:])))
    return search


def _surely_needed(search: Search, number: int) -> bool:
    """Whether the fitted rows that it acts on miss it so much, all else fitted anew, that held-out ones need not be
    asked, which takes an identification."""
    added, solution = search.steps[number].added, search.current.model.solution
    own = np.arange(len(solution.unbounded.x))[place_of(search.current.model, added)]
    unit = np.zeros((len(solution.unbounded.x), len(own)))
    unit[own, np.arange(len(own))] = 1.0
    doubt = solution.unbounded.divided(unit)
    x = solution.unbounded.x - doubt @ np.linalg.lstsq(doubt[own], solution.unbounded.x[own], rcond=None)[0]
    kinds = [kind for kind in added.site.kinds(search.current.model.equations) if solution.weights[kind] > 0.0]
    then, now = (sum(solution.weights[k] * solution.statistics.left(k, at) for k in kinds)
                 for at in (x, solution.unbounded.x))  # fmt: skip
    return bool(then > search.problem.settings.criteria.search.surely_needed**2 * now)


def taken_back(search: Search, number: int, objection: Objection) -> Search:
    """Without one that turned out not to be worth its name once all others were there."""
    search = taken_out(search, number, objection)
    search, ground = search.screened(search.current)
    return replace(search, last=ground)


def taken_out(search: Search, number: int, objection: Objection) -> Search:
    step = search.steps[number]
    search = search.having_failed((step.added.effect.name, step.added.site), not_named(step.finding, objection))
    return identified_again(search, search.steps[number + 1 :], search.steps[:number])


def identified_again(search: Search, kept: Sequence[Step], begun: tuple[Step, ...] = ()) -> Search:
    """With these steps, one round after the other; their findings keep what was said of them. begun: those before them,
    which stay as they are."""
    search = replace(search, steps=begun)
    for together in rounds_of(kept):
        found = search.identified([*search.added, *(each.added for each in together)])
        first = len(search.steps) + 1
        steps = [replace(each, finding=replace(each.finding, rank=rank), found=found, beside=rank > first)
                 for rank, each in enumerate(together, first)]  # fmt: skip
        search = replace(search, steps=(*search.steps, *steps))
    return search


def _effects(steps: Sequence[Step]) -> tuple[str, ...]:
    return tuple(each.finding.effect for each in steps)


def _held_out_rmse(found: Identification, channel: str) -> float:
    return pooled([fit for fit in found.validation if fit.held_out and fit.channel == channel])[0]
