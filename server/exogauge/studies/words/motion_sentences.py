"""What to record, to tell a finding from what it may be, too."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.findings.basis import BesideStated, LowPassed, OfBand, OfRobot, Touched
from exogauge.findings.planned_motion import Apart, PlannedMotion
from exogauge.findings.result import Finding
from exogauge.findings.verdict import Why
from exogauge.studies.words.names import NO_BREAK, capital, effect_words, listed, told

TOUCH_AGAIN = (
    "The same contact once more while all joints between these links and the base move at steady speed: a joint that "
    "rests or turns does not show what pulls at it. A force/torque sensor below them tells more."
)
TURN = "Turn each of these links about axes of its own, fast and with gravity across it, while the others rest."
HOLD = "Hold a load of known weight with this joint, level and hanging, and repeat the same motion without it."
ALIKE = 0.02  # of an effect left beside the other, below which they count as one


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
