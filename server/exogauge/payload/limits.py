"""Channels of a wrench that end at a limit: of the sensor's rated range, or of what lies behind it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.errors import BadStudy, Fault
from exogauge.logs.findings import Finding, longest_run
from exogauge.logs.units import UNITS, find_unit, units_of
from exogauge.payload.intake import Payload, Recording

Array = NDArray[np.float64]


def saturation(payload: Payload, criteria: Criteria = USUAL) -> list[str]:
    """A sentence for each channel of each log."""
    return [
        f"{recording.wrench.file}, row {found.row}, column '{found.channel}': {found.detail}. What is "
        f"identified with them is wrong: {found.advice}."
        for recording in payload.recordings
        for found in saturated(payload, recording, criteria)
    ]


def require_bearable(payload: Payload, criteria: Criteria = USUAL) -> None:
    """Raises BadStudy where a sensor would read, for most of a log, far beyond what it is rated for: none does."""
    sensor = payload.file.sensor
    if sensor.range is None:
        return
    for key, stated, dimension, limits, first in (
        ("force_unit", sensor.force_unit, "force", sensor.range.force_n, 0),
        ("moment_unit", sensor.moment_unit, "torque", sensor.range.moment_nm, 3),
    ):
        for each in payload.recordings:
            share = np.abs(each.wrench.values[:, first : first + 3]) / np.array(limits)
            times = float(np.median(share.max(axis=1)))
            if times > criteria.payload.beyond_range:
                detail = f"the wrench is {times:.3g} times what the sensor is rated for, through most of the log"
                advice = units_within(1.0 / times, stated, dimension, f"sensor.{key}") + " Or `sensor.range` is wrong."
                name = payload.file.sensor.wrench[first]
                raise BadStudy(Fault(detail, "beyond_range", advice, each.wrench.file, None, name, stated))


def require_liftable(payload: Payload, mass: float, criteria: Criteria = USUAL) -> None:
    """Raises BadStudy where no arm lifts such a mass [kg]."""
    most, stated = criteria.payload.heaviest_kg, payload.file.sensor.force_unit
    if mass > most:
        detail = f"the mass comes out {mass:.3g} kg, and no arm lifts more than {most:g} kg"
        advice = units_within(most / mass, stated, "force", "sensor.force_unit")
        first = next(iter(payload.recordings)).wrench.file
        raise BadStudy(Fault(detail, "no_such_mass", advice, first, None, payload.file.sensor.wrench[0], stated))


def units_within(share: float, stated: str, dimension: str, key: str) -> str:
    """Which units make a reading no more than a share of what it is by the stated one."""
    known = find_unit(stated)
    names = [] if known is None else [
        f"`{key}: {name}`" for name in units_of((dimension,)) if UNITS[name].factor <= share * known.factor
    ]  # fmt: skip
    return f"Say {' or '.join(names)}; moments may be in another unit, too." if names else f"Check `{key}`."


def saturated(payload: Payload, recording: Recording, criteria: Criteria = USUAL) -> Iterator[Finding]:
    """Beyond the rated range, cut off at a value below it, or one value throughout."""
    rated = payload.file.sensor.range
    limits = np.full(6, np.inf) if rated is None else np.array([*rated.force_n, *rated.moment_nm])
    for name, values, limit in axes(payload, recording, limits):
        over = np.abs(values) >= criteria.payload.full * limit
        if over.any():
            row = int(np.argmax(over)) + 1
            detail = f"{int(over.sum())} samples reach {np.abs(values).max():.4g}, the sensor is rated for {limit:.4g}"
            advice = "move slower or hold the payload nearer to the sensor; these samples are cut off"
            yield Finding("error", name, "saturated", detail, advice, row, float(np.abs(values).max()))
        elif np.ptp(values) == 0.0 and len(values) >= criteria.payload.cut_off_judged:
            detail = f"all {len(values)} samples are {values[0]:.4g}: nothing is read there"
            advice = "check the cable, the driver and the name"
            yield Finding("error", name, "stuck", detail, advice, 1, float(values[0]))
        else:
            yield from cut_off(name, values, criteria)


def cut_off(name: str, values: Array, criteria: Criteria = USUAL) -> Iterator[Finding]:
    """One extreme so often in a row that a channel which repeats itself as this one does elsewhere hardly gives it. A
    channel that stands still elsewhere, as a coarse one at rest, tells nothing."""
    said, same = criteria.payload, np.diff(values) == 0.0
    extremes = (float(values.max()), float(values.min()))
    inside = ~np.isin(values, extremes)
    elsewhere = same[inside[1:] & inside[:-1]]
    if len(elsewhere) < said.cut_off_judged:
        return
    repeats = max(float(each.mean()) for each in np.array_split(elsewhere, len(elsewhere) // said.cut_off_judged))
    if repeats > said.cut_off_alive:
        return
    chance = np.log(said.cut_off_chance / len(values)) / np.log(max(repeats, 1.0 / len(elsewhere)))
    needed = max(said.cut_off_run, 1.0 + chance)
    for extreme in extremes:
        start, length = longest_run(values == extreme)
        if length >= needed:
            count = int(np.sum(values == extreme))
            detail = (
                f"{count} samples are exactly {extreme:.4g}, {length} of them in a row: the channel is cut off there"
            )
            advice = "a limit of the amplifier, the converter or the driver: widen it, or move slower"
            yield Finding("error", name, "saturated", detail, advice, start + 1, extreme)


def axes(payload: Payload, recording: Recording, per_axis: Array) -> Iterator[tuple[str, Array, float]]:
    names = payload.file.sensor.wrench
    yield from zip(names, recording.wrench.values.T, map(float, per_axis), strict=True)
