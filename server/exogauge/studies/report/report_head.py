"""The head of the report: what was found in a few sentences, and the headline numbers as tiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from exogauge.devices.result import Estimate, StiffnessResult
from exogauge.studies.report.figures import label
from exogauge.studies.report.stiffness_section import headline_band, stiffness_sentence
from exogauge.studies.report.support_section import MEASURED, NAMES, SAID, strongest, support_sentence
from exogauge.studies.results.document import Evaluation, Summary
from exogauge.studies.results.support_results import best_approach, devices
from exogauge.studies.words.discrepancy_sentences import verdict_sentence
from exogauge.studies.words.rounding import rounded, significant, with_std
from exogauge.support.result import JointSupport

_KIND_WORDS = {
    "base_moment": "Base moment",
    "trunk_torque": "Trunk torque",
    "joint_torque": "Joint torque",
    "joint_force": "Force of sliding joints",
    "sensor_force": "Sensor force",
    "sensor_moment": "Sensor moment",
}


@final
@dataclass(frozen=True)
class Tile:
    """One headline number: with the maker's values, then as found. what: of what, in small print.

    outline, bar, tick: per cent of the longest: the maker's, the found one, noise floor or truth (None: unknown).
    """

    title: str
    what: str
    prior: str
    found: str
    unit: str
    outline: float
    bar: float
    tick: float | None
    note: str


def kicker(evaluation: Evaluation) -> str:
    """What was evaluated, above the title."""
    worn = worn_devices(evaluation)
    if not worn:
        return f"identification of {evaluation.robot.name}"
    return f"evaluation of {' and '.join(f'“{device}”' for device in worn)} on {evaluation.robot.name}"


def worn_devices(evaluation: Evaluation) -> tuple[str, ...]:
    """All devices that something is said of, the study's own first."""
    supported = devices(evaluation.support) if evaluation.support else ()
    return tuple(dict.fromkeys([*supported, *(each.device for each in evaluation.stiffness)]))


def lead(evaluation: Evaluation, pooled: Sequence[Summary]) -> str:
    """What was identified, from what, and how well it predicts."""
    found = evaluation.identification
    logs = {prediction.log: prediction.held_out for prediction in found.predictions}
    fitted = sum(not held_out for held_out in logs.values())
    joints, links = len(evaluation.robot.joints), len(evaluation.robot.tree.bodies)
    seconds = sum(float(each.time[-1] - each.time[0]) for each in found.predictions if not each.held_out)
    text = (
        f"{_count(joints, 'joint')} and {_count(links, 'moving link')} of {evaluation.robot.name} were identified from "
        f"{_count(fitted, 'log')}: {significant(seconds)} s, {_count(found.samples, 'sample')} kept after filtering. "
    )
    sentences = []
    closer = any(item.kind in ("base_moment", "trunk_torque") for item in pooled)
    for each in (item for item in pooled if item.kind != "joint_torque" or not closer):
        words = "falls" if each.rmse_identified < each.rmse_prior else "rises"
        sentences.append(
            f"the {_KIND_WORDS[each.kind].lower()} error {words} from {significant(each.rmse_prior)} to "
            f"{significant(each.rmse_identified)} {each.unit} RMSE (noise floor {significant(each.noise_floor, 2)})"
        )
    if sentences:
        held_out = pooled[0].held_out
        where = f"On {_count(len(pooled[0].logs), 'held-out log')}" if held_out else "On the fitted logs themselves"
        text += f"{where}, {'; '.join(sentences)}."
        if not held_out:
            text += " No log was held out, so this says how well the model fits, not how well it predicts."
    return text


def leads(evaluation: Evaluation) -> list[str]:
    """The first sentences. What the model lacks comes first, for it bears on all else; that it lacks nothing, last."""
    device, found = device_lead(evaluation), evaluation.discrepancy
    if found is None:
        return device
    gap = [verdict_sentence(found)]
    return device + gap if found.verdict == "none" else gap + device


def device_lead(evaluation: Evaluation) -> list[str]:
    """Of every device: how much it supports where it acts most, and how stiff its bands are."""
    said = []
    for device in worn_devices(evaluation):
        joint = strongest(evaluation.support, device) if evaluation.support else None
        support = support_sentence(joint) if joint else f"{device}."
        stiffness = stiffness_sentence(evaluation.stiffness, device)
        if joint or stiffness:
            said.append(f"{support} {stiffness}".strip())
    return said


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", "\u202f")


def tiles(evaluation: Evaluation, pooled: Sequence[Summary]) -> list[list[Tile]]:
    """Two rows: support and stiffness of every device, where it acts most; the identification."""
    support, worn = evaluation.support, []
    for device in worn_devices(evaluation):
        joint = strongest(support, device) if support else None
        worn += [_support_tile(joint) if joint else None, _stiffness_tile(evaluation.stiffness, device)]
    return [[tile for tile in worn if tile is not None], [_tile(each) for each in pooled]]


def _support_tile(joint: JointSupport) -> Tile | None:
    """RMSE against the band model by the best approach; None where nothing can be compared, or counts as decided."""
    prior, approach = joint.rmse.get("prior", math.nan), best_approach(joint)
    found = joint.rmse.get(approach, math.nan)
    if not (joint.decided and math.isfinite(prior) and math.isfinite(found)):
        return None
    others = [(NAMES[name], joint.rmse.get(name, math.nan)) for name in MEASURED if name != approach]
    beside = "".join(f"{name} {significant(rmse)} {joint.unit} · " for name, rmse in others if math.isfinite(rmse))
    return Tile(
        f"Support · {joint.device}",
        f"RMSE against the band model, by {SAID[approach]}",
        *(significant(prior), significant(found), joint.unit),
        *percent(prior, found, None),
        f"{beside}{joint.motion}, {joint.joint}",
    )


def _stiffness_tile(found: Sequence[StiffnessResult], device: str) -> Tile | None:
    """With the maker's values and by the best approach; None where the data do not decide the stiffness."""
    headline = headline_band(found, device)
    if headline is None:
        return None
    approach, band = headline
    by_prior = (each for each in found if (each.device, each.approach) == (device, "prior"))
    prior = next((each.stiffness for r in by_prior for each in r.bands if each.band == band.band), None)
    truth, note = band.true_stiffness, "no truth known"
    if truth is not None and band.error_percent is not None:
        note = f"truth {significant(truth, 4)} N/m, error {rounded(band.error_percent, 1)} %"
    return Tile(
        f"Stiffness · {device}",
        f"band group {band.group}, by {SAID[approach]}",
        *("–" if prior is None else shown(prior), shown(band.stiffness), "N/m"),
        *percent(math.nan if prior is None else prior.value, band.stiffness.value, truth),
        note,
    )


def _tile(each: Summary) -> Tile:
    names = [label(channel) for channel in each.channels]
    shown = ", ".join(names) if len(names) <= 3 else f"{len(names)} channels"
    return Tile(
        _KIND_WORDS[each.kind],
        f"RMSE, {'held-out' if each.held_out else 'fitted'} logs",
        *(significant(each.rmse_prior), significant(each.rmse_identified), each.unit),
        *percent(each.rmse_prior, each.rmse_identified, each.noise_floor),
        f"noise floor {significant(each.noise_floor, 2)} {each.unit} · {shown}",
    )


def shown(estimate: Estimate) -> str:
    return with_std(estimate.value, estimate.std)[0]


def percent(prior: float, found: float, tick: float | None) -> tuple[float, float, float | None]:
    """Each as a share of the largest."""
    sizes = [size if size is not None and math.isfinite(size) else 0.0 for size in (prior, found, tick)]
    outline, bar, mark = (100 * abs(size) / max(*map(abs, sizes), 1e-300) for size in sizes)
    return outline, bar, None if tick is None else mark
