"""Doubt what was added first: what another effect explains better, or a later one explains too, is taken back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.findings.objection import Objection, Why
from exogauge.identification.result import Identification
from exogauge.search.locate import pooled
from exogauge.search.may_be_named import not_named
from exogauge.search.screen import judge_best
from exogauge.search.state import Search, Step


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
    while number < len(search.steps) - 1:
        step, kept = search.steps[number], search.without(number)
        without = search.identified([each.added for each in kept])
        channel = step.finding.held_out.channel
        now, then = (_held_out_rmse(each, channel) for each in (search.current, without))
        if then > criteria.not_needed * now:
            number += 1
        else:
            search = taken_out(search, number, Objection(Why.NOT_NEEDED, of=_effects(kept[-1:])))
    return search


def taken_back(search: Search, number: int, objection: Objection) -> Search:
    """Without one that turned out not to be worth its name once all others were there."""
    search = taken_out(search, number, objection)
    search, ground = search.screened(search.current)
    return replace(search, last=ground)


def taken_out(search: Search, number: int, objection: Objection) -> Search:
    step = search.steps[number]
    search = search.having_failed((step.added.effect.name, step.added.site), not_named(step.finding, objection))
    return identified_again(search, search.without(number))


def identified_again(search: Search, kept: Sequence[Step]) -> Search:
    """With these steps, one after the other; their findings keep what was said of them."""
    search = replace(search, steps=())
    for rank, each in enumerate(kept, 1):
        found = search.identified([*search.added, each.added])
        step = replace(each, finding=replace(each.finding, rank=rank), found=found)
        search = replace(search, steps=(*search.steps, step))
    return search


def _effects(steps: Sequence[Step]) -> tuple[str, ...]:
    return tuple(each.finding.effect for each in steps)


def _held_out_rmse(found: Identification, channel: str) -> float:
    return pooled([fit for fit in found.validation if fit.held_out and fit.channel == channel])[0]
