"""A candidate that may be claimed, as a finding: its numbers, its evidence in words, what it beat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from exogauge.discrepancy.candidates import Candidate
from exogauge.discrepancy.doubt import parameters
from exogauge.discrepancy.evidence import evidence, strongest
from exogauge.discrepancy.ground import Ground
from exogauge.discrepancy.judge import Judgement, apart
from exogauge.discrepancy.locate import channels, pooled
from exogauge.discrepancy.result import Alternative, Finding, HeldOut, Place
from exogauge.discrepancy.site_rows import SiteRows
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import BASE_CHANNELS
from exogauge.identification.result import Identification
from exogauge.identification.site import Effect, Site
from exogauge.identification.validate import unit_of

AT_MOST = 0.995  # of the held-out error before
MOSTLY, STAYS = 0.5, 1.1  # where this share of the low-passed error goes, the unfiltered one may stay as large
TELL_APART = 2.0  # standard errors by which the winner must explain more than another effect of the same joint


def place_of(model: RobotModel, candidate: Candidate) -> Place:
    return Place(*candidate.site.label(model.equations))


def rejection(model: RobotModel, judged: Judgement) -> Alternative:
    candidate = judged.score.candidate
    return Alternative(candidate.effect.name, place_of(model, candidate), max(judged.explained, 0.0), judged.objection)


def name_effect(
    rank: int,
    ground: Ground,
    winner: Judgement,
    judged: Sequence[Judgement],
    before: Identification,
    after: Identification,
    rows_of: Mapping[Site, Sequence[SiteRows]],
) -> Finding:
    model, candidate = ground.model, winner.score.candidate
    effect, place, rows = candidate.effect, place_of(ground.model, candidate), rows_of[candidate.site]
    channel = channel_of(model.equations, winner.kind)
    held_out = _held_out(channel, before, after)
    score = held_out.explained
    kinds = set(candidate.site.kinds(model.equations))
    rivals = [each for each in judged if each is not winner
              and kinds & set(each.score.candidate.site.kinds(model.equations))]  # fmt: skip
    alike = [
        each
        for each in rivals
        if not each.objection and each.kind == winner.kind and abs(apart(winner, each)) < TELL_APART
    ]
    shown = evidence(model, winner.score, winner.kind, rows)
    others = [_alternative(model, each, alike) for each in rivals]
    return Finding(
        rank=rank,
        effect=effect.name,
        place=place,
        parameters=parameters(model, winner.score, rows),
        held_out=held_out,
        score=score,
        sentence=_sentence(place.words, effect, strongest(shown, held_out.unit), held_out, score, others),
        alternatives=tuple(others),
        also_possible=tuple(each for each, rival in zip(others, rivals, strict=True) if rival in alike),
        motion=effect.needs if alike else "",
        evidence=shown,
    )


def channel_of(equations: Equations, kind: int) -> str:
    """Of a kind of rows."""
    return channels(equations).get(kind) or BASE_CHANNELS[kind]


def objection(finding: Finding, judged: Judgement) -> str:
    """Why an effect is dropped again once the robot has been identified with it, or "".

    What explains most of the low-passed error may still miss short jumps, such as those of a gear's play, by a moment:
    then the unfiltered error may stay.
    """
    held_out = finding.held_out
    at_most = STAYS if judged.explained > MOSTLY else AT_MOST
    if held_out.rmse_after > at_most * held_out.rmse_before:
        return (
            f"with the robot identified again the held-out error does not fall ({held_out.rmse_before:.3g} to "
            f"{held_out.rmse_after:.3g} {held_out.unit})"
        )
    return ""


def _alternative(model: RobotModel, judged: Judgement, alike: Sequence[Judgement]) -> Alternative:
    reason = judged.objection or (
        "these data cannot tell it from what was named" if judged in alike else "explains less"
    )
    return replace(rejection(model, judged), reason=reason)


def _held_out(channel: str, before: Identification, after: Identification) -> HeldOut:
    fits = [[fit for fit in each.validation if fit.held_out and fit.channel == channel] for each in (before, after)]
    (rmse_before, floor), (rmse_after, _) = (pooled(each) for each in fits)
    return HeldOut(channel, unit_of(channel), rmse_before, rmse_after, floor)


def _sentence(
    place: str, effect: Effect, where: str, held_out: HeldOut, score: float, others: Sequence[Alternative]
) -> str:
    best = max(others, key=lambda each: each.score, default=None)
    told = best is not None and best.score >= 0.005
    next_best = f" The next best, {best.effect}, explains {100 * best.score:.0f} %." if best and told else ""
    return (
        f"{place}: {effect.sentence} Without it the model lacks up to {where}. Added, the held-out error falls from "
        f"{held_out.rmse_before:.2g} to {held_out.rmse_after:.2g} {held_out.unit} RMSE (noise floor "
        f"{held_out.noise_floor:.2g}), {100 * score:.0f} % of the excess.{next_best}"
    )
