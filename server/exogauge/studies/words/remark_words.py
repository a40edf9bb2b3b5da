"""What has to be kept in mind of a result, in sentences: from the data of `exogauge.remarks`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from exogauge.remarks import About, Remark

SHOWN_NAMES = 3
_DISAGREE = "The stiffness from {names} disagrees by {0:.3g} ± {1:.2g} N/m. "
_LOAD = "The known load of {names} "


@final
@dataclass(frozen=True)
class Form:
    """text: with {names}, {beside}, {spans} and numbers by their place. each: of one name, its numbers by their place.
    joined: names, by what."""

    text: str
    each: str = "{name}"
    joined: str = ", "


FORMS: Mapping[About, Form] = {
    About.INERTIA_RAISED: Form(
        "{file}: no body has the inertia of {names}; at '{worst}' it misses by {0:.2g} kg·m² (principal moments "
        "{1:.4g}, {2:.4g}, {3:.4g}). The nearest possible one is taken: correct the URDF if it matters.",
        each="'{name}'",
    ),
    About.TOO_DENSE: Form(
        "{beside}: its links weigh {0:.4g} kg, and by their inertias half of that is denser than {1:.2g} kg/m³: no "
        "matter is. Masses are in kg and inertias in kg·m²: were the masses written in grams?"
    ),
    About.TOO_LIGHT: Form(
        "{beside}: its links weigh {0:.4g} kg, and by their inertias half of that is lighter than {1:.2g} kg/m³: no "
        "robot is. Masses are in kg and inertias in kg·m²: were the inertias written in kg·mm² or g·mm²?"
    ),
    About.NO_EXTENT: Form(
        "{beside}: its links weigh {0:.4g} kg, and half of that has an inertia of zero along some axis, which no body "
        "has: give those of the maker, or of a box of the link's size."
    ),
    About.MASSES_ALIKE: Form(
        "{beside}: each of its {1:.0f} links that weigh weighs {0:.4g} kg, as where a number stands in for what nobody "
        "knew. Masses that the logs do not tell stay as they are stated there: give those of the maker, or state that "
        "they are not known (`inertial_prior_std` in robot.yaml)."
    ),
    About.LIMITS_IN_DEGREES: Form(
        "{beside}: half of the joints that turn do so to {0:.3g} rad and more. Limits of a URDF are in rad: were they "
        "written in degrees? Units of logs and planned motions rest on them."
    ),
    About.MOVES_NOTHING: Form(
        "{beside}: nothing that weighs hangs on {names}. Masses are found from those of the URDF on: give the links "
        "that these joints move an <inertial>, an estimate will do."
    ),
    About.FACTOR_OPEN: Form(
        "Only currents were logged and no outside force was measured, so torques, masses and k_T are known up to one "
        "common factor, which the maker's values decide. To fix it, log a force/torque sensor, or carry a weighed load "
        "in some of the logs and state it (`known` in study.yaml). What is listed as not identifiable is so even if "
        "that factor were known; errors are told in N·m by the stated k_T."
    ),
    About.LOAD_NOT_FITTED: Form(
        _LOAD + "is in none of the logs that are fitted, so it does not fix that factor. Name one with role "
        "identification among its `logs`.",
        each="{0:.4g} kg at {name}",
    ),
    About.LOAD_IN_EVERY_LOG: Form(
        _LOAD + "is carried in every log that is fitted: it cannot be told from its link's own mass, counts as "
        "uncertain as that, and does not fix that factor. Record one without it, or with another mass, on the same "
        "axes.",
        each="{0:.4g} kg at {name}",
    ),
    About.LOAD_FELT_TOO_LITTLE: Form(
        _LOAD + "is felt too little to fix that factor: it takes its doubt from {percent[0]} to {percent[1]}. Carry a "
        "heavier one further out, through postures in which more joints feel it.",
        each="{0:.4g} kg at {name}",
    ),
    About.HELD_AT_EDGE: Form("At the edge of what is physically possible, and held there: {names}."),
    About.STICKS_UNEQUALLY: Form(
        "At rest, friction does not always take its largest value. What is given as tau_s is what is usual there, a "
        "lower bound of the static friction, at {names}."
    ),
    About.LITTLE_STEADY: Form(
        "Of what these joints move, less than {percent[0]} is steady motion, which alone is fitted: {names}. Record "
        "longer moves in one direction, or raise cutoff_hz: less is left out around every turn then.",
        each="{name} ({0:.1f} of {1:.1f} s)",
    ),
    About.ONE_DIRECTION: Form("Steady in one direction only: {names}. Coulomb friction and offset look alike there."),
    About.HARDLY_SLIDES: Form(
        "Hardly further than {0:.2g} {beside} from one turn to the next go {names}. There friction is a gear that "
        "gives way, not Coulomb's: no parameter of these joints is taken for identified. Let them swing further.",
        each="{name} (beyond in {0:.0%} of its steady motion)",
    ),
    About.CREEPING: Form(
        "Friction turns round over a span of speeds, not at once, while these joints creep: {names}. What they do "
        "there is not taken for steady motion: it is neither fitted nor judged.",
        each="{name} (below {0:.2g} {beside})",
    ),
    About.FEET_AGAINST_MASS: Form(
        "The contact sensors weigh the robot to be {0:.4g} ± {1:.2g} kg, its maker {2:.4g} ± {3:.2g} kg. Masses, k_T, "
        "supporting torque and stiffness are all in proportion to what these sensors read: weigh the robot, and state "
        "the sensors' gain (`uncertainty`), or correct the masses of the URDF."
    ),
    About.NEGATIVE_MASS: Form(
        "The data ask for a negative mass of {names}, which no body has: what is given is the nearest that can be, and "
        "does not explain them. Is the sign of a sensor, a current or a torque stated the wrong way round?",
        each="{name} ({0:.3g} ± {1:.2g} kg)",
    ),
    About.CENTRE_LET_GO: Form(
        "The logs contradict the stated centre of mass of {names}. It is believed no more than that: all that is "
        "stated of the link counts as that much more doubtful. Is it the link that the URDF describes?",
        each="{name} (by {0:.0f} stated standard deviations; now ± {1:.2g} % of its radius of gyration)",
    ),
    About.MASS_LET_GO: Form(
        "The logs contradict the stated mass of {names}. It is believed no more than that: all that is stated of the "
        "link counts as that much more doubtful. Is it the link that the URDF describes?",
        each="{name} (by {0:.0f} stated standard deviations; now ± {1:.2g} %)",
    ),
    About.GAIN_LET_GO: Form(
        "The logs contradict the stated k_T of {names}. It is believed no more than that. Is it the motor and the gear "
        "that robot.yaml describes?",
        each="{name} (by {0:.0f} stated standard deviations; now ± {1:.2g} %)",
    ),
    About.LEFT_WITHOUT_SEARCH: Form(
        "Held-out logs leave more than noise: {names}. All that is fitted beside it counts as that much more doubtful. "
        "Nothing has looked for why: the step `discrepancy` does.",
        each="{name} ({0:.2g} of its noise)",
    ),
    About.NOT_CONVERGED: Form(
        "The search among possible bodies stopped after {0:.0f} steps, {1:.2g} squared standard deviations above the "
        "minimum at most; {2:.2g} was asked for."
    ),
    About.REFERENCE_IMPOSSIBLE: Form(
        "The a-priori inertia of {names} is not physically possible, or nearly not: the nearest possible one is the "
        "reference instead."
    ),
    About.UNDECIDED_COMBINATIONS: Form(
        "{0:.0f} combinations of the non-inertial parameters are decided by nothing: the smallest values are given."
    ),
    About.WORSE_HELD_OUT: Form(
        "Held-out logs are predicted worse than by the maker's numbers at {names}. Believe nothing of these joints."
    ),
    About.LOGS_LEFT_OUT: Form(
        "In {names} efforts and positions are of clocks that began apart: nothing is fitted to, or judged by, these "
        "logs. State that delay in their mapping to have them back.",
        each="{name} ({0:+.2f} s)",
    ),
    About.LOGS_SPOILED: Form(
        "Left out, as the doctor holds it for spoiled: {names} ({file}). Nothing is fitted to it, or judged by it. To "
        "have it back, do what the doctor advises: {worst}."
    ),
    About.SPOILED_FIT: Form(
        "What is fitted is spoiled: {names} ({file}). No other log is there to be fitted, so no effect is named and no "
        "number that rests on it counts as decided by the data. Mend that first: {worst}."
    ),
    About.LATE_FIT: Form(
        "What is fitted is of other moments than its positions: {names} ({file}). No delay that explains it is in the "
        "model, so no number that rests on it counts as decided by the data. Mend that first: {worst}."
    ),
    About.DOCTOR_ERRORS: Form(
        "The doctor holds {names} for wrong, and all that is told here rests on it. Mend that first, as it says."
    ),
    About.NO_URDF_OF: Form(
        "No URDF with identified inertias was written, because no body can have those of {names}. Ask for physical "
        "consistency in the settings to get one."
    ),
    About.TOUCHED: Form(
        "{names}, {spans}: something touched the robot. This time is left out of the supporting torque, of the bands "
        "and of their doubt."
    ),
    About.LOW_PASSED: Form(
        "The signals of {names} were low-passed at {0:.2f} Hz before they were stored. What the model says of them "
        "passes the same low-pass, so what is faster shows in no supporting torque."
    ),
    About.STORED_UNLIKE: Form(
        "{names} with the device were not stored like {beside}. Around starts, stops and turns approach A compares "
        "what is not alike: record all logs alike."
    ),
    About.MOTION_DOUBTFUL: Form(
        "{names} differ in the motion of {beside}: {percent[0]} of its rms velocity (limit {percent[1]}), {2:.3g} rad "
        "rms. Approach A takes off what the model says of the difference; unmodelled friction is not taken off.",
        joined=" and ",
    ),
    About.SESSION_UNKNOWN: Form(
        "When these logs began is not said: {names}. So what motors do as they warm up cannot be told from the device, "
        "and all that is declared of it stays in doubt. Say it of every log (`started`, in seconds from the first)."
    ),
    About.NO_RUN_AFTER: Form(
        "No log without the device was recorded after the last one with it: {names}. Record each motion without, with "
        "and without the device again, so that what motors and sensors do meanwhile is not taken for the device."
    ),
    About.DRIFT_FOUND: Form(
        "From the first to the last logs without the device, motors changed what they give per ampere (k_T) or how "
        "they rub (k_d, tau_c); by the end of the session: {names}. It is taken off all estimates; what is left in "
        "doubt of it is in their budgets.",
        each="{name} {0:+.1f} ± {1:.1f} %",
    ),
    About.ZEROS_FOUND: Form(
        "Zeros of the feet's sensors moved through the session, as the whole robot's balance of forces tells; by its "
        "end the sum of all feet by {names} [N, N·m]. It is taken off all estimates; what is left in doubt of it, and "
        "how the feet share it, is in their budgets.",
        each="{name} {0:+.1f} ± {1:.1f}",
    ),
    About.LABELS_EXCHANGED: Form(
        "Labels look exchanged in {names}: the bands of {beside} pull where study.yaml says `without_device`, and do "
        "not where it says `with_device`. Check `role` of these logs; believe nothing of the device until then.",
    ),
    About.DEVICE_ON: Form(
        "It looks as if {beside} was on in {names}, which study.yaml says are without it. Check `role` of these "
        "logs; if it is right, the robot is not known well enough for approach B.",
    ),
    About.DEVICE_OFF: Form(
        "It looks as if {beside} was not on in {names}, which study.yaml says are with it: its bands pull in the "
        "other logs of that motion only. Check `role` and files of these logs.",
    ),
    About.DEVICE_ON_WHERE_FITTED: Form(
        "In {names}, without {beside}, the robot lacks just what its bands would give: it looks as if it was on in "
        "the logs of role identification. Record these without it; if they are, the robot is not known well enough. "
        "Believe nothing of the device until then.",
    ),
    About.NOT_OF_BANDS: Form(
        "What is measured with {beside} on is not what its bands could give: fitted as they run in the device file, "
        "they leave {names}. A load that these logs alone carry, bands that the file lacks or lays elsewhere, or "
        "another device look so. Believe nothing of the device until then.",
        each="{0:.3g} of {1:.3g} N·m in {name}",
    ),
    About.WORN_WEIGHT: Form(
        "With {beside} on, the feet bear {0:.2g} ± {1:.1g} kg more than without. It is the device's own weight, or a "
        "load that these logs alone carry: the supporting torque holds what it does to joints, which no band gives, "
        "and what is told of the bands rests on there being none.",
    ),
    About.BANDS_OF_FILE: Form("stiffness and natural length of the device file"),
    About.BANDS_UNKNOWN: Form("none: the device file gives no stiffness or natural length"),
    About.BANDS_IDENTIFIED: Form("the device file, and what it does not say as identified by approach {beside}"),
    About.LAW_STATED: Form(
        "Fitted with the law that device.yaml states, its values as stated and not doubted: {names}.",
        each="{name} ({beside})",
    ),
    About.STIFFNESS_NOT_AS_STATED: Form(
        "By more than five of its standard deviations the logs contradict the stiffness that the device file states of "
        "{names}.",
        each="{name} ({0:.4g}, stated {1:.4g} N/m)",
    ),
    About.LENGTH_NOT_AS_STATED: Form(
        "By more than five of its standard deviations the logs contradict the natural length that the device file "
        "states of {names}.",
        each="{name} ({0:.4g}, stated {1:.4g} m)",
    ),
    About.LENGTHS_TIED: Form(
        "These motions cannot tell the natural lengths of {names} apart, so one is given for all of them. A motion "
        "that lengthens them differently, such as a twist beside a bend, would.",
        joined=" and ",
    ),
    About.PULLS_NOWHERE: Form(
        "{names} pulls nowhere in these motions, as if slack throughout: they say nothing of it."
    ),
    About.NOT_TOLD_APART: Form("These motions cannot tell {names} from {beside}.", joined=" and "),
    About.NOT_TOLD: Form("These motions say nothing of {names}."),
    About.BANDS_LEFT_OUT: Form("Left out of `before`, for their values are not known: {names}."),
    About.OWN_GROUP: Form(
        "Band {names} is now a group of its own: bands of group {beside} share their stiffness and law."
    ),
    About.SLACK: Form("Band {names} is slack all the time."),
    About.BOUND_REACHED: Form(
        "The search ended at the bound of {names}, so what is told is no minimum. A torque that is no band's, or a "
        "band that runs elsewhere than stated, can do that.",
        joined=" and ",
    ),
    About.APPROACHES_DISAGREE: Form(
        _DISAGREE + "What can do it: motions that were not repeated alike, k_T or a foot sensor's gain or zero that "
        "drifted between logs, friction that the model lacks.",
        joined=" and ",
    ),
    About.REPETITIONS_DISAGREE: Form(
        _DISAGREE + "What can do it: a suit that was put on otherwise or slipped, k_T or a zero that drifted, a log "
        "that something touched.",
        joined=" and ",
    ),
    About.STROKES_DISAGREE: Form(
        _DISAGREE + "What can do it: friction of the joint or of the band at its via points, hysteresis, a sensor that "
        "lags.",
        joined=" and ",
    ),
    About.PULLS_DISAGREE: Form(
        _DISAGREE + "What can do it: bands that harden or soften, a strap or an anchor that gives way, a band that "
        "comes taut gradually.",
        joined=" and ",
    ),
    About.RELAXATION: Form(
        "The bands pull more {names}, by {0:.3g} ± {1:.2g} N/m. What can do it: straps, cloth or rubber that creep, a "
        "strap that gives way and comes back, a sensor that lags. The stiffness is another one for each pace.",
        joined=" than ",
    ),
    About.SIDES_DISAGREE: Form(
        _DISAGREE + "What can do it: via points that are not where they are stated, bands that are not alike, one that "
        "was put on otherwise, a foot sensor's gain.",
        joined=" and ",
    ),
    About.LENGTHS_DISAGREE: Form(
        "The bands do not pull alike in {names}: with one stiffness for both their natural lengths disagree by {0:.2g} "
        "± {1:.2g} m. What can do it: friction of the joint or of the band at its via points, hysteresis, a sensor "
        "that lags; between logs, a suit that was put on otherwise or slipped, or something that only one log carries.",
        joined=" and ",
    ),
    About.HALVES_DISAGREE: Form(
        "Its natural length is another one through a log: {names} disagree by {0:.2g} ± {1:.2g} m. What can do it: a "
        "strap or an anchor that slipped, a suit that moved. Record that log again, or evaluate the part before alone "
        "(`rows`).",
        joined=" and ",
    ),
    About.SPRINGS_MISFIT: Form(
        "These springs do not explain what the device does: more is left at {names}, by which the stiffness may be off "
        "by {0:.3g} N/m, where its doubt is {1:.2g} N/m. What can do it: a strap or an anchor that gives way, bands "
        "that harden, rub or are slow, via points that are not where they are stated.",
        joined=" than ",
    ),
    About.STIFFNESS_OPEN: Form(
        "The doubt is more than half of the value: a motion that stretches this band further would decide."
    ),
    About.ALONE_IN_GROUP: Form(
        "{names} pulls nowhere, or may, and has its stiffness from others of group {beside} alone: they may pull for "
        "it, if it does not run as stated. Look at its via points and links; a band that is worn slack needs a group "
        "of its own.",
        joined=" and ",
    ),
    About.ANOTHER_FIT: Form(
        "The logs contradict another fit no more, in which {names} has {0:.3g} N/m: one band may pull for two, or come "
        "taut elsewhere. A motion that stretches the bands of the group unlike would decide."
    ),
    About.LENGTH_OPEN: Form("The natural length is hardly decided by these motions."),
}


def sentence(remark: Remark) -> str:
    """With all names."""
    form = FORMS[remark.about]
    return _filled(remark, form.joined.join(named_with_numbers(remark)))


def short_sentence(remark: Remark) -> str:
    """`… of a, b, c and 4 more. Ask …`: a long list is cut to the first few."""
    return _filled(remark, named(named_with_numbers(remark), FORMS[remark.about].joined))


def named_with_numbers(remark: Remark) -> list[str]:
    """`elbow (0.3 of 4.1 s)`, one for each name."""
    form, alike = FORMS[remark.about], len(remark.beside) == len(remark.names)
    beside = remark.beside if alike else [""] * len(remark.names)
    numbers = remark.each or [()] * len(remark.names)
    return [
        form.each.format(*own, name=name, beside=other)
        for name, other, own in zip(remark.names, beside, numbers, strict=True)
    ]


def named(names: Sequence[str], joined: str = ", ") -> str:
    """`a, b, c and 4 more`"""
    if len(names) <= SHOWN_NAMES:
        return joined.join(names)
    return f"{', '.join(names[:SHOWN_NAMES])} and {len(names) - SHOWN_NAMES} more"


def _filled(remark: Remark, names: str) -> str:
    spans = zip(remark.numbers[::2], remark.numbers[1::2], strict=False)
    return FORMS[remark.about].text.format(
        *remark.numbers,
        names=names,
        beside=", ".join(remark.beside),
        file=remark.beside[0] if remark.beside else "",
        worst=remark.beside[-1] if remark.beside else "",
        spans=" and ".join(f"from {start:.2f} to {stop:.2f} s" for start, stop in spans),
        percent=[_percent(each) for each in remark.numbers],
    )


def _percent(share: float) -> str:
    return "unknown" if math.isnan(share) else f"{100 * share:.2g} %"
