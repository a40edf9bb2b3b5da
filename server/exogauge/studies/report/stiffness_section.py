"""The report's section on the bands: Tables 2 and 3 of [Evaluator] with uncertainty, and what stays undecided."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.devices.result import Approach, BandEstimate, Estimate, StiffnessResult
from exogauge.studies.report.doubt_table import DoubtTable, doubt_table
from exogauge.studies.report.support_section import SAID, plus_minus
from exogauge.studies.results.support_results import cross_checks, headline_approach
from exogauge.studies.words.finding_sentences import band_note
from exogauge.studies.words.remark_words import sentence
from exogauge.studies.words.rounding import between, rounded, significant

APPROACHES: tuple[Approach, ...] = ("A", "B", "paired", "prior")
ALIKE = 0.95  # correlation from which two parameters are named as hard to tell apart


@final
@dataclass(frozen=True)
class BandCell:
    """An estimate as shown; error against the truth in per cent, 95 % interval. kept: the data do not decide it."""

    value: str
    error: str
    interval: str
    kept: bool


@final
@dataclass(frozen=True)
class GroupRow:
    """One group of bands: its stiffness by each approach, None where an approach has no answer."""

    group: str
    bands: tuple[str, ...]
    truth: str
    cells: tuple[BandCell | None, ...]


@final
@dataclass(frozen=True)
class LengthRow:
    band: str
    cells: tuple[BandCell | None, ...]


@final
@dataclass(frozen=True)
class CheckRow:
    """Two parts that ought to give one stiffness. difference: with its std, [N/m]; z, limit: of it."""

    group: str
    approach: str
    between: str
    difference: str
    z: str
    agrees: bool


@final
@dataclass(frozen=True)
class DeviceView:
    """doubts: of the stiffness of each group, by one approach. alike: sentences on parameters
    that trade against each other. rest: joint, RMS by approach."""

    device: str
    groups: tuple[GroupRow, ...]
    lengths: tuple[LengthRow, ...]
    alike: tuple[str, ...]
    notes: tuple[str, ...]
    rest: tuple[tuple[str, tuple[str, ...]], ...]
    samples: tuple[str, ...]
    doubts: DoubtTable | None
    checks: tuple[CheckRow, ...]


def device_views(found: Sequence[StiffnessResult]) -> list[DeviceView]:
    return [
        _device_view(device, {each.approach: each for each in found if each.device == device})
        for device in dict.fromkeys(each.device for each in found)
    ]


def _device_view(device: str, by: dict[Approach, StiffnessResult]) -> DeviceView:
    bands = next(iter(by.values())).bands
    groups = []
    for group in dict.fromkeys(band.group for band in bands):
        members = tuple(band.band for band in bands if band.group == group)
        truth = next((band.true_stiffness for band in bands if band.group == group), None)
        cells = tuple(_stiffness_cell(_of(by, approach, members[0])) for approach in APPROACHES)
        groups.append(GroupRow(group, members, "" if truth is None else significant(truth, 4), cells))
    lengths = tuple(
        LengthRow(band.band, tuple(_length_cell(_of(by, approach, band.band)) for approach in APPROACHES))
        for band in bands
    )
    joints = dict.fromkeys(joint for each in by.values() for joint in each.rms)
    doubted = next((a for a in APPROACHES if a in by and a != "prior"), None)
    return DeviceView(
        device,
        tuple(groups),
        lengths,
        _alike(by.get("A") or by.get("B") or next(iter(by.values()))),
        _notes(by),
        tuple(
            (joint, tuple(significant(by[a].rms.get(joint, math.nan)) if a in by else "" for a in APPROACHES))
            for joint in joints
        ),
        tuple(f"{by[a].samples:,}".replace(",", "\u202f") if a in by else "" for a in APPROACHES),
        _doubts(by, doubted, groups) if doubted else None,
        _checks(by),
    )


def _doubts(by: dict[Approach, StiffnessResult], doubted: Approach, groups: Sequence[GroupRow]) -> DoubtTable | None:
    said = f"What the doubt of the stiffness by {SAID[doubted]} is made of"
    bands = {row.group: _of(by, doubted, row.bands[0]) for row in groups}
    return doubt_table(said, {(group, "[N/m]"): band.stiffness.parts for group, band in bands.items() if band})


def _checks(by: dict[Approach, StiffnessResult]) -> tuple[CheckRow, ...]:
    return tuple(
        CheckRow(
            each["group"],
            "" if each["check"] == "approaches" else each["approach"],
            " – ".join(each["between"]),
            plus_minus(Estimate(each["difference"], each["std"], each["unit"])),
            f"{rounded(abs(each['z']), 1)} of {rounded(each['limit'], 1)}",
            each["agrees"],
        )
        for each in cross_checks(list(by.values()))
    )


def _of(by: dict[Approach, StiffnessResult], approach: Approach, band: str) -> BandEstimate | None:
    if approach not in by:
        return None
    return next((each for each in by[approach].bands if each.band == band), None)


def _stiffness_cell(band: BandEstimate | None) -> BandCell | None:
    if band is None:
        return None
    error = "" if band.error_percent is None else f"{_signed(band.error_percent)} %"
    interval = between(*band.stiffness_interval)
    return BandCell(plus_minus(band.stiffness), error, interval, not band.identifiable)


def _length_cell(band: BandEstimate | None) -> BandCell | None:
    """In millimetres."""
    if band is None:
        return None
    length = Estimate(1000 * band.natural_length.value, 1000 * band.natural_length.std, "mm")
    low, high = band.natural_length_interval
    return BandCell(plus_minus(length), "", between(1000 * low, 1000 * high), not band.length_identifiable)


def _signed(value: float) -> str:
    return ("+" if value > 0 else "") + rounded(value, 1)


def _alike(found: StiffnessResult) -> tuple[str, ...]:
    """A sentence per pair of parameters with a large correlation, the largest first."""
    correlation = np.asarray(found.correlation)
    first, second = np.triu_indices(len(found.parameters), 1)
    pairs = [
        (float(correlation[i, k]), found.parameters[i], found.parameters[k])
        for i, k in zip(first, second, strict=True)
        if abs(correlation[i, k]) >= ALIKE
    ]
    pairs.sort(key=lambda pair: -abs(pair[0]))
    return tuple(
        f"{one} and {other} trade against each other (correlation {rounded(value, 2)}): {_why(one, other)}"
        for value, one, other in pairs
    )


def _why(one: str, other: str) -> str:
    kinds = {one.partition("[")[0], other.partition("[")[0]}
    if kinds == {"stiffness", "natural_length"}:
        return "a stiffer, longer band gives nearly the same torques here. Motions that stretch it more separate them."
    if kinds == {"natural_length"}:
        return "these bands pull alike here. A motion that stretches one more than the other separates them."
    return "these groups pull alike here. A motion that stretches one more than the other separates them."


def _notes(by: dict[Approach, StiffnessResult]) -> tuple[str, ...]:
    """What the identification says of bands and of the whole, each sentence once."""
    identified = [each for approach, each in by.items() if approach != "prior"]
    whole = [sentence(note) for each in identified for note in each.notes]
    of_bands = [f"{band.band}: {said}" for each in identified for band in each.bands if (said := band_note(band))]
    return tuple(dict.fromkeys([*whole, *of_bands]))


def headline_band(found: Sequence[StiffnessResult], device: str) -> tuple[Approach, BandEstimate] | None:
    """Of the first decided group whose truth is known, else of the first decided one: by the approach with the
    smallest doubt."""
    decided = [
        (each.approach, band)
        for each in found
        if each.device == device
        for band in each.bands
        if each.approach == headline_approach(found, device, band.group)
    ]
    known = (pair for pair in decided if pair[1].true_stiffness is not None)
    return next(known, next(iter(decided), None))


def stiffness_sentence(found: Sequence[StiffnessResult], device: str) -> str:
    """`Stiffness of band group A 195 ± 3 N/m by approach A (truth 197.8).`; empty where nothing is decided."""
    headline = headline_band(found, device)
    if headline is None:
        return ""
    approach, band = headline
    text = f"Stiffness of band group {band.group} {plus_minus(band.stiffness)} N/m by {SAID[approach]}"
    return f"{text}." if band.true_stiffness is None else f"{text} (truth {significant(band.true_stiffness, 4)})."
