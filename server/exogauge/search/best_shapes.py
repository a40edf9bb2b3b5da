"""The best shape of every effect and site: screened, refined and judged.

Shapes that a grid cannot hold, such as the order of a ripple, are read off the residuals.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import AddedEffect, Effect, Site
from exogauge.identification.settings import Recording
from exogauge.identification.sites import AxisSite
from exogauge.search.baseline import Ground
from exogauge.search.candidates import Candidate, of_measurement
from exogauge.search.judge import Judgement, judge
from exogauge.search.refine import closely, closest, refined, with_it
from exogauge.search.score import Score, score
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]


def judge_best(
    ground: Ground, recordings: Sequence[Recording], effects: Sequence[Effect], only: Site | None = None
) -> tuple[list[Judgement], Mapping[Site, Sequence[SiteRows]]]:
    """The best shape of every effect and site that is worth it, refined and judged, most evidence first; and the rows
    of their sites. only: at one site."""
    best: dict[tuple[str, Site], list[Score]] = {}
    least, most = ground.model.criteria.judging.worth_judging, ground.model.criteria.search.judged
    taken = {True: 0, False: 0}  # a sensor that is a little off outweighs in many rows what one joint lacks in its own
    for each in ground.scores:
        key, measures = each.candidate.key, of_measurement(each.candidate.site)
        wanted = only is None or each.candidate.site == only
        if wanted and each.evidence > least and (key in best or taken[measures] < most):
            taken[measures] += key not in best
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
