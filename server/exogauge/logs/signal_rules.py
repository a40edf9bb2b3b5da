"""Doctor's rules on single channels, whatever they measure: missing, dead, frozen, clipped, coarse."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Examining
from exogauge.logs.findings import Expectation, Finding, first_row, kind_of, longest_run, runs, varies
from exogauge.logs.model import Log
from exogauge.logs.noise import quantisation_step, white_noise_std

Array = NDArray[np.float64]

SENSED = ("i", "tau", "acc", "gyro", "ft")  # channels that never rest on one value while they work


def not_finite(log: Log, expected: Expectation) -> Iterator[Finding]:
    for channel, values in log.channels.items():
        bad = ~np.isfinite(values)
        if bad.any():
            detail = f"{int(bad.sum())} of {values.size} values are missing, NaN or infinite"
            advice = "short gaps can be interpolated by resampling; otherwise cut the log or leave the channel out"
            yield Finding("error", channel, "not_finite", detail, advice, first_row(bad), float(bad.sum()))


def dead(log: Log, expected: Expectation) -> Iterator[Finding]:
    for channel, values in log.channels.items():
        finite = values[np.isfinite(values)]
        if finite.size == 0 or varies(values):
            continue
        at = float(finite[0])
        if kind_of(channel) in SENSED:
            advice = "is the sensor connected and the column the right one? Leave the channel out otherwise"
            yield Finding("warning", channel, "dead", f"reads {at:g} throughout", advice, value=at)
        elif kind_of(channel) == "q":
            advice = "nothing that needs this joint's motion can be identified from this log"
            yield Finding("note", channel, "does_not_move", f"stays at {at:g} throughout", advice, value=at)


def frozen(log: Log, expected: Expectation) -> Iterator[Finding]:
    """A sensor that repeats one value for long although it usually changes with every sample."""
    for channel, values in log.channels.items():
        repeats = np.diff(values) == 0.0
        start, length = longest_run(repeats)
        if kind_of(channel) not in SENSED or length < max(
            expected.criteria.clipped_run, expected.criteria.frozen_s * log.rate_hz
        ):
            continue
        elsewhere = repeats.sum() - length
        at_extreme = values[start] in (np.nanmin(values), np.nanmax(values))
        if (
            length < values.size - 10
            and elsewhere < expected.criteria.alive * (repeats.size - length)
            and not at_extreme
        ):
            detail = f"stands at {values[start]:g} for {length / log.rate_hz:.3g} s from t = {log.time[start]:.6g} s"
            advice = "the sensor or its bus stopped for a while: cut the log there"
            yield Finding("warning", channel, "frozen", detail, advice, start + 1, float(values[start]))


def saturated(log: Log, expected: Expectation) -> Iterator[Finding]:
    for channel, values in log.channels.items():
        if kind_of(channel) not in SENSED or not np.isfinite(values).all() or not varies(values):
            continue
        for extreme, neighbours in ((values.max(), values.max() - values), (values.min(), values - values.min())):
            if _clipped(values, neighbours, expected.criteria):
                at = neighbours == 0.0
                detail = f"stops at {extreme:g} for {int(at.sum())} samples, as if clipped"
                advice = "a limit of the converter or the controller: those samples say nothing, use a wider range"
                yield Finding("warning", channel, "saturated", detail, advice, first_row(at), float(extreme))


def coarse(log: Log, expected: Expectation) -> Iterator[Finding]:
    for channel, values in log.channels.items():
        step = quantisation_step(values[np.isfinite(values)]) if varies(values) else None
        if step is None:
            continue
        steps = float(np.nanmax(values) - np.nanmin(values)) / step
        bits = math.log2(max(1.0, steps))
        if (kind_of(channel) in ("q", "dq") and steps < expected.criteria.still_steps) or _dithered(
            log, values, step, expected.criteria
        ):
            continue
        if bits < expected.criteria.noted_bits:
            detail = f"changes in steps of {step:.3g}: {bits:.1f} effective bits over its range"
            severe = bits < expected.criteria.coarse_bits and kind_of(channel) in (*SENSED, "q")
            advice = "was the column rounded on export? Its rounding is part of the noise" if severe else ""
            yield Finding("warning" if severe else "note", channel, "coarse", detail, advice, value=step)


def noisier_than_declared(log: Log, expected: Expectation) -> Iterator[Finding]:
    for channel, values in log.channels.items():
        kind = kind_of(channel)
        if kind == "ft":
            kind = "force" if channel.rpartition(".")[2].startswith("f") else "moment"
        declared = expected.noise.get(kind)
        if (
            not declared
            or values.size < expected.criteria.noise_samples
            or not np.isfinite(values).all()
            or not varies(values)
        ):
            continue
        seen = white_noise_std(values, log.rate_hz, expected.criteria.noise_above * log.rate_hz)
        if seen > expected.criteria.noisy * declared:
            detail = f"its noise is {seen:.3g}, {seen / declared:.1f} times the declared {declared:.3g}"
            advice = "correct `noise` in robot.yaml, or leave it out to have it estimated; look for interference"
            yield Finding("warning", channel, "noisier_than_declared", detail, advice, value=seen)


def _dithered(log: Log, values: Array, step: float, criteria: Examining) -> bool:
    """Whether the channel's own noise is larger than its steps, so that rounding loses nothing."""
    if values.size < criteria.noise_samples or not np.isfinite(values).all():
        return False
    return bool(white_noise_std(values, log.rate_hz, criteria.noise_above * log.rate_hz) > step)


def _clipped(values: Array, distance: Array, criteria: Examining) -> bool:
    """distance: (T,) from the extreme, 0 at it."""
    at = distance == 0.0
    count = int(at.sum())
    if count < criteria.clipped_count or count == values.size or longest_run(at)[1] < criteria.clipped_run:
        return False
    nearest = float(distance[~at].min())
    window = max(0.01 * float(np.ptp(values)), 1.5 * nearest)
    if count < 3 * int(np.sum(~at & (distance <= window))):
        return False
    starts, lengths = runs(at)
    starts = starts[(lengths >= criteria.clipped_run) & (starts >= criteria.approach)]
    approach = distance[starts[:, None] - 1 - np.arange(criteria.approach)].mean(
        axis=1
    )  # of a ramp: (criteria.approach + 1) / 2 steps
    usual = float(np.sqrt(np.mean(np.diff(values) ** 2)))
    slow = max(
        criteria.clipped_speed * usual * (criteria.approach + 1) / 2, 1.5 * nearest
    )  # or step by step, as a coarse channel does
    return bool(starts.size and np.median(approach) > slow)
