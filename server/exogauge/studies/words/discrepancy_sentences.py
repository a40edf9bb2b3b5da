"""The verdict of the search for missing effects in plain sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from exogauge.devices.result import Estimate
from exogauge.findings.result import Alternative, Discrepancy, Excess, Finding, HeldOut, Place
from exogauge.findings.verdict import Why
from exogauge.studies.words.names import capital, channel, counted, listed, place_words, titled
from exogauge.studies.words.reason_sentences import declared_words, reason_words
from exogauge.studies.words.rounding import significant

CHANGED = 0.1  # share of a quantity's doubt, below which it counts as unchanged
FLOORS = "floors"  # unit of a chain over channels of several units
NAMED = 3  # effects that the sentence names; it counts the others


def verdict_sentence(found: Discrepancy) -> str:
    """What is decided in `findings.verdict`."""
    if found.verdict == "effects":
        return _effects(found.findings)
    if found.verdict == "unexplained":
        return _unexplained(found)
    if found.verdict == "undecided":
        return f"Whether the model lacks an effect is undecided. {_reason(found)}"
    small = small_sentence(found)
    if small:
        return f"No effect that matters is missing as far as these logs can show. {small}"
    return (
        f"No effect is missing as far as these logs can show: {_none_of(found)} surely explains anything beyond noise."
    )


def small_sentence(found: Discrepancy) -> str:
    """What is surely there and takes off less than matters beside the sensors' noise, the likeliest of each place;
    empty where there is nothing of the kind."""
    small = [each for each in found.rejected if each.objection.why is Why.TOO_SMALL]
    best: dict[Place, Alternative] = {}
    for each in sorted(small, key=lambda one: -one.score):
        best.setdefault(each.place, each)
    if not best:
        return ""
    shown = [
        f"{titled(each.effect, each.place)} ({each.objection.value:.2g} where the sensors' noise is "
        f"{each.objection.beside:.2g})"
        for each in best.values()
    ][:NAMED]
    more = len(best) - len(shown)
    return f"There, and smaller than what matters: {listed([*shown, f'{more} more'] if more else shown)}."


def left_sentence(found: Discrepancy) -> str:
    """What is above the noise after all that was named; empty where the verdict has said it."""
    if found.verdict != "effects":
        return ""
    if found.decision.left == "nothing":
        return f"Nothing is left above the noise. {small_sentence(found)}".rstrip()
    if found.decision.left == "open":
        return f"Whether anything is left above the noise is undecided. {_reason(found)}"
    left = found.unexplained
    count = "One channel stays" if len(left) == 1 else f"{len(left)} channels stay"
    text = f"{count} above the noise, {'' if len(left) == 1 else 'most '}{_at_furthest(left)}."
    return f"{text} {_declared(found)}".rstrip()


def looked_at(result: Mapping[str, Any]) -> str:
    """How many candidates, channels and logs, and in which regime. result: all of results.json."""
    fits = [each for each in result["identification"]["validation"] if each["held_out"]]
    channels = dict.fromkeys(each["channel"] for each in fits)
    torques, readings = (sum(name.startswith(kind) for name in channels) for kind in ("tau.", "ft."))
    seen = [counted(torques, "joint torque"), *([counted(readings, "sensor reading")] if readings else [])]
    logs = dict.fromkeys(each["log"] for each in fits)
    return (
        f"Looked at: {listed(seen)} in steady motion on {counted(len(logs), 'held-out log')}; "
        f"{counted(result['discrepancy']['candidates'], 'candidate')}, each an effect at one place in one shape, "
        "fitted together with the whole model."
    )


def kind_of_channels(result: Mapping[str, Any]) -> str:
    """`torques`, or `channels` where sensors inside the robot were looked at too. result: all of results.json."""
    fits = result["identification"]["validation"]
    return "channels" if any(each["channel"].startswith("ft.") for each in fits) else "torques"


def moves(before: Estimate, after: Estimate) -> bool:
    """Whether a quantity changes by more than a tenth of its doubt (of itself where that is not known), or its doubt
    by more than a tenth."""
    value, std, later, later_std = before.value, before.std, after.value, after.std
    if not all(map(math.isfinite, (value, std, later, later_std))):
        return True
    doubt = max(std, later_std)
    return bool(abs(later - value) > CHANGED * (doubt or abs(value)) or abs(later_std - std) > CHANGED * doubt)


def chain_unit(unit: str) -> str:
    """What stands behind a number of the chain: channels of several units are told in multiples of their floors."""
    return "× floor" if unit == FLOORS else unit


def chain_words(unit: str) -> str:
    """What the chain's numbers are. unit: of its links."""
    multiples = ", each in multiples of its noise floor" if unit == FLOORS else ""
    return f"RMSE of the channels in question{multiples}"


def _effects(findings: Sequence[Finding]) -> str:
    names = [titled(each.effect, each.place) for each in findings]
    if len(names) == 1:
        held = findings[0].held_out
        where = f"in {held.log}, the one log that has it," if held.log else "on held-out logs"
        return (
            f"The identified model does not know of {names[0]}. With it the error of {channel(held.channel)} {where} "
            f"{_falls(held)} (noise floor {significant(held.noise_floor)})."
        )
    shown = [f"{name} ({_change(each)})" for name, each in zip(names, findings, strict=True)][:NAMED]
    more = len(names) - len(shown)
    told = listed([*shown, f"{more} more"] if more else shown)
    text = f"The identified model does not know of {len(names)} effects: {told}."
    return f"{text} The errors are those on held-out logs, without and with the effect."


def _falls(held: HeldOut) -> str:
    """`falls from 2.25 to 1.08 N·m RMSE`."""
    verb = "rises" if held.rmse_after > held.rmse_before else "falls"
    return f"{verb} from {significant(held.rmse_before)} to {significant(held.rmse_after)} {held.unit} RMSE"


def _change(finding: Finding) -> str:
    """`2.25 → 1.08 N·m, noise floor 1.02`; with the channel where it is not named like the place."""
    held, place = finding.held_out, finding.place
    name = channel(held.channel)
    text = f"{significant(held.rmse_before)} → {significant(held.rmse_after)} {held.unit}"
    text += f", noise floor {significant(held.noise_floor)}"
    return text if name == place_words(place.kind, place.name, place.part) else f"{name}: {text}"


def _unexplained(found: Discrepancy) -> str:
    text = "Measurement and model disagree by more than noise explains"
    worst = found.unexplained or found.located
    most = f", most {_at_furthest(worst)}" if worst else ""
    return f"{text}{most}, and {_none_of(found)} explains it on held-out logs. {_declared(found)}".rstrip()


def _declared(found: Discrepancy) -> str:
    """Of channels that are not unexplained, beside some that are."""
    within = found.declared
    if not within.channels:
        return ""
    names = listed([channel(each.channel) for each in within.channels])
    return f"{capital(names)} {declared_words(len(within.channels), within.sources)}."


def _at_furthest(found: Sequence[Excess]) -> str:
    """`at torso_yaw (1.31 N·m RMSE, noise floor 1.02)`: the one with the most standard errors above its floor."""
    worst = max(found, key=lambda each: each.z if math.isfinite(each.z) else -math.inf)
    numbers = f"{significant(worst.rmse)} {worst.unit} RMSE, noise floor {significant(worst.noise_floor)}"
    return f"at {channel(worst.channel)} ({numbers})"


def _none_of(found: Discrepancy) -> str:
    return f"none of {counted(found.candidates, 'candidate')}"


def _reason(found: Discrepancy) -> str:
    """`Cannot judge: 1.2 of 5 s of steady held-out motion at joint_2.`"""
    return f"{capital(reason_words(found.decision.reason))}."
