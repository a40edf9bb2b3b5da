"""Doctor's rule on a foot whose sensor stops: what it tells is not what the robot stands on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from exogauge.criteria.examining import Examining
from exogauge.logs.findings import ACC, Expectation, Finding, Severity, joints_move, runs, vector
from exogauge.logs.model import Log
from exogauge.logs.units import STANDARD_GRAVITY

FORCE, MOMENT = ("fx", "fy", "fz"), ("mx", "my", "mz")


def contact_stands(log: Log, expected: Expectation) -> Iterator[Finding]:
    """A foot, or one of its six numbers, repeats one value for long. An error where it stands for a good part of the
    log while joints move."""
    for channel, spans, moving in _stopped(log, expected):
        if _share(log, moving) > expected.criteria.frozen_share:
            yield _told(log, channel, "error", moving, " while joints move")
        elif spans:
            yield _told(log, channel, "warning", spans, "")


def contacts_stopped(log: Log, expected: Expectation) -> dict[str, list[slice]]:
    """Where a foot that spoils the log stands while joints move, by its channels."""
    stopped = ((channel, moving) for channel, _, moving in _stopped(log, expected))
    return {channel: spans for channel, spans in stopped if _share(log, spans) > expected.criteria.frozen_share}


def _stopped(log: Log, expected: Expectation) -> Iterator[tuple[str, list[slice], list[slice]]]:
    """Channel, where it stands for long, and where joints move meanwhile.

    A foot in the air may read exactly nothing, as simulators and drivers with a threshold have it: then the others bear
    the robot.
    """
    sensors, criteria = tuple(expected.contacts), expected.criteria
    if expected.weight_n is None or not all(log.has(*_channels(sensor)) for sensor in sensors):
        return
    acc = vector(log, ACC)
    needs = np.ones(log.samples) if acc is None else np.linalg.norm(acc, axis=1) / STANDARD_GRAVITY
    force = {sensor: log.stack(_channels(sensor, FORCE)) / expected.weight_n for sensor in sensors}

    def in_air(sensor: str, span: slice) -> bool:
        bears = {each: float(np.linalg.norm(force[each][span].mean(axis=0))) for each in sensors}
        misses = float(needs[span].mean()) - sum(bears.values())
        return bears[sensor] < criteria.unloaded and misses < criteria.unloaded

    for sensor in sensors:
        for channel, repeats in _standing(log, sensor, criteria).items():
            spans = [span for span in repeats if not in_air(sensor, span)]
            yield channel, spans, [span for span in spans if joints_move(log, span, criteria)]


def _standing(log: Log, sensor: str, criteria: Examining) -> dict[str, list[slice]]:
    """Of the sensor as a whole, and of each channel that usually changes, where it repeats one value for long."""
    names, fewest = _channels(sensor), max(criteria.clipped_run, criteria.frozen_s * log.rate_hz)
    repeats = np.diff(log.stack(names), axis=0) == 0.0
    whole, found = repeats.all(axis=1), dict[str, list[slice]]()
    for channel, stands in ((f"ft.{sensor}", whole), *zip(names, (repeats & ~whole[:, None]).T, strict=True)):
        long = [(int(a), int(length)) for a, length in zip(*runs(stands), strict=True) if length >= fewest]
        in_long = sum(length for _, length in long)
        alive = np.count_nonzero(~whole) - in_long if channel in names else log.samples
        if alive > 0 and np.count_nonzero(stands) - in_long <= criteria.alive * alive:
            found[channel] = [slice(a, a + length + 1) for a, length in long]
    return found


def _told(log: Log, channel: str, severity: Severity, spans: Sequence[slice], meanwhile: str) -> Finding:
    most_told, share = 3, _share(log, spans)
    where = ", ".join(f"{log.time[each.start]:.4g} to {log.time[each.stop - 1]:.4g} s" for each in spans[:most_told])
    more = f" and {len(spans) - most_told} more times" if len(spans) > most_told else ""
    detail = f"does not change in {100 * share:.2g} % of the log{meanwhile}: t = {where}{more}"
    advice = "its sensor or bus stopped, or something else bears the robot: cut the log there"
    return Finding(severity, channel, "wrench_stands", detail, advice, spans[0].start + 1, share)


def _share(log: Log, spans: Sequence[slice]) -> float:
    return float(sum(each.stop - each.start for each in spans) / log.samples)


def _channels(sensor: str, axes: Sequence[str] = (*FORCE, *MOMENT)) -> list[str]:
    return [f"ft.{sensor}.{axis}" for axis in axes]
