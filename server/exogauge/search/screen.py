"""From scores to judgements: the best shape of every effect and site that is worth it, refined and judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from exogauge.identification.model import AddedEffect, Effect, Site
from exogauge.identification.settings import Recording
from exogauge.search.baseline import Ground
from exogauge.search.candidates import Candidate
from exogauge.search.hints import hinted
from exogauge.search.judge import Judgement, judge
from exogauge.search.refine import closely, closest, refined
from exogauge.search.score import Score, score
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of
from exogauge.side_by_side import each as side_by_side


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
    rows = collect_rows(
        ground.model, recordings, list(dict.fromkeys([site for _, site in best] + [h.site for h in hints]))
    )
    for candidate in hints:
        sums = sums_of(rows[candidate.site], candidate.effect, candidate.shape)
        tried = score(ground.model, candidate, sums, ground.memory)
        known = best[candidate.key][0].evidence if candidate.key in best else least
        if tried is not None and tried.evidence > known:
            best[candidate.key] = [tried]

    def judged(scores: Sequence[Score]) -> Judgement:
        own = rows[scores[0].candidate.site]
        return judge(ground.model, closest(ground.model, scores, own, ground.memory), own)

    return sorted(side_by_side(judged, best.values()), key=lambda one: -one.score.evidence), rows


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
