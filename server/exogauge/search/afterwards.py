"""What begins with a held-out log, or sits in it alone: no fitted log has it, so that log joins the fitted ones.

Shapes sought once more, with the model that has their effect. A shape is searched before its effect is in the model.
What the effect sees there, above all the load of its joint, comes of a robot that was bent by what it lacked: where
a load changes its sign, and with it when a gear falls to the other side of its gap, is off by some hundredths of a
second, and the search ends on a summit beside the true one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from exogauge.criteria.criteria import Criteria
from exogauge.effects.order import about
from exogauge.findings.result import Finding
from exogauge.findings.verdict import Caveat
from exogauge.identification.identify import identify
from exogauge.identification.model import AddedEffect
from exogauge.identification.result import ChannelFit, Identification
from exogauge.identification.settings import Recording
from exogauge.search.best_shapes import as_added
from exogauge.search.candidates import Candidate, grid
from exogauge.search.declared import explained
from exogauge.search.doubt import parameters
from exogauge.search.refine import broadly, climbed, closely
from exogauge.search.residual_correction import held_out_rmse
from exogauge.search.score import Baseline, Score, score
from exogauge.search.search import resumed
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of
from exogauge.search.state import Search


def look_into_odd_logs(search: Search) -> tuple[Search, tuple[Caveat, ...]]:
    """What it finds once a log that differs from all others is fitted, and notes; or the same search."""
    problem = search.problem
    settings = replace(problem.settings, cutoff_hz=problem.base.cutoff_hz)  # filtered as without it
    for recording in odd_logs(search):
        joined = [replace(each, held_out=False) if each is recording else each for each in problem.recordings]
        number = problem.base.model.order.get(recording.log.name, -1)
        base = identify(problem.base.model.robot, joined, settings)
        with_it = replace(problem, base=base, recordings=joined, only=number)
        again = resumed(replace(search, problem=with_it), search.steps)
        if len(again.steps) > len(search.steps):
            return again, (Caveat("joined", recording.log.name),)
    return search, ()


def has_joined(search: Search) -> bool:
    """Whether anything that is named begins with the log that joined, or sits in it: what was found there may have been
    taken back since."""
    number = search.problem.only
    return number is not None and any(about(e.added.effect.shapes, e.added.shape, number) for e in search.steps)


def odd_logs(search: Search) -> Iterator[Recording]:
    """Held-out ones, in the order of the study, in which some channel errs more than noise, more than where it was
    fitted, and more than the declared uncertainties of the measurement explain of that log alone."""
    problem = search.problem
    order, criteria = problem.base.model.order, problem.settings.criteria
    fits = search.current.validation
    fitted = {fit.channel: _mean_square([each for each in fits if each.channel == fit.channel and not each.held_out])
              for fit in fits}  # fmt: skip
    for recording in sorted(problem.recordings, key=lambda each: order.get(each.log.name, -1)):
        own = [fit for fit in fits if fit.log == recording.log.name and fit.rmse_moving is not None]
        odd = [fit.channel for fit in own if recording.held_out and _is_odd(fit, fitted[fit.channel], criteria)]
        if odd and not _declared(search, recording, odd):
            yield recording


def _declared(search: Search, recording: Recording, channels: Sequence[str]) -> bool:
    """Whether what was declared explains all that stands above the noise of these channels in this log."""
    known = explained(search.current, search.last, search.problem.recordings, {recording.log.name})
    return all(known.get(channel, False) for channel in channels)


def _is_odd(fit: ChannelFit, fitted: float, criteria: Criteria) -> bool:
    assert fit.rmse_moving is not None
    above = fit.rmse_moving > criteria.judging.above * fit.noise_floor
    return above and fit.rmse_moving**2 > criteria.search.odd**2 * fitted


def _mean_square(fits: list[ChannelFit]) -> float:
    moving = [fit.rmse_moving for fit in fits if fit.rmse_moving is not None]
    return float(np.mean(np.square(moving))) if moving else 0.0


def shapes_again(search: Search) -> Search:
    """Every step in turn; where one is bettered the search goes on from there."""
    tried = search
    for number in range(len(search.steps)):
        tried = _with_better_shape(tried, number) or tried
    return search if tried is search else resumed(replace(tried, eyes=tried.current), tried.steps)


def _with_better_shape(search: Search, number: int) -> Search | None:
    """With the shape of this step that leaves less on held-out logs, seen with all that is in the model; None where
    there is none."""
    problem, step, others = search.problem, search.steps[number], [each.added for each in search.without(number)]
    criteria = problem.settings.criteria.search
    now, floor = _left(step.finding, search.current)
    chosen = all(one.choice for one in step.added.effect.shapes)
    if not search.last or now < criteria.shapes_above * floor or chosen:
        return None
    eyes, site = search.current, step.added.site
    seeing = replace(search, eyes=eyes)
    without = seeing.problem.identified(seeing.eyes, others)
    rows = collect_rows(without.model, problem.recordings, [site], eyes.model)[site]
    best = _best(Baseline(without.model, search.memory), step.added, rows)
    if best is None:
        return None
    added = as_added(best.candidate)
    found = seeing.problem.identified(seeing.eyes, [*others[:number], added, *others[number:]])
    left, _ = _left(step.finding, found)
    if left > criteria.shapes_better * now:
        return None
    finding = replace(step.finding.refined_by("shape", left), parameters=parameters(without.model, best, rows))
    steps = [*search.steps[:number], replace(step, added=added, finding=finding), *search.steps[number + 1 :]]
    return replace(seeing, steps=(*steps[:-1], replace(steps[-1], identified=lambda: found)))


def _best(baseline: Baseline, added: AddedEffect, rows: Sequence[SiteRows]) -> Score | None:
    """What explains most, searched from the shape that it has and from the best of the grid with the same choices."""

    def scored(shape: tuple[float, ...]) -> Score | None:
        return score(baseline, Candidate(added.effect, added.site, shape), sums_of(rows, added.effect, shape))

    chosen = [place for place, one in enumerate(added.effect.shapes) if one.choice]
    alike = [shape for shape in grid(added.effect) if all(shape[k] == added.shape[k] for k in chosen)]
    coarse = [each for shape in alike if (each := scored(shape))]
    starts = [each for each in (scored(added.shape), max(coarse, key=lambda one: one.gain, default=None)) if each]
    paces = [pace(baseline.model.criteria.search) for pace in (broadly, closely)]
    return max(climbed(baseline, starts, rows, paces), key=lambda one: one.gain, default=None)


def _left(finding: Finding, found: Identification) -> tuple[float, float]:
    return held_out_rmse(finding, finding.held_out.channel, found)
