"""The verdict of the search for missing effects in plain sentences, from what results.json holds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from exogauge.findings.result import ChainStep
from exogauge.studies.words.effect_words import at_place, listed, place_words
from exogauge.studies.words.rounding import significant

CHANGED = 0.1  # share of a quantity's doubt, below which it counts as unchanged
PART = "axis"  # key of a place's part
FLOORS = "floors"  # unit of a chain over channels of several units
FIRST_MODELS = {"robot": "identified model", "bands": "supporting torque, bands as springs"}
NAMED = 3  # effects that the sentence names; it counts the others


def verdict_sentence(entry: Mapping[str, Any]) -> str:
    """entry: `discrepancy` of results.json; what it says is decided in `findings.verdict`."""
    if entry["verdict"] == "effects":
        return _effects(entry["findings"])
    if entry["verdict"] == "unexplained":
        return _unexplained(entry)
    if entry["verdict"] == "undecided":
        return f"Whether the model lacks an effect is undecided. {_reason(entry)}"
    return (
        "No effect is missing as far as these logs can show: "
        f"{none_of(entry['candidates'])} surely explains anything beyond noise."
    )


def _effects(findings: Sequence[Mapping[str, Any]]) -> str:
    names = [at(each) for each in findings]
    if len(names) == 1:
        held = findings[0]["held_out"]
        return (
            f"The identified model does not know of {names[0]}. With it the error of "
            f"{channel(held['channel'])} {judged_on(held)} {falls(held)} (noise floor {figure(held['noise_floor'])})."
        )
    shown = [f"{name} ({_change(each)})" for name, each in zip(names, findings, strict=True)][:NAMED]
    more = len(names) - len(shown)
    told = listed([*shown, f"{more} more"] if more else shown)
    text = f"The identified model does not know of {len(names)} effects: {told}."
    return f"{text} The errors are those on held-out logs, without and with the effect."


def judged_on(held: Mapping[str, Any]) -> str:
    """The logs that the errors are about: held-out ones, or the one log that has the effect."""
    return f"in {held['log']}, the one log that has it," if held.get("log") else "on held-out logs"


def falls(held: Mapping[str, Any]) -> str:
    """`falls from 2.25 to 1.08 N·m RMSE`."""
    before, after = held["rmse_before"], held["rmse_after"]
    verb = "rises" if before is not None and after is not None and after > before else "falls"
    return f"{verb} from {figure(before)} to {figure(after)} {held['unit']} RMSE"


def _change(finding: Mapping[str, Any]) -> str:
    """`2.25 → 1.08 N·m, noise floor 1.02`; with the channel where it is not named like the place."""
    held = finding["held_out"]
    name = channel(held["channel"])
    text = f"{figure(held['rmse_before'])} → {figure(held['rmse_after'])} {held['unit']}"
    text += f", noise floor {figure(held['noise_floor'])}"
    return text if name == place(finding) else f"{name}: {text}"


def _unexplained(entry: Mapping[str, Any]) -> str:
    text = "Measurement and model disagree by more than noise explains"
    worst = furthest(entry["unexplained"] or entry["located"])
    if worst:
        text += f", most at {channel(worst['channel'])} ({excess(worst)})"
    return f"{text}, and {none_of(entry['candidates'])} explains it on held-out logs."


def furthest(found: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """The excess with the most standard errors above its floor."""
    return max(found, key=lambda each: -math.inf if each["z"] is None else each["z"], default=None)


def excess(found: Mapping[str, Any]) -> str:
    """`1.31 N·m RMSE, noise floor 1.02`."""
    return f"{figure(found['rmse'])} {found['unit']} RMSE, noise floor {figure(found['noise_floor'])}"


def left_sentence(entry: Mapping[str, Any]) -> str:
    """What is above the noise after all that was named; empty where the verdict has said it."""
    if entry["verdict"] != "effects":
        return ""
    if entry["left"] == "nothing":
        return "Nothing is left above the noise."
    if entry["left"] == "open":
        return f"Whether anything is left above the noise is undecided. {_reason(entry)}"
    left = entry["unexplained"]
    worst = furthest(left)
    assert worst is not None
    count = "One channel stays" if len(left) == 1 else f"{len(left)} channels stay"
    where = "" if len(left) == 1 else "most "
    return f"{count} above the noise, {where}at {channel(worst['channel'])} ({excess(worst)})."


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


def moves(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    """Whether a quantity changes by more than a tenth of its doubt (of itself where that is not known), or its doubt
    by more than a tenth."""
    numbers = [each[key] for each in (before, after) for key in ("value", "std")]
    if not all(number is not None and math.isfinite(number) for number in numbers):
        return True
    value, std, later, later_std = numbers
    doubt = max(std, later_std)
    return bool(abs(later - value) > CHANGED * (doubt or abs(value)) or abs(later_std - std) > CHANGED * doubt)


def none_of(candidates: int) -> str:
    return f"none of {counted(candidates, 'candidate')}"


def _reason(entry: Mapping[str, Any]) -> str:
    """`Cannot judge: 1.2 of 5 s of steady held-out motion at joint_2.`"""
    reason = str(entry["reason"])
    return f"{reason[:1].upper()}{reason[1:]}."


def counted(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", "\u202f")


def at(found: Mapping[str, Any]) -> str:
    """`Stribeck friction at torso_pitch`, of a finding or an alternative."""
    return at_place(found["effect"], *_place(found["where"]))


def place(found: Mapping[str, Any]) -> str:
    return place_words(*_place(found["where"]))


def _place(where: Mapping[str, str | bool]) -> tuple[str, str, str]:
    """Kind, name and part: `{"sensor": "wrist", "axis": "fx"}`, `{"base": true}`."""
    kind, name = next((kind, name) for kind, name in where.items() if kind != PART)
    return kind, kind if name is True else str(name), str(where.get(PART, ""))


def channel(name: str) -> str:
    """`tau.torso_pitch` -> `torso_pitch`, `ft.wrist.fx` -> `wrist.fx`; others as they are."""
    if name.startswith("support."):
        return f"{name.removeprefix('support.')} (support)"
    return name.removeprefix("tau.").removeprefix("ft.")


def step_words(step: ChainStep) -> str:
    """`identified model`, `+ Stribeck friction at torso_pitch`, `+ own curve of Stribeck friction at torso_pitch`."""
    if step.place is None:
        return FIRST_MODELS[step.what]
    sort = "" if step.what == "effect" else f"{step.what.replace('_', ' ')} of "
    return f"+ {sort}{at_place(step.effect, step.place.kind, step.place.name, step.place.part)}"


def chain_unit(unit: str) -> str:
    """What stands behind a number of the chain: channels of several units are told in multiples of their floors."""
    return "× floor" if unit == FLOORS else unit


def chain_words(unit: str) -> str:
    """What the chain's numbers are. unit: of its links."""
    if unit == FLOORS:
        return "RMSE of the channels in question, each in multiples of its noise floor"
    return "RMSE of the channels in question"


def figure(value: float | None) -> str:
    return significant(math.nan if value is None else value)
