"""A candidate that may be claimed, as a finding: its numbers, its evidence in words, what it beat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from exogauge.effects.words import at_place, opening
from exogauge.findings.result import AT_MOST, Alternative, Finding, HeldOut, Place
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import channel_of_row
from exogauge.identification.result import Identification
from exogauge.identification.site import Effect, Site
from exogauge.identification.validate import unit_of
from exogauge.search.ambiguity import Undecided, undecided
from exogauge.search.baseline import Ground
from exogauge.search.candidates import Candidate
from exogauge.search.doubt import parameters
from exogauge.search.evidence import continued, evidence, strongest
from exogauge.search.judge import Judgement, apart
from exogauge.search.locate import pooled
from exogauge.search.may_be_named import refused
from exogauge.search.site_rows import SiteRows

TELL_APART = 2.0  # standard errors by which the winner must explain more than another effect of the same joint
OPEN = 6.0  # evidence below which the fitted logs do not tell the two apart: odds of twenty to one


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
    kind: int,
) -> Finding:
    """kind: of the rows whose error is told."""
    model, candidate = ground.model, winner.score.candidate
    effect, place, rows = candidate.effect, place_of(ground.model, candidate), rows_of[candidate.site]
    channel = channel_of(model.equations, kind)
    held_out = _held_out(channel, before, after, winner)
    score = held_out.explained
    kinds = set(candidate.site.kinds(model.equations))
    rivals = [each for each in judged if each is not winner
              and kinds & set(each.score.candidate.site.kinds(model.equations))]  # fmt: skip
    alike = [each for each in rivals if _as_good(winner, each)]
    shown = evidence(model, winner.score, winner.kind, rows)
    others = [_alternative(model, each, alike) for each in rivals]
    return Finding(
        rank=rank,
        effect=effect.name,
        place=place,
        parameters=parameters(model, winner.score, rows),
        held_out=held_out,
        score=score,
        sentence=_sentence(place, effect, strongest(shown, held_out.unit), _falls(held_out), others)
        + continued(winner.score, winner.kind, rows),
        alternatives=tuple(others),
        also_possible=tuple(each for each, rival in zip(others, rivals, strict=True) if rival in alike),
        motion=effect.needs if alike else "",
        evidence=shown,
        undecided=_doubt(model, [winner, *alike], rows_of) if alike else None,
    )


def _as_good(winner: Judgement, rival: Judgement) -> bool:
    """Whether the held-out blocks, or the fitted logs, leave it open which of the two it is."""
    if rival.objection or rival.kind != winner.kind:
        return False
    return abs(apart(winner, rival)) < TELL_APART or winner.score.evidence - rival.score.evidence < OPEN


def _doubt(model: RobotModel, judged: Sequence[Judgement], rows_of: Mapping[Site, Sequence[SiteRows]]) -> Undecided:
    """judged: the winner, then what is as good."""
    return undecided(model, [each.score for each in judged], judged[0].kind, judged[0].after, rows_of)


def channel_of(equations: Equations, kind: int) -> str:
    """Of a kind of rows."""
    return channel_of_row(equations.robot, kind)


def objection(finding: Finding, without: float, with_it: float) -> str:
    """Why an effect is dropped again once the robot has been identified with it, or "". without, with_it: `low_passed`.

    The error has to fall as it is told as well, in steady motion, and the size of the effect to be known.
    """
    if with_it > AT_MOST * without:
        change = f"{without:.3g} to {with_it:.3g} {finding.held_out.unit}"
        return f"with the robot identified again the held-out error does not fall ({change})"
    return refused(finding)


def low_passed(ground: Ground, kind: int, logs: Sequence[str]) -> float:
    """RMSE of one kind of rows in these logs. A jolt that the model meets a moment late makes the unfiltered error
    larger."""
    left = [each.residual[kind] for each in ground.residuals if each.log in logs and kind in each.residual]
    return float(np.sqrt(np.nanmean(np.concatenate(left) ** 2)))


def _alternative(model: RobotModel, judged: Judgement, alike: Sequence[Judgement]) -> Alternative:
    reason = judged.objection or (
        "these data cannot tell it from what was named" if judged in alike else "explains less"
    )
    return replace(rejection(model, judged), reason=reason)


def _held_out(channel: str, before: Identification, after: Identification, judged: Judgement) -> HeldOut:
    fits = [[fit for fit in each.validation if fit.log in judged.logs and fit.channel == channel]
            for each in (before, after)]  # fmt: skip
    (rmse_before, floor), (rmse_after, _) = (pooled(each) for each in fits)
    log = ", ".join(judged.logs) if judged.once else ""
    return HeldOut(channel, unit_of(channel, before.model.robot), rmse_before, rmse_after, floor, log)


def _falls(held_out: HeldOut) -> str:
    which = f"the error in {held_out.log}, the one log that has it," if held_out.log else "the held-out error"
    before, after, unit = held_out.rmse_before, held_out.rmse_after, held_out.unit
    share = f"{100 * held_out.explained:.0f} % of the excess"
    return (
        f"{which} falls from {before:.2g} to {after:.2g} {unit} RMSE (noise floor {held_out.noise_floor:.2g}), {share}."
    )


def _named(other: Alternative) -> str:
    return at_place(other.effect, other.place.kind, other.place.name, other.place.part)


def _sentence(place: Place, effect: Effect, where: str, falls: str, others: Sequence[Alternative]) -> str:
    best = max(others, key=lambda each: each.score, default=None)
    told = best is not None and best.score >= 0.005
    next_best = f" The next best, {_named(best)}, explains {100 * best.score:.0f} %." if best and told else ""
    return (
        f"{opening(place.kind, place.name, place.part)}{effect.sentence} Without it the model lacks up to {where}. "
        f"Added, {falls}{next_best}"
    )
