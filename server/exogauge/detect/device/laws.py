"""Laws that a wear's bands follow beside springs, and further bands: named one after the other, the likeliest first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import Wearing
from exogauge.detect.device.baseline import Ground, weighed, whitened
from exogauge.detect.device.extra_band import further_wires, led_on
from exogauge.detect.device.finding import name_effect, rejection
from exogauge.detect.device.judge import BandJudgement, Folds, judge, rmse, with_best_shape
from exogauge.detect.device.score import BandScore, Scorer, Wires, candidates
from exogauge.effects.band import BandEffect
from exogauge.findings.result import Alternative, Finding
from exogauge.findings.verdict import Objection, Why
from exogauge.search.judge import not_named, refused
from exogauge.side_by_side import each as side_by_side
from exogauge.support.band_model import Wear, fit

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Laws:
    """What was named so far. first: before anything was; ground: with all of it. wears: without anything, then with
    one finding after the other. rounds: in which something was named. tried: shapes. unclear: a further band whose
    course leaves too much to look on."""

    first: Ground
    ground: Ground
    wears: tuple[Wear, ...]
    findings: tuple[Finding, ...] = ()
    rejected: tuple[Alternative, ...] = ()
    rounds: int = 0
    tried: int = 0
    unclear: bool = False


def find_laws(ground: Ground, effects: Mapping[str, BandEffect], folds: Folds, named: int, of: str) -> Laws:
    """named: findings that there are already. of: the wear's name where there are others, or ""."""
    criteria = ground.model.criteria.device
    laws, explained = Laws(ground, ground, (ground.fitted.wear,)), np.zeros(len(ground.joints))
    while True:
        ground, judged, tried = _judged(laws.ground, effects, folds)
        beside = [each.objection or _remainder(each, explained, criteria) for each in judged]
        judged = [replace(each, objection=why) for each, why in zip(judged, beside, strict=True)]
        rejected = tuple(rejection(ground, each, each.objection) for each in judged if each.objection and not each.also)
        laws = replace(laws, ground=ground, rejected=rejected, tried=max(laws.tried, tried))
        if laws.rounds >= criteria.most_effects:
            return laws
        sharpened = ((each, *_sharpened(ground, each, folds)) for each in judged if not each.objection)
        found = next((each for each in sharpened if not any(one.objection for one in each[-1])), None)
        if found is None:
            return laws
        likeliest, ground, winner, members = found
        own = {each.key for each in winner.members}
        rivals = [each for each in judged if each is not likeliest and not each.also and each.added.key not in own]
        rank = named + len(laws.findings) + 1
        findings = [name_effect(rank + k, ground, one, winner, rivals, folds, of) for k, one in enumerate(members)]
        if objected := [(each, why) for each in findings if (why := refused(each, ground.model.criteria.judging))]:
            return replace(laws, rejected=(*rejected, *(not_named(*each) for each in objected)))
        explained = np.maximum(explained, winner.gone)
        before = laws.wears[-1]
        ground = weighed(ground, winner.fitted)
        last = ground.fitted.wear
        one_by_one = [replace(last, added=last.added[: len(before.added) + k + 1]) for k in range(len(members))]
        wire, left = winner.added.effect.sort == "wire", rmse(winner.after, winner.joint)
        laws = replace(
            laws,
            ground=ground,
            wears=(*laws.wears, *one_by_one),
            findings=(*laws.findings, *findings),
            rounds=laws.rounds + 1,
            unclear=wire and left > criteria.clear * ground.floor[winner.joint],
        )
        if laws.unclear:
            return laws


def _judged(ground: Ground, effects: Mapping[str, BandEffect], folds: Folds) -> tuple[Ground, list[BandJudgement], int]:
    """The ground with further wires that are worth it, the candidates judged, with most evidence first, and how many
    shapes were tried."""
    scorer, tried, worth = Scorer(*whitened(ground)), 0, list[BandScore]()
    criteria = ground.model.criteria.device

    def best_of(candidate: tuple[BandEffect, Wires]) -> tuple[BandScore | None, int]:
        effect, wires = candidate
        best, count = scorer.best(effect, *wires)
        return None if best is None or best.evidence <= criteria.worth_judging else scorer.refined(best), count

    for best, count in side_by_side(best_of, candidates(scorer, effects, ground.device.bands)):
        tried += count
        worth += [] if best is None else [best]
    for effect in (each for each in effects.values() if each.sort == "wire"):
        ground, scorer, scores, count = further_wires(ground, scorer, effect)
        worth, tried = worth + [scorer.refined(each) for each in scores], tried + count
    worth = sorted(worth, key=lambda each: -each.evidence)[: criteria.judged]
    judged = list(side_by_side(lambda each: judge(ground, each, folds), worth))
    likely = [each for each in judged if each.evidence > criteria.worth_judging]
    return ground, sorted(likely, key=lambda one: -one.evidence), tried


def _sharpened(
    ground: Ground, winner: BandJudgement, folds: Folds
) -> tuple[Ground, BandJudgement, list[BandJudgement]]:
    """The winner with its best shape, or on its best course, and the ground with it; and each band's own part in it,
    beside the others': each must take its own error off."""
    if winner.added.effect.sort == "wire":
        ground, winner = _on_best_course(ground, winner, folds)
    else:
        winner = with_best_shape(ground, winner, folds)
    if not winner.also:
        return ground, winner, [winner]
    members, alone = list[BandJudgement](), replace(winner.score, also=())
    for own in winner.members:
        others = ground.fitted.wear.with_added(*(each for each in winner.members if each is not own))
        beside = replace(ground, fitted=fit(ground.setting, others))
        members.append(judge(beside, replace(alone, added=own), folds))
    return ground, winner, members


def _on_best_course(ground: Ground, winner: BandJudgement, folds: Folds) -> tuple[Ground, BandJudgement]:
    """What leaves least of what was left out of the fit: the winner, a wire whose ends were led to where it explains
    most, or that one led on with joints weighed by what it leaves on them.

    By what a wire takes off, those that it pulls at hardly count once it is nearly right; by what it leaves, a wire
    that is far from right looks for others.
    """
    wider, scorer, scores, _ = further_wires(ground, Scorer(*whitened(ground)), winner.added.effect, led_better=True)
    best = _leaves_least([(ground, winner), *((wider, judge(wider, scorer.refined(each), folds)) for each in scores)])
    for _ in range(4):  # joints are weighed anew each time
        further = [(wider, judge(wider, scorer.refined(score), folds)) for wider, scorer, score in led_on(*best)]
        before, best = best, _leaves_least([best, *further])
        if best is before:
            break
    return best


def _leaves_least(found: Sequence[tuple[Ground, BandJudgement]]) -> tuple[Ground, BandJudgement]:
    """Of the first and all that may be claimed."""

    def left(each: tuple[Ground, BandJudgement]) -> float:
        ground, judged = each
        return float(np.sum([(rmse(judged.after, d) / max(floor, 1e-12)) ** 2 for d, floor in enumerate(ground.floor)
                             if np.isfinite(judged.after[:, d]).any()]))  # fmt: skip

    return min([found[0], *(each for each in found[1:] if not each[1].objection)], key=left)


def _remainder(judged: BandJudgement, explained: Array, criteria: Wearing) -> Objection | None:
    """Whether it may be what an effect that was named leaves because real bands follow no formula. explained: (D,)
    [N·m] RMS that the largest of those explained."""
    wire = judged.added.effect.sort == "wire"
    share = criteria.remainder_of_wire if wire else criteria.remainder
    if judged.gone[judged.joint] < share * explained[judged.joint]:
        return Objection(Why.SMALL_BESIDE)
    return None
