"""What was named is doubted once more is in the model, and taken out where it does not hold.

Two effects at one place can look like a third before both are in the model. So where a place holds several, each of
the earlier ones is taken out once more, and whatever explains most beside the others takes its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exogauge.findings.verdict import Objection, Why
from exogauge.identification.result import Identification
from exogauge.search.best_shapes import judge_best
from exogauge.search.final_numbers import place_of
from exogauge.search.judge import not_named
from exogauge.search.locate import pooled
from exogauge.search.state import Search, Step, rounds_of


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
    _, ground = search.screened(search.problem.identified(search.eyes, [each.added for each in others]), site)
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
        if _surely_needed(search, number):
            number += 1
            continue
        step, others = search.steps[number], search.without(number)
        without = taken_out(search, number, Objection(Why.NOT_NEEDED, of=_effects(others[-1:])))
        channel = step.finding.held_out.channel
        now, then = (_held_out_rmse(each.current, channel) for each in (search, without))
        if then > criteria.not_needed * now:
            number += 1
        else:
            search = without
    return search


def _surely_needed(search: Search, number: int) -> bool:
    """Whether the fitted logs miss it so much, all else fitted anew, that held-out ones need not be asked, which takes
    an identification: the weighted square that comes back, c² / C_cc, against that of the rows that it acts on."""
    added, model = search.steps[number].added, search.current.model
    solution, x = model.solution, model.solution.unbounded.x
    own = np.arange(len(x))[place_of(model, added)]
    unit = np.zeros((len(x), len(own)))
    unit[own, np.arange(len(own))] = 1.0
    covariance = solution.unbounded.divided(unit)[own]
    back = float(x[own] @ np.linalg.lstsq(covariance, x[own], rcond=None)[0])
    kinds = added.site.kinds(model.equations)
    there = sum(solution.weights[kind] * solution.statistics.left(kind, x) for kind in kinds)
    return bool(back > (search.problem.settings.criteria.search.surely_needed**2 - 1.0) * there)


def taken_back(search: Search, number: int, objection: Objection) -> Search:
    """Without one that turned out not to be worth its name once all others were there."""
    search = taken_out(search, number, objection)
    search, ground = search.screened(search.current)
    return search.on(ground)


def taken_out(search: Search, number: int, objection: Objection) -> Search:
    """Without this step, in the model of its round too."""
    step, first = search.steps[number], number
    while search.steps[first].beside and first > 0:
        first -= 1
    search = search.having_failed((step.added.effect.name, step.added.site), not_named(step.finding, objection))
    return identified_again(search, search.without(number)[first:], search.steps[:first])


def identified_again(search: Search, kept: Sequence[Step], begun: tuple[Step, ...] = ()) -> Search:
    """With these steps, one round after the other; their findings keep what was said of them. begun: those before them,
    which stay as they are."""
    steps = list(begun)
    for together in rounds_of(kept):
        identified = search.when_asked([each.added for each in (*steps, *together)])
        first = len(steps) + 1
        steps += [replace(each, finding=replace(each.finding, rank=rank), identified=identified, beside=rank > first)
                  for rank, each in enumerate(together, first)]  # fmt: skip
    return replace(search, steps=tuple(steps))


def _effects(steps: Sequence[Step]) -> tuple[str, ...]:
    return tuple(each.finding.effect for each in steps)


def _held_out_rmse(found: Identification, channel: str) -> float:
    return pooled([fit for fit in found.validation if fit.held_out and fit.channel == channel])[0]
