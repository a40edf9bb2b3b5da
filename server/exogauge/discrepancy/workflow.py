"""Find where model and measurement disagree, name what is missing, add it, and go on until nothing qualifies.

Every candidate is fitted beside the whole baseline on the fitted logs; the best are judged on held-out logs.
What is claimed is added, the robot identified again with it, and the search repeated on that model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from exogauge.discrepancy.axis_rows import collect_rows
from exogauge.discrepancy.candidates import Candidate
from exogauge.discrepancy.doubt import parameters
from exogauge.discrepancy.evidence import evidence, strongest
from exogauge.discrepancy.ground import Ground, lay_ground
from exogauge.discrepancy.judge import Judgement, apart, judge
from exogauge.discrepancy.locate import located, pooled
from exogauge.discrepancy.refine import refined
from exogauge.discrepancy.result import (
    Alternative,
    Discrepancy,
    Excess,
    Finding,
    HeldOut,
    Lineage,
    Link,
    Place,
    Verdict,
)
from exogauge.discrepancy.score import Score
from exogauge.effects.shaped import ShapedEffect
from exogauge.identification.added import AddedEffect, Extension
from exogauge.identification.identify import identify
from exogauge.identification.model import RobotModel
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress, Recording, Settings

MOST_EFFECTS = 6
WORTH_JUDGING = 6.0  # evidence (BIC): odds of twenty to one before the number of candidates is counted
JUDGED = 12  # candidates per round
TELL_APART = 2.0  # standard errors by which the winner must explain more than another effect of the same joint
NOT_HELD_OUT = (
    "No log was held out, so nothing can be claimed: give at least one log of the same kind of motion the role "
    "`validation`."
)


@final
@dataclass(frozen=True)
class Found:
    """The search's answer, and the identification with all that was named."""

    discrepancy: Discrepancy
    identification: Identification


def find_missing_effects(
    found: Identification,
    recordings: Sequence[Recording],
    effects: Sequence[ShapedEffect],
    settings: Settings,
    progress: Progress = lambda _fraction, _phrase: None,
) -> Found:
    """found: identification without them, of the same recordings. effects: what may be missing."""
    base, current = found.model, found
    findings: list[Finding] = []
    added: tuple[AddedEffect, ...] = ()
    models = [found]
    rejected: list[Alternative] = []
    tried = 0
    before: tuple[Excess, ...] = ()
    while True:
        share = min(len(findings) / 3.0, 0.9)
        ground = lay_ground(current.model, recordings, effects, _part(progress, share))
        tried += sum(len(each) for each in ground.candidates.values())
        before = before or located(base.robot, found, ground.residuals)
        judged = _judged(ground, recordings)
        rejected += [_rejection(base, each) for each in judged if each.objection]
        claimed = [each for each in judged if not each.objection]
        if not claimed or len(findings) == MOST_EFFECTS:
            break
        winner = max(claimed, key=lambda each: each.score.evidence)
        progress(share + 0.25, f"adding {winner.score.candidate.effect.name}")
        added = (*added, _as_added(winner.score.candidate))
        again = identify(base.robot, recordings, settings, extension=Extension(base, added))
        findings.append(_finding(len(findings) + 1, ground, winner, judged, current, again, recordings))
        models.append(again)
        current = again
    unexplained = located(base.robot, current, ground.residuals)
    verdict: Verdict = "effects" if findings else ("unexplained" if unexplained else "none")
    notes = () if any(each.held_out for each in recordings) else (NOT_HELD_OUT,)
    channels = [finding.held_out.channel for finding in findings] or [each.channel for each in before]
    progress(1.0, "compared")
    return Found(
        Discrepancy(
            verdict=verdict,
            findings=tuple(findings),
            chain=tuple(_link(each, findings[:k], channels) for k, each in enumerate(models)),
            located=before,
            unexplained=unexplained,
            rejected=tuple(rejected),
            lineage=_lineage(findings),
            candidates=tried,
            notes=notes,
            before_after={},
        ),
        current,
    )


def _part(progress: Progress, start: float) -> Progress:
    return lambda fraction, phrase: progress(start + 0.2 * fraction, phrase)


def _judged(ground: Ground, recordings: Sequence[Recording]) -> list[Judgement]:
    """The best shape of every effect and axis that is worth it, refined and judged; most evidence first."""
    best: dict[tuple[str, int], Score] = {}
    for score in ground.scores:
        key = (score.candidate.effect.name, score.candidate.axis)
        if score.evidence > WORTH_JUDGING and key not in best and len(best) < JUDGED:
            best[key] = score
    axes = sorted({axis for _, axis in best})
    rows = collect_rows(ground.model, recordings, axes) if axes else {}
    judged = []
    for (_, axis), score in best.items():
        finer = refined(ground.model, score, rows[axis], ground.memory[axis])
        judged.append(judge(ground.model, finer, rows[axis]))
    return sorted(judged, key=lambda each: -each.score.evidence)


def _as_added(candidate: Candidate) -> AddedEffect:
    return AddedEffect(candidate.effect, candidate.axis, candidate.shape)


def _place(model: RobotModel, candidate: Candidate) -> Place:
    return Place("joint", model.robot.joints[candidate.axis].name)


def _rejection(model: RobotModel, judged: Judgement) -> Alternative:
    candidate = judged.score.candidate
    return Alternative(candidate.effect.name, _place(model, candidate), max(judged.explained, 0.0), judged.objection)


def _finding(
    rank: int,
    ground: Ground,
    winner: Judgement,
    judged: Sequence[Judgement],
    before: Identification,
    after: Identification,
    recordings: Sequence[Recording],
) -> Finding:
    model, candidate = ground.model, winner.score.candidate
    effect, place = candidate.effect, _place(ground.model, winner.score.candidate)
    rows = collect_rows(model, recordings, [candidate.axis])[candidate.axis]
    held_out = _held_out(place.name, before, after)
    score = _share(held_out)
    rivals = [each for each in judged if each is not winner and each.score.candidate.axis == candidate.axis]
    alike = [each for each in rivals if not each.objection and abs(apart(winner, each)) < TELL_APART]
    shown = evidence(model, winner.score, rows)
    others = [_alternative(model, each, alike) for each in judged if each is not winner]
    return Finding(
        rank=rank,
        effect=effect.name,
        place=place,
        parameters=parameters(model, winner.score, rows),
        held_out=held_out,
        score=score,
        sentence=_sentence(place.name, effect, strongest(shown), held_out, score, others),
        alternatives=tuple(others),
        also_possible=tuple(each for each, rival in zip(others, [e for e in judged if e is not winner], strict=True)
                            if rival in alike),
        motion=effect.needs if alike else "",
        evidence=shown,
    )  # fmt: skip


def _alternative(model: RobotModel, judged: Judgement, alike: Sequence[Judgement]) -> Alternative:
    reason = judged.objection or (
        "these data cannot tell it from what was named" if judged in alike else "explains less"
    )
    return replace(_rejection(model, judged), reason=reason)


def _held_out(joint: str, before: Identification, after: Identification) -> HeldOut:
    channel = f"tau.{joint}"
    fits = [[fit for fit in each.validation if fit.held_out and fit.channel == channel] for each in (before, after)]
    (rmse_before, floor), (rmse_after, _) = (pooled(each) for each in fits)
    return HeldOut(channel, "N·m", rmse_before, rmse_after, floor)


def _share(held_out: HeldOut) -> float:
    """Of the excess over the noise floor that goes."""
    excess = held_out.rmse_before**2 - held_out.noise_floor**2
    gone = held_out.rmse_before**2 - held_out.rmse_after**2
    return float(np.clip(gone / excess, 0.0, 1.0)) if excess > 0.0 else 0.0


def _sentence(
    joint: str, effect: ShapedEffect, where: str, held_out: HeldOut, score: float, others: Sequence[Alternative]
) -> str:
    best = max(others, key=lambda each: each.score, default=None)
    next_best = (
        f" The next best, {best.effect} at {best.place.name}, explains {100 * best.score:.0f} %." if best else ""
    )
    return (
        f"{joint}: {effect.sentence} Without it the model lacks up to {where}. Added, the held-out error falls from "
        f"{held_out.rmse_before:.2g} to {held_out.rmse_after:.2g} {held_out.unit} RMSE (noise floor "
        f"{held_out.noise_floor:.2g}), {100 * score:.0f} % of the excess.{next_best}"
    )


def _link(found: Identification, so_far: Sequence[Finding], channels: Sequence[str]) -> Link:
    step = f"+ {so_far[-1].effect} at {so_far[-1].place.name}" if so_far else "identified model"
    joints = [f"tau.{joint.name}" for joint in found.model.robot.joints]
    fits = [fit for fit in found.validation if fit.held_out and fit.channel in (channels or joints)]
    rmse, floor = pooled(fits)
    each = {name: pooled([fit for fit in found.validation if fit.held_out and fit.channel == name]) for name in joints}
    known = {name: values for name, values in each.items() if np.isfinite(values[0]) and values[1] > 0.0}
    worst = max(known, key=lambda name: known[name][0] / known[name][1], default="")
    worst_rmse, worst_floor = known.get(worst, (float("nan"), float("nan")))
    return Link(step, rmse, floor, worst, worst_rmse, worst_floor)


def _lineage(findings: Sequence[Finding]) -> tuple[Lineage, ...]:
    names = ["identified"]
    lines = [Lineage(names[0], None, "")]
    for each in findings:
        names.append(f"{names[-1]}+{each.effect}@{each.place.name}")
        lines.append(Lineage(names[-1], names[-2], f"{each.effect}@{each.place.name}"))
    return tuple(lines)
