"""Add the best candidate that may be claimed, and identify the robot again with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exogauge.findings.objection import Objection
from exogauge.search.baseline import Ground
from exogauge.search.creeping import creeping, is_soft
from exogauge.search.effect_size import Named, gone, not_worth
from exogauge.search.finding import channel_of, low_passed, name_effect, objection, rejection
from exogauge.search.judge import Judgement
from exogauge.search.locate import channels, pooled
from exogauge.search.screen import as_added, judge_best, with_closest_shape
from exogauge.search.state import Search, Step


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
    for first in claimed if len(search.steps) < criteria.search.most_effects else []:
        winner = _weighed(search, with_closest_shape(ground, first, rows))
        judged = [winner if each is first else each for each in judged]
        candidate = winner.score.candidate
        problem.tell(0.0, f"adding {candidate.effect.name}")
        added = as_added(candidate)
        found = search.identified([*search.added, added])
        search, following = search.screened(found)
        kind = _kind_that_gains(search, winner, ground, following)
        without, with_it = (low_passed(each, kind, winner.logs) for each in (ground, following))
        size = gone(without, with_it)
        rank = len(search.steps) + 1
        finding, undecided = name_effect(rank, ground, winner, judged, search.current, found, rows, kind)
        refused = objection(finding, without, with_it, criteria.judging) or _not_worth(search, winner, kind, size)
        if not refused:
            step = Step(added, finding, found, size, undecided)
            return replace(search, steps=(*search.steps, step)), following
        search = search.having_failed(candidate.key, rejection(ground.model, winner, refused))
    return search, None


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


def _is_seen(ground: Ground, kind: int, judged: Judgement) -> bool:
    """Whether the logs that it was judged on have rows of this kind."""
    return any(np.isfinite(each.residual[kind]).any() for each in ground.residuals
               if each.log in judged.logs and kind in each.residual)  # fmt: skip
