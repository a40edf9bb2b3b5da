"""Shapes sought once more, with the model that has their effect.

A shape is searched before its effect is in the model. What the effect sees there, above all the load of its joint,
comes of a robot that was bent by what it lacked: where a load changes its sign, and with it when a gear falls to the
other side of its gap, is off by some hundredths of a second, and the search ends on a summit beside the true one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from exogauge.findings.result import Finding
from exogauge.identification.model import AddedEffect, RobotModel
from exogauge.identification.result import Identification
from exogauge.search.candidates import Candidate, grid
from exogauge.search.doubt import parameters
from exogauge.search.refine import broadly, climbed, closely
from exogauge.search.residual_correction import held_out_rmse
from exogauge.search.score import Score, score
from exogauge.search.search import Search, as_added
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of


def shapes_again(search: Search) -> None:
    """Every step of `search` in turn; where one is bettered the search goes on from there."""
    bettered = False
    for number in range(len(search.steps)):
        bettered = _sought_again(search, number) or bettered
    if bettered:
        search.eyes = search.current
        search.resume(search.steps)


def _sought_again(search: Search, number: int) -> bool:
    """Whether another shape of this step leaves less on held-out logs; it is in the model then. Where none does, the
    search is as it was, what it sees effects' loads with included."""
    seen_with = search.eyes
    bettered = _bettered(search, number)
    if not bettered:
        search.eyes = seen_with
    return bettered


def _bettered(search: Search, number: int) -> bool:
    step, others = search.steps[number], [each.added for k, each in enumerate(search.steps) if k != number]
    criteria = search.settings.criteria
    now, floor = _left(step.finding, search.current)
    if (
        search.last is None
        or now < criteria.search.shapes_above * floor
        or all(one.choice for one in step.added.effect.shapes)
    ):
        return False
    eyes, site = search.current, step.added.site
    search.eyes = eyes
    without = search.identified(others)
    rows = collect_rows(without.model, search.recordings, [site], eyes.model)[site]
    best = _best(without.model, step.added, rows, search.last.memory)
    if best is None:
        return False
    added = as_added(best.candidate)
    found = search.identified([*others[:number], added, *others[number:]])
    left, _ = _left(step.finding, found)
    if left > criteria.search.shapes_better * now:
        return False
    finding = replace(step.finding.refined_by("shape", left), parameters=parameters(without.model, best, rows))
    search.steps[number] = replace(step, added=added, finding=finding)
    search.steps[-1] = replace(search.steps[-1], found=found)
    return True


def _best(model: RobotModel, added: AddedEffect, rows: Sequence[SiteRows], memory: Mapping[int, float]) -> Score | None:
    """What explains most, searched from the shape that it has and from the best of the grid with the same choices."""

    def scored(shape: tuple[float, ...]) -> Score | None:
        return score(model, Candidate(added.effect, added.site, shape), sums_of(rows, added.effect, shape), memory)

    chosen = [place for place, one in enumerate(added.effect.shapes) if one.choice]
    alike = [shape for shape in grid(added.effect) if all(shape[k] == added.shape[k] for k in chosen)]
    coarse = [each for shape in alike if (each := scored(shape))]
    starts = [each for each in (scored(added.shape), max(coarse, key=lambda one: one.gain, default=None)) if each]
    paces = [pace(model.criteria.search) for pace in (broadly, closely)]
    return max(climbed(model, starts, rows, memory, paces), key=lambda one: one.gain, default=None)


def _left(finding: Finding, found: Identification) -> tuple[float, float]:
    return held_out_rmse(finding, finding.held_out.channel, found)
