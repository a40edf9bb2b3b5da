"""Findings as they are told: what has one cause is told once, and what closes the widest gap comes first. A curve
whose shape the data do not decide is told as it is drawn, without numbers that nobody could use: its size and shape
may trade against each other so far that each alone is open, while the curve is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from exogauge.criteria.judging import Judging
from exogauge.criteria.planning import Telling
from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import missing_effects
from exogauge.effects.effect import Quantity
from exogauge.effects.order import LOG, SINCE
from exogauge.effects.shaped import common_cause
from exogauge.findings.result import Finding, Place

if TYPE_CHECKING:
    from exogauge.identification.model import AddedEffect

ALL = "all"


def merged(findings: Sequence[Finding], joints: int, telling: Telling) -> tuple[Finding, ...]:
    """Findings of a shared effect on at least half of the joints become one, at the place of the first."""
    result: list[Finding] = []
    for name in dict.fromkeys(each.effect for each in findings):
        same = [each for each in findings if each.effect == name]
        if name in _shared("joint") and len(same) >= max(telling.joints, telling.of_joints * joints):
            result.append(replace(same[0], place=Place("joint", ALL), alike=tuple(each.place for each in same)))
        else:
            result += same
    result = _of_sensors(result, telling)
    ordered = sorted(result, key=lambda each: each.rank)
    return tuple(replace(each, rank=number) for number, each in enumerate(ordered, 1))


def _of_sensors(findings: Sequence[Finding], telling: Telling) -> list[Finding]:
    """The same on most axes of one sensor is one finding, at the place of the first."""
    result = list(findings)
    for name, sensor in dict.fromkeys(
        (each.effect, each.place.name) for each in findings if each.place.kind == "sensor"
    ):
        same = [each for each in result if (each.effect, each.place.name) == (name, sensor)]
        if name in _shared("sensor") and len(same) >= telling.axes:
            alike = tuple(each.place for each in same)
            one = replace(same[0], place=Place("sensor", sensor, ALL), also_possible=(), alike=alike)
            result = [one if each is same[0] else each for each in result if each is same[0] or each not in same]
    return result


def _shared(place: str) -> set[str]:
    """Effects of this place that have one cause where most of its kind have them."""
    return {each.name for each in missing_effects() if each.place == place and common_cause(each)}


OF_THE_LOGS = ("band_limited_log", "contact")  # what was done about the recordings before anything else was sought


def by_importance(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """First what was done about the recordings, then effects by what they take off the held-out error, in noise floors
    of the channel that shows them most. Of a number of the maker that is the error that it alone would make. Steps of
    the chain keep the order of addition."""

    def place(finding: Finding) -> tuple[int, float]:
        if finding.effect in OF_THE_LOGS:
            return 0, float(finding.rank)
        held = finding.held_out
        gone = np.sqrt(max(held.rmse_before**2 - held.rmse_after**2, 0.0)) / max(held.noise_floor, 1e-12)
        return 1, -float(gone) if np.isfinite(gone) else 0.0

    return tuple(replace(each, rank=number) for number, each in enumerate(sorted(findings, key=place), 1))


PLACES = (LOG, SINCE)  # in the order of the logs: no number of a curve


def as_drawn(finding: Finding, added: AddedEffect, judging: Judging) -> Finding:
    """Without the shapes whose std exceeds their value or at which the search's range ends, and without coefficients
    that may as well be zero beside them.

    A shape that may be negative, such as the angle at which a spring rests, is a place: zero is as good as any other.
    """
    edge = 1e-3  # of a range: as near as a search within it comes to its end
    told = [
        (one, value)
        for one, value in zip(added.effect.shapes, added.shape, strict=True)
        if not one.choice and one.low >= 0.0 and one.name not in PLACES and one.name in finding.parameters
    ]
    own: Sequence[Quantity] = added.effect.coefficients
    sizes = [one.name for one in own if one.name in finding.parameters]
    ended = [one.name for one, value in told if not edge < one.share(value) < 1.0 - edge]
    open_shapes = [one.name for one, _ in told if one.name in ended or _std_over_value(finding, one.name) > 1.0]
    open_sizes = [name for name in sizes if judging.significant * _std_over_value(finding, name) > 1.0]
    if not open_shapes and not (told and sizes and open_sizes == sizes):
        return finding
    dropped = (*open_sizes, *open_shapes)
    kept = {name: each for name, each in finding.parameters.items() if name not in dropped}
    return replace(finding, parameters=kept, as_drawn=dropped)


def _std_over_value(finding: Finding, name: str) -> float:
    found: Estimate = finding.parameters[name]
    return float(found.std / max(abs(found.value), 1e-300))
