"""Why something was not named, or not judged: from the data of `findings`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

from exogauge.findings.verdict import Caveat, Objection, Why
from exogauge.studies.words.doubt_words import source_advice, source_words
from exogauge.studies.words.names import (
    NO_BREAK,
    at_place,
    channel,
    counted,
    effect_words,
    listed,
    plus_minus,
    told,
)

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
    Why.PARTIAL: "{at}it would explain {percent:.0f}{space}% of what is there and leave {beside:.2g} noise floors: "
    "something else is the cause",
    Why.OTHER_LAW: "{at}it would explain {percent:.0f}{space}% of what is there and leave {beside:.2g} noise floors: "
    "what is there follows another law",
    Why.ANOTHER_IN_EACH_LOG: "it is another one in each log: a change that stays from one log on would be "
    "{percent:.0f}{space}% of that",
    Why.SLOWER_ALONE: "the logs before it do not contradict it at the speeds of those that have it: it may be a matter "
    "of speed, not of the log",
    Why.AT_ITS_EDGE: "its size would be at the edge of what can be, and {at}leave {value:.2g} noise floors: something "
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
SOMEWHERE = (Why.PARTIAL, Why.OTHER_LAW, Why.AT_ITS_EDGE)  # what they say holds for one channel
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
        at=f"at {channel(found.of[0])} " if found.why in SOMEWHERE else "",
        error=f"{f'error in {log[0]}' if log else 'held-out error'} of {channel(on)}" if on else "",
        effects=listed([effect_words(each) for each in found.of]) or "what was named before",
        sizes=", ".join(f"{name} {plus_minus(each.value, each.std)}" for name, each in found.sizes.items()),
    )


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
                f"friction of {caveat.of} is less than Coulomb's below {caveat.value:.2g} {caveat.unit}, or there is "
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
