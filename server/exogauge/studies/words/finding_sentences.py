"""What was found, rejected or not judged, in sentences: from the data of `findings`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import final

import numpy as np

from exogauge.devices.result import BandEstimate
from exogauge.findings.as_told import ALL
from exogauge.findings.basis import BesideStated, Continued, FloorOf, LeftOut, LowPassed, OfBand, OfRobot, Touched
from exogauge.findings.planned_motion import Apart, PlannedMotion
from exogauge.findings.result import Concentration, Consequence, Excess, Finding, HeldOut, Place
from exogauge.findings.verdict import Caveat, Objection, Why
from exogauge.studies.words.doubt_words import source_advice, source_words
from exogauge.studies.words.names import (
    NO_BREAK,
    at_place,
    capital,
    channel,
    counted,
    effect_words,
    listed,
    place_words,
    plus_minus,
    titled,
    told,
)
from exogauge.studies.words.remark_words import sentence

OBJECTIONS: Mapping[Why, str] = {
    Why.TOO_SHORT: "too little steady motion that was not fitted to judge it: {value:.0f} of {beside:.0f}{space}s",
    Why.FEW_MOMENTS: "one or two moments of the fitted logs alone ask for it ({value:.1f} standard errors)",
    Why.LITTLE: "it explains {percent:.1f}{space}% of the error: not worth a name",
    Why.NOT_SURE: "the held-out error does not fall surely ({value:.2f} standard errors, {beside:.2g} are asked for)",
    Why.NOT_SURE_ONCE: "the error in the log that has it does not fall surely ({value:.2f} standard errors, "
    "{beside:.2g} are asked for)",
    Why.WORSE: "it makes the error larger {regime} ({value:.1f} standard errors)",
    Why.NOT_FALLING: "with it the {error} does not fall ({value:.3g} to {beside:.3g}{space}{unit})",
    Why.NOT_FALLING_AGAIN: "with the robot identified again the held-out error does not fall ({value:.3g} to "
    "{beside:.3g}{space}{unit})",
    Why.MAY_BE_NONE: "its size may as well be none ({sizes})",
    Why.SIZE_NOT_SURE: "its size is not surely other than zero ({value:.1f} standard deviations, {beside:.0f} are "
    "asked for)",
    Why.TOO_SMALL: "it is there, and smaller than what matters ({value:.2g} where the sensors' noise is {beside:.2g})",
    Why.SMALL_BESIDE: "it is small beside {effects}, and may be what that one's formula does not hold",
    Why.UNDER_SUPPORT: "it is less than the noise and {percent:.0f}{space}% of the support where it shows most",
    Why.NOISE_ALONE: "what it takes off the error is to {percent:.0f}{space}% noise of the sensors, which it smooths",
    Why.AT_FLOOR: "the error is no more than the noise floor without it",
    Why.ONCE: "it happens once, so nothing can be held out, and the evidence is not overwhelming",
    Why.PARTIAL: "it would explain {percent:.0f}{space}% of what is there and leave {beside:.2g} noise floors: "
    "something else is the cause",
    Why.AT_ITS_EDGE: "its size would be at the edge of what can be, and leave {value:.2g} noise floors: something "
    "else is the cause",
    Why.DECLARED: "declared uncertainties of the measurement leave as much there, and explain all of it",
    Why.BETTERED: "with {effects} in the model, another one explains more",
    Why.NOT_NEEDED: "with {effects} in the model it is not needed any more",
    Why.ALIKE: "these data cannot tell it from what was named",
    Why.LESS: "explains less",
    Why.LESS_LIKELY: "the data are less likely with it",
    Why.ONE_FACTOR: "one factor on every motor's gain makes the data as likely",
    Why.ONE_BODY: "a heavier link and a load fixed to it are the same",
}
REGIMES = {
    "low_speed": "at low speed",
    "high_speed": "at high speed",
    "positive_motion": "in positive motion",
    "negative_motion": "in negative motion",
    "short": "where the band is short",
    "long": "where the band is long",
    "lengthening": "while the band lengthens",
    "shortening": "while the band shortens",
}
LEFT_OUT: Mapping[LeftOut, str] = {
    "repetitions": "repetitions that were not fitted",
    "motions": "motions that were not fitted",
    "parts": "parts of the log that were not fitted",
    "nothing": "all logs",
}
FLOORS: Mapping[FloorOf, str] = {
    "other_logs": "The noise floor is what the noise of the other logs leaves behind that low-pass.",
    "stated": "The noise floor is what the noise that robot.yaml states leaves behind that low-pass.",
    "seen": "The noise floor is the sensors' noise behind that low-pass, as seen where that falls off.",
    "rounding": "There is no noise floor to hold that against: no log shows the sensors' noise, and robot.yaml states "
    "none (`noise`). The one given is that of rounding.",
}
TOUCH_AGAIN = (
    "The same contact once more while all joints between these links and the base move at steady speed: a joint that "
    "rests or turns does not show what pulls at it. A force/torque sensor below them tells more."
)
TURN = "Turn each of these links about axes of its own, fast and with gravity across it, while the others rest."
HOLD = "Hold a load of known weight with this joint, level and hanging, and repeat the same motion without it."
NOTES: Mapping[str, str] = {
    "not_held_out": "No log was held out, so nothing can be claimed: give at least one log of the same kind of motion "
    "the role `validation`.",
    "joined": "{of} was held out and had to be fitted: something begins with it, or is in no other log. What is said "
    "of held-out logs is about the others.",
    "no_steady_motion": "No log with {of} has steady motion to judge its bands by.",
    "nothing_left_out": "Nothing can be held out of the only log with {of}, so no effect of its bands is claimed.",
    "unclear_course": "Something pulls on the robot with {of} that is not described, on a course that these logs do "
    "not show exactly; nothing is said of the other bands until it is.",
}
CONSEQUENCES = {
    "rmse": "RMSE of approach B · {}, {}, {}",
    "group_stiffness": "stiffness of group {} by approach {} · {}",
    "stiffness": "stiffness of {}, without and with the wear's effects",
    "natural_length": "natural length of {}, without and with the wear's effects",
}
WITH_EFFECTS = "with what was named of the bands in the model"
ALIKE = 0.02  # of an effect left beside the other, below which they count as one
LEAST = 0.005  # share of the excess: below, a rival explains none of it


@final
class _Signed(float):
    """With a true minus sign."""

    def __format__(self, form: str) -> str:
        return told(float(self), form)


def objection_words(found: Objection) -> str:
    """Why a candidate was not named."""
    on, *log = found.of if found.why is Why.NOT_FALLING else ("",)
    return OBJECTIONS[found.why].format(
        value=_Signed(found.value),
        beside=_Signed(found.beside),
        percent=_Signed(100.0 * found.value),
        space=NO_BREAK,
        unit=found.unit,
        regime=REGIMES[found.of[0]] if found.why is Why.WORSE else "",
        error=f"{f'error in {log[0]}' if log else 'held-out error'} of {channel(on)}" if on else "",
        effects=listed([effect_words(each) for each in found.of]) or "what was named before",
        sizes=", ".join(f"{name} {plus_minus(each.value, each.std)}" for name, each in found.sizes.items()),
    )


def finding_sentence(finding: Finding) -> str:
    """The evidence."""
    basis = finding.basis
    match basis:
        case OfRobot():
            said = _of_robot(finding, basis)
        case OfBand():
            said = _of_band(finding, basis)
        case Touched():
            said = _touched(finding, basis)
        case BesideStated():
            said = _beside_stated(finding, basis)
        case LowPassed():
            said = _low_passed(finding, basis)
    said = " ".join([said, *_refined(finding)])
    if not finding.alike:
        return said
    sort, names = ("axes", [each.part for each in finding.alike]) if finding.place.kind == "sensor" else (
        "joints", [each.name for each in finding.alike])  # fmt: skip
    return f"All {sort} alike ({', '.join(names)}): {said}"


def motion_words(finding: Finding) -> str:
    """What to record, to tell the finding from what it may be, too; "" where there is no such motion or no need."""
    if finding.apart:
        never = [not_told(each) for each in finding.apart if each.seconds is None]
        weigh = [HOLD] if any(each.objection.why is Why.ONE_FACTOR for each in finding.also_possible) else []
        return " ".join([*(planned_sentence(each) for each in finding.plans), *never, *weigh])
    if not finding.also_possible:
        return ""
    match finding.basis:
        case OfRobot() | OfBand():
            return finding.basis.effect.needs
        case Touched():
            return TOUCH_AGAIN
        case BesideStated():
            others = any(each.objection.why is Why.LESS_LIKELY for each in finding.also_possible)
            return (HOLD if "gain" in finding.parameters else TURN) if others else ""
        case LowPassed():
            return ""


def planned_sentence(plan: PlannedMotion) -> str:
    """`Move torso_pitch to and fro by ±0.3 rad …: of what tells them apart 12 % was left in these logs, 64 % …`"""
    moved = _swept(plan) if plan.sweep is not None else f"Move {_listed(plan.others)} as the file says"
    beside = ""
    if plan.companion:
        low, high = (told(each, ".2f") for each in plan.companion_range)
        beside = f", while {plan.companion} moves slowly from {low} to {high} and back"
    elif plan.sweep is not None and plan.others:
        beside = f", while {_listed(plan.others)} move as the file says"
    why = [f"{_shares(each)}{_evidence(each)}" for each in plan.pairs]
    legs = "The base and the joints that carry it stay still. " if plan.legs_rest else ""
    given = f"Record it twice and hold one of the two out. {legs}{_held(plan)}"
    return " ".join([f"{moved}{beside}, for {told(plan.duration, '.0f', 's')}.", *why, given])


def _swept(plan: PlannedMotion) -> str:
    sweep, unit = plan.sweep, plan.unit
    assert sweep is not None
    span = f"±{told(sweep.amplitude, '.2f', unit)} about {told(sweep.offset, '.2f', unit)}"
    return {
        "speeds": f"Move {plan.joint} to and fro by {span} at steady speeds from {told(sweep.slowest, '.2g')} to "
        f"{told(sweep.fastest, '.2g', f'{unit}/s')} (shorter ways where it is slow)",
        "sine": f"Swing {plan.joint} by {span} with a period of {told(sweep.period, '.2g', 's')}, "
        f"at {told(sweep.fastest, '.2g', f'{unit}/s')} at most",
        "small": f"Move {plan.joint} to and fro by small ways at {told(sweep.slowest, '.2g', f'{unit}/s')}, at several "
        f"places within {span}",
    }[sweep.kind]


def _listed(joints: Sequence[str]) -> str:
    """`torso_yaw and torso_pitch`, `24 joints`."""
    return listed(joints) if len(joints) <= 3 else f"{len(joints)} joints"


BOUND_KEPT = {
    "touch": "the links' distance from each other",
    "torque": "every motor's torque",
    "balance": "the balance on both feet",
}
BOUND_UNKNOWN = {
    "touch": "whether the robot would touch itself",
    "torque": "whether every motor bears it",
    "balance": "whether the robot keeps its balance",
}


def _held(plan: PlannedMotion) -> str:
    """What a motion keeps within, and what of it is not known."""
    kept = ["every joint's own limits", *(BOUND_KEPT[each] for each in plan.kept)]
    unknown = [BOUND_UNKNOWN[each] for each in plan.unknown]
    doubt = f"; {' and '.join(unknown)} is not known" if unknown else ""
    return f"{capital(listed(kept))} are kept{doubt}."


def where_words(excess: Excess) -> str:
    """At which speeds, positions or times an error is largest."""
    where: Concentration = excess.where
    if where.moments:
        moments = [f"{told(at, '.0f', 's')} of {log}" for log, at in where.moments]
        return f"in a few moments: at {', '.join(moments)}"
    if where.coordinate is None:
        return "with the wear on" if excess.channel.startswith("support.") else "throughout"
    over = "time since the start" if where.coordinate == "time" else where.coordinate
    return f"at a {over} {'above' if where.above else 'below'} {told(where.at, '.3g', where.unit)}"


def note_words(caveat: Caveat) -> str:
    """What to keep in mind."""
    return NOTES[caveat.why].format(of=caveat.of)


def reason_words(caveat: Caveat | None) -> str:
    """Why something was not judged, in numbers."""
    if caveat is None:
        return ""
    steady = "steady held-out motion"
    match caveat.why:
        case "no_steady_motion" | "nothing_left_out":
            note = note_words(caveat)
            return f"cannot judge the bands: {note[0].lower()}{note[1:-1]}"
        case "too_short":
            many = "channels have" if caveat.others > 1 else "channel has"
            more = f"; {caveat.others} other {many} less than that, too" if caveat.others else ""
            reason = f"{caveat.value:.1f} of {caveat.needed:.0f} s of {steady} at {channel(caveat.of)}{more}"
        case "far" if caveat.of:
            reason = (
                f"{channel(caveat.of)} stands at {caveat.value:.3g} noise floors, and {caveat.seconds:.1f} s of "
                f"{steady} are too short to be sure of that"
            )
        case "far":
            reason = f"a channel stands at {caveat.value:.3g} noise floors, and nothing says that it surely does"
        case "creeping":
            reason = (
                f"friction of {caveat.of} is less than Coulomb's below {caveat.value:.2g} rad/s, or there is "
                f"{at_place(*caveat.rival)}: these logs do not tell the two apart"
            )
        case "feet_alike":
            much = "too much" if caveat.value > 0.0 else "too little"
            more = "more" if caveat.value > 0.0 else "less"
            reason = (
                f"either {caveat.of} all read {100.0 * abs(caveat.value):.1f} ± {100.0 * caveat.needed:.1f} % {much}, "
                f"or every link weighs and every motor gives as much {more} than stated. Nothing in these logs "
                "tells the two apart; weigh the robot"
            )
        case "spoiled":
            reason = f"the doctor holds {caveat.of} for spoiled, and no other log can be fitted; mend that first"
        case "declared":
            others = f" and {counted(caveat.others, 'other channel')}" if caveat.others else ""
            reason = f"{channel(caveat.of)}{others} {declared_words(caveat.others + 1, caveat.rival)}"
        case _:
            reason = "no log was held out"
    return f"cannot judge: {reason}"


def declared_words(channels: int, sources: Sequence[str]) -> str:
    """`stand above the noise, no further than what is declared of … lets them; take zeros …`."""
    of = listed([source_words(each) for each in sources])
    advice = "; ".join(source_advice(each)[:1].lower() + source_advice(each)[1:].rstrip(".") for each in sources)
    stands = "stands above the noise, no further than the declared uncertainty lets it" if channels == 1 else (
        "stand above the noise, no further than the declared uncertainty lets them")  # fmt: skip
    return f"{stands} ({of}); {advice}"


def consequence_words(found: Consequence) -> str:
    """The quantity that a named effect changes."""
    if found.what in ("stiffness", "natural_length"):
        return CONSEQUENCES[found.what].format(" of ".join(found.of))
    return CONSEQUENCES[found.what].format(*found.of)


def band_note(band: BandEstimate) -> str:
    """Why a band's values are not decided, and what else is in the model that has them."""
    return "; ".join(
        part for part in (sentence(band.note) if band.note else "", WITH_EFFECTS if band.with_effects else "") if part
    )


def _of_robot(finding: Finding, basis: OfRobot) -> str:
    held = _named(finding)
    log = held.log
    which = f"the error in {log}, the one log that has it," if log else "the held-out error"
    return (
        f"{_opening(finding.named_at)}{basis.effect.sentence} Without it the model lacks "
        f"{_strongest(finding)}. Added, {which} {_falls(held)}, {told(100 * held.explained, '.0f', '%')} of the excess."
        f"{_next_best(finding)}{_continued(basis.continued)}"
    )


def _of_band(finding: Finding, basis: OfBand) -> str:
    held, moment = _named(finding), basis.moment
    name = f"{finding.place.name}{f' of {basis.device}' if basis.device else ''}"
    added = f"Added, the error of the supporting torque on {LEFT_OUT[basis.left_out]} {_falls(held)}"
    added += f", {told(100 * held.explained, '.0f', '%')} of the excess."
    of = next((each for each in ("stiffness", "natural_length") if f"stated_{each}" in finding.parameters), None)
    if of is not None:
        found, stated = finding.parameters[of], finding.parameters[f"stated_{of}"]
        share = told(100.0 * (found.value / stated.value - 1.0), "+.0f", "%")
        return (
            f"{name}: {basis.effect.sentence} Its {of.replace('_', ' ')} is "
            f"{plus_minus(found.value, found.std, found.unit, ('.4g', '.2g'))}, "
            f"{told(stated.value, '.4g', stated.unit)} are stated ({share}). {added}"
        )
    when = ""
    if moment is not None:
        stays = ", and stays so in later logs" if moment.stays else ""
        when = f" It happens {told(moment.at, '.1f', 's')} into {moment.log}{stays}."
    joint = held.channel.removeprefix("support.")
    return (
        f"{name}: {basis.effect.sentence}{when} Without it the model of the wear lacks {_strongest(finding)} on "
        f"{joint}. {added}{_next_best(finding)}"
    )


def _touched(finding: Finding, basis: Touched) -> str:
    said = [
        f"{each.log} from {told(each.start, '.2f', 's')} on for {told(each.duration, '.2f', 's')}, with "
        f"{plus_minus(each.force.value, each.force.std, 'N', ('.1f', '.1g'))} at its largest"
        for each in basis.touches
    ]
    held = finding.held_out
    return (
        f"{finding.place.name}: something touched it that no log tells of, in {' and in '.join(said)}. "
        f"{channel(held.channel)} is off by up to {told(basis.lacks, '.2g', held.unit)} then, and one force at this "
        f"link explains {told(100 * finding.score, '.0f', '%')} of what all channels show. Nothing like it comes at "
        "other moments. This time is left out of the fit and of the errors."
    )


def _beside_stated(finding: Finding, basis: BesideStated) -> str:
    held, found = finding.held_out, finding.parameters
    if "mass" in found:
        more = f"weighs {plus_minus(found['mass'].value, found['mass'].std, 'kg', ('+.2f', '.2f'))}"
        said = f"{more} beside what its maker says and doubts by ±{NO_BREAK}{told(basis.doubt, '.2g', 'kg')}"
    else:
        ratio, stated = found["ratio"], found["stated"]
        share = plus_minus(100.0 * (ratio.value - 1.0), 100.0 * ratio.std, "%", ("+.1f", ".1f"))
        if stated.unit == "1":
            doubt = told(100.0 * basis.doubt, ".0f", "%")
            said = f"its motor gives {share} beside the torque that is logged, of which {doubt} are doubted"
        else:
            said = (
                f"its motor gives {share} of torque per ampere beside what its maker says "
                f"({told(stated.value, '.4g', stated.unit)}) and doubts by ±{NO_BREAK}"
                f"{told(100.0 * basis.doubt, '.2g', '%')}"
            )
    return (
        f"{finding.place.name}: {said}. With the maker's value of this alone the held-out error of "
        f"{channel(held.channel)} is {told(held.rmse_before, '.2g', held.unit)} RMSE, with the identified one "
        f"{told(held.rmse_after, '.2g')} (noise floor {told(held.noise_floor, '.2g')})."
    )


def _low_passed(finding: Finding, basis: LowPassed) -> str:
    held, cutoff = finding.held_out, finding.parameters["cutoff"]
    late = "without delay"
    if basis.delay_s is not None:
        late = f"which makes them {told(1e3 * basis.delay_s, '.0f', 'ms')} late"
    error = f"held-out error of {channel(held.channel)}"
    if basis.judges:
        error = f"error of {channel(held.channel)} in {', '.join(basis.judges)}"
    return (
        f"The signals were low-passed at {plus_minus(cutoff.value, cutoff.std, 'Hz', ('.2f', '.2f'))} (where half of "
        f"an amplitude is left; {basis.kind.capitalize()}, order {basis.order}, {late}) before they were stored: the "
        "sensors' noise fades above, and in every joint friction turns round as slowly as such a filter does. With the "
        f"model passed through the same low-pass the {error}, turns included, falls from "
        f"{told(held.rmse_before, '.2g')} to {told(held.rmse_after, '.2g', held.unit)} RMSE. {FLOORS[basis.floor]}"
    )


def _refined(finding: Finding) -> Iterator[str]:
    """What came to a finding after it was named."""
    after = [*(each.before for each in finding.refined[1:]), finding.held_out]
    for each, held in zip(finding.refined, after, strict=bool(finding.refined)):
        error = told(held.rmse_after, ".2g", held.unit)
        share = f"{told(100 * held.explained, '.0f', '%')} of the excess is gone"
        match each.what:
            case "shape":
                yield f"With its shape sought again in the model that has it the error is {error}: {share}."
            case "own_curve":
                yield "Its curve is not quite that of the formula."
                yield f"With one of its own the error is {error}: {share}."
            case "remainder":
                yield f"What is left beside it looks like {effect_words(each.effect)}, and is too small for a name."
                yield f"With that in the model the error is {error}: {share}."
    if finding.as_drawn:
        names = " and ".join(finding.as_drawn)
        yield f"The curve is known as drawn; its formula's {names} these data do not decide, and no number is given."


def _named(finding: Finding) -> HeldOut:
    """The error as it was when the effect was named."""
    return finding.refined[0].before if finding.refined else finding.held_out


def _falls(held: HeldOut) -> str:
    after = told(held.rmse_after, ".2g", held.unit)
    return f"falls from {told(held.rmse_before, '.2g')} to {after} RMSE (noise floor {told(held.noise_floor, '.2g')})"


def _strongest(finding: Finding) -> str:
    """Where what is missing is largest: `up to +3.1 N·m at a velocity of 0.02 rad/s`."""
    shown, unit = finding.evidence, finding.held_out.unit
    if not len(shown.at):
        return "it"
    k, over = int(np.nanargmax(np.abs(shown.before))), shown.coordinate.replace("_", " ")
    way = " along the motion" if shown.along_motion else ""
    at = told(shown.at[k], ".3g" if isinstance(finding.basis, OfBand) else ".2g", shown.unit)
    return f"up to {told(shown.before[k], '+.2g', unit)}{way} at a {over} of {at}"


def _next_best(finding: Finding) -> str:
    best = max(finding.alternatives, key=lambda each: each.score, default=None)
    if best is None or best.score < LEAST:
        return ""
    return f" The next best, {titled(best.effect, best.place)}, explains {told(100 * best.score, '.0f', '%')}."


def _continued(beyond: Continued | None) -> str:
    if beyond is None:
        return ""
    return (
        f" The held-out logs reach a {beyond.coordinate} of {told(beyond.reached, '.3g', beyond.unit)}, what was "
        f"fitted ends at {told(beyond.fitted, '.3g', beyond.unit)}: between them the formula is only continued."
    )


def _opening(place: Place) -> str:
    """What a sentence on a place begins with: `torso_pitch: `; nothing of the base, whose sentences name it."""
    if place.kind == "base":
        return ""
    words = place_words(place.kind, place.name, place.part)
    return f"{words if place.name != ALL else words[:1].upper() + words[1:]}: "


def _shares(pair: Apart) -> str:
    """How much more of what sets them apart there would be; nothing where the share does not grow."""
    if pair.left_then <= pair.left_now:
        return ""
    then = f"{_percent(pair.left_now)} was left in these logs, {_percent(pair.left_then)} would be. "
    return f"Of what tells it from {effect_words(pair.rival)} {then}"


def _evidence(pair: Apart) -> str:
    holds = told(pair.evidence_now, ".1f" if pair.evidence_now < 9.95 else ".0f")
    these = f"Between it and {effect_words(pair.rival)} these logs hold evidence of {holds}"
    return f"{these}; this adds {told(pair.evidence, '.0f')}, where {pair.enough:.0f} is enough."


def not_told(pair: Apart) -> str:
    """That no motion helps."""
    never = f"No motion that was tried tells it from {effect_words(pair.rival)} at {pair.place}"
    if pair.left_then < ALIKE:
        return f"{never}: on each of them both look the same."
    left = f"{_percent(pair.left_then)} of what tells them apart would be left, which is small beside the noise"
    return f"{never} within {pair.longest / 60.0:.0f} minutes: {left}."


def _percent(share: float) -> str:
    """`12 %`, `below 0.1 %`."""
    value = 100.0 * share
    return f"below 0.1{NO_BREAK}%" if value < 0.1 else told(value, ".1f" if value < 9.95 else ".0f", "%")
