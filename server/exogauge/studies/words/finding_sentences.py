"""What was found, in sentences: from the data of `findings`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from exogauge.devices.result import BandEstimate
from exogauge.findings.as_told import ALL
from exogauge.findings.basis import BesideStated, Continued, FloorOf, LeftOut, LowPassed, OfBand, OfRobot, Touched
from exogauge.findings.result import Concentration, Consequence, Excess, Finding, HeldOut, Place
from exogauge.studies.words.names import (
    NO_BREAK,
    channel,
    effect_words,
    place_words,
    plus_minus,
    titled,
    told,
)
from exogauge.studies.words.remark_words import sentence

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
CONSEQUENCES = {
    "rmse": "RMSE of approach B · {}, {}, {}",
    "group_stiffness": "stiffness of group {} by approach {} · {}",
    "stiffness": "stiffness of {}, without and with the wear's effects",
    "natural_length": "natural length of {}, without and with the wear's effects",
}
WITH_EFFECTS = "with what was named of the bands in the model"
LEAST = 0.005  # share of the excess: below, a rival explains none of it


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


def where_words(excess: Excess) -> str:
    """At which speeds, positions or times, or in which log, an error is largest."""
    where: Concentration = excess.where
    if where.moments:
        moments = [f"{told(at, '.0f', 's')} of {log}" for log, at in where.moments]
        return f"in a few moments: at {', '.join(moments)}"
    most = (
        f"most in {_listed(where.logs)}, up to {told(where.times, '.2g')} times what it is in all" if where.logs else ""
    )
    if where.coordinate is None:
        return most or ("with the wear on" if excess.channel.startswith("support.") else "throughout")
    over = "time since the start" if where.coordinate == "time" else where.coordinate
    at = f"at a {over} {'above' if where.above else 'below'} {told(where.at, '.3g', where.unit)}"
    return f"{at}; {most}" if most else at


def _listed(logs: Sequence[str]) -> str:
    return ", ".join(logs) if len(logs) < 4 else f"{', '.join(logs[:2])} and {len(logs) - 2} more logs"


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
