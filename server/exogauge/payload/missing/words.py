"""What was found missing, in sentences; made once, when results are written."""

from __future__ import annotations

from exogauge.findings.verdict import Caveat
from exogauge.payload.dynamics import UNKNOWN_CAUSE
from exogauge.payload.missing.search import Finding, Missing
from exogauge.studies.words.rounding import with_std

EFFECTS = {
    "inclination": "the base is inclined",
    "zero_of_log": "the sensor's zero is another one in {place}",
    "zero_step": "the sensor's zero jumps in {place}",
    "zero_drift": "the sensor's zero drifts",
    "crosstalk": "crosstalk: {place}",
    "gain": "a wrong gain of {place}",
    "calibration": "gains of the {place} against their mean, and crosstalk",
    "turned": "the axes of the {place}'s wrench stand off those of its frame",
    "delay": "the wrench is late against the pose",
    "spring": "the payload gives way along {place} of the sensor",
    "second_body": "a part of the payload hangs loose, on springs",
}


def said_of(finding: Finding) -> str:
    """What, how much, and what held-out samples say."""
    numbers = ", ".join(f"{each.name} {_pm(each.value, each.std)} {each.unit}" for each in finding.parameters)
    size = numbers or "how much cannot be told: errors of the kinematics look like it"
    what = name_of(finding.effect, finding.place)
    rivals = " or ".join(name_of(*each) for each in finding.rivals)
    rest = f" As good: {rivals}." if rivals else ""
    gap = f"{finding.before:.2f} to {finding.after:.2f} times the noise"
    return f"{what[0].upper()}{what[1:]}: {size}. What was not fitted goes from {gap}.{rest}"


def name_of(effect: str, place: str) -> str:
    return EFFECTS[effect].format(place=place)


def verdict_of(missing: Missing) -> str:
    """Headline."""
    verdict = missing.decision.verdict
    if verdict == "effects":
        named = "; ".join(name_of(each.effect, each.place) for each in missing.found)
        return f"Missing: {named}. {_held(missing)}"
    if verdict == "unexplained":
        worst = max((float(ratios.max()), log) for log, ratios in missing.after.items())
        return f"Something is missing that nothing here explains: up to {worst[0]:.3g} times the noise in {worst[1]}."
    if verdict == "undecided":
        return f"Whether something is missing cannot be told: {reason_of(missing.decision.reason)}."
    return f"Nothing is missing above the noise; {missing.tried} effects were looked for."


def _held(missing: Missing) -> str:
    if missing.in_the_model:
        others = " A gain that all axes share looks like mass: that is in the doubt." if missing.calibrated else ""
        rigid = "`missing.without` are those of a rigid body behind an ideal sensor alone."
        return f"All numbers here are with it; {rigid}{others}"
    why = (
        "its size is not known"
        if all(each.parameters for each in missing.found) is False
        else "it is not the only explanation"
    )
    return f"The numbers here are those of a rigid body alone and do not hold: {why}."


def cause_of_residual(missing: Missing, noisier: bool) -> str:
    """Why motion leaves more than the stated noise. noisier: whether the wrench was measured to be noisier than is
    stated by as much."""
    verdict = missing.decision.verdict
    if missing.found and missing.in_the_model:
        return "what was named missing is taken out already, so the noise is stated too small, or more is missing"
    if missing.found:
        return "; ".join(name_of(each.effect, each.place) for each in missing.found)
    if verdict == "unexplained":
        return "something is missing that nothing here explains"
    if verdict == "none" and missing.leans is not None:
        return "the base leans a little, or the noise is stated too small"
    if verdict == "none" and missing.late is not None:
        return "the wrench and the pose are not quite of the same time, or the noise is stated too small"
    if verdict == "none" and noisier:
        return "nothing is missing above the noise that was measured, so the noise is stated too small"
    if verdict == "none":
        return "something is missing that is too small to be named, and the numbers may be off by more than their doubt"
    return UNKNOWN_CAUSE


def reason_of(reason: Caveat | None) -> str:
    if reason is not None and reason.why == "too_short":
        return f"only {reason.value:.3g} s of motion in {reason.of}"
    if reason is not None and reason.why == "far":
        return f"{reason.of} stands at {reason.value:.3g} times its noise"
    if reason is not None and reason.why == "noise_unknown":
        return (
            "with an IMU or a low-pass the noise of the motion is not known, so nothing says how much may be left; "
            "joint angles or positions, not filtered, would tell"
        )
    if reason is not None and reason.why == "not_foretold":
        return (
            f"the excitation leaves numbers open on which {reason.of} depends: turn the wrist about all three axes in "
            "the excitation"
        )
    if reason is not None and reason.why == "no_motion":
        return "no excitation was recorded"
    return "no motion was kept from the fit"


def _pm(value: float, std: float) -> str:
    shown, doubt = with_std(value, std)
    return f"{shown} ± {doubt}"
