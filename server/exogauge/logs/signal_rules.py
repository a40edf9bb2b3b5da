"""Doctor's rules on single channels, whatever they measure: missing, dead, frozen, clipped, coarse.

Doctor's rules on the clock: rate, jitter, gaps.

Doctor's rule on what is not in a log: signals that were low-passed before they were stored.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Examining
from exogauge.logs.findings import (
    Expectation,
    Finding,
    Severity,
    first_row,
    joint_channels,
    joints_move,
    kind_of,
    longest_run,
    runs,
    varies,
)
from exogauge.logs.model import Log
from exogauge.logs.noise import ChannelNoise, noise_of, quantisation_step
from exogauge.logs.stored_band import stored_edge

Array = NDArray[np.float64]

SLOWLY_SAMPLED = "slowly_sampled"
DRIVES = ("i", "tau")
SENSED = (*DRIVES, "acc", "gyro", "ft")  # channels that never rest on one value while they work


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
    for channel, span, spoils in _frozen(log, expected):
        at, lasts = log.channels[channel][span.start], (span.stop - 1 - span.start) / log.rate_hz
        detail = f"stands at {at:g} for {lasts:.3g} s from t = {log.time[span.start]:.6g} s"
        advice = "the sensor or its bus stopped for a while: cut the log there"
        severity: Severity = "error" if spoils else "warning"
        yield Finding(severity, channel, "frozen", detail, advice, span.start + 1, float(at))


def sensors_stopped(log: Log, expected: Expectation) -> dict[str, list[slice]]:
    """Where a sensor that spoils the log stands, by its channel."""
    return {channel: [span] for channel, span, spoils in _frozen(log, expected) if spoils}


def _frozen(log: Log, expected: Expectation) -> Iterator[tuple[str, slice, bool]]:
    """Channel, where it stands for longest, and whether that spoils the log.

    So it is where it lasts for a good part of the log: of an IMU of a robot on feet, by which every joint is judged,
    while any joint moves; of a drive while its own moves, unless it is off and coasts.
    """
    of_body = ("acc", "gyro") if expected.contacts else ()
    for channel, values in log.channels.items():
        if kind_of(channel) == "ft" and channel.split(".")[1] in expected.contacts:
            continue  # told by `contact_stands`, which knows a foot in the air
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
            span = slice(start, start + length + 1)
            driven = channel.split(".", 1)[1] if kind_of(channel) in DRIVES and values[start] != 0.0 else None
            long = length > expected.criteria.frozen_share * values.size
            counts = driven is not None or kind_of(channel) in of_body
            yield channel, span, long and counts and joints_move(log, span, expected.criteria, driven)


def held(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Channels that are told more often than they are measured: steps, which no derivative survives."""
    told = dict[tuple[str, int], list[tuple[str, int]]]()
    for channel, values in log.channels.items():
        if kind_of(channel) in (*SENSED, "q") and np.isfinite(values).all():
            changes = np.flatnonzero(np.diff(values))
            if changes.size < expected.criteria.clipped_count:
                continue
            apart = np.diff(changes)
            every = int(np.median(apart))
            if every <= 1 or np.mean(np.abs(apart - every) <= 1) <= 1.0 - expected.criteria.alive:
                continue
            sizes = np.abs(np.diff(values)[changes])
            step = max(quantisation_step(values) or 0.0, float(sizes.min()))  # decimals may hide an encoder's steps
            if float(np.median(sizes)) > expected.criteria.still_steps * step:
                told.setdefault((kind_of(channel), every), []).append((channel, int(changes[0]) + 2))
    for (kind, every), channels in told.items():
        name = channels[0][0] if len(channels) == 1 else f"{kind}.*"
        rate = log.rate_hz / every
        detail = f"holds each value for {every} samples: measured at {rate:.3g} Hz, told at {log.rate_hz:.3g} Hz"
        advice = f"log it as it is measured, or bring the log to that rate: `rate_hz: {rate:.3g}` in a mapping"
        severity: Severity = "error" if kind == "q" else "warning"
        yield Finding(severity, name, "held", detail, advice, channels[0][1], rate)


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


def coarse_or_noisy(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Steps, and noise beyond what is declared: both from one look at every channel that varies."""
    varying = {channel: values for channel, values in log.channels.items() if varies(values)}
    judged = {channel: values for channel, values in varying.items()
              if values.size >= expected.criteria.noise_samples and np.isfinite(values).all()}  # fmt: skip
    found = noise_of(list(judged.values()), log.rate_hz, expected.criteria.noise_above * log.rate_hz)
    noise = dict(zip(judged, found, strict=True))
    for channel, values in varying.items():
        own = noise.get(channel)
        step = quantisation_step(values[np.isfinite(values)]) if own is None else own.step
        if step is not None:
            yield from _coarse(channel, values, step, own, expected.criteria)
    for channel, own in noise.items():
        yield from _noisier_than_declared(channel, own, expected)


def _coarse(
    channel: str, values: Array, step: float, noise: ChannelNoise | None, criteria: Examining
) -> Iterator[Finding]:
    """noise: None where it is not judged; larger than the steps, rounding loses nothing."""
    steps = float(np.nanmax(values) - np.nanmin(values)) / step
    bits = math.log2(max(1.0, steps))
    still = kind_of(channel) in ("q", "dq") and steps < criteria.still_steps
    if still or (noise is not None and noise.std > step) or bits >= criteria.noted_bits:
        return
    detail = f"changes in steps of {step:.3g}: {bits:.1f} effective bits over its range"
    severe = bits < criteria.coarse_bits and kind_of(channel) in (*SENSED, "q")
    advice = "was the column rounded on export? Its rounding is part of the noise" if severe else ""
    yield Finding("warning" if severe else "note", channel, "coarse", detail, advice, value=step)


def _noisier_than_declared(channel: str, noise: ChannelNoise, expected: Expectation) -> Iterator[Finding]:
    kind = kind_of(channel)
    if kind == "ft":
        kind = "force" if channel.rpartition(".")[2].startswith("f") else "moment"
    declared = expected.noise.get(kind)
    if declared and noise.std > expected.criteria.noisy * declared:
        detail = f"its noise is {noise.std:.3g}, {noise.std / declared:.1f} times the declared {declared:.3g}"
        advice = "correct `noise` in robot.yaml, or leave it out to have it estimated; look for interference"
        yield Finding("warning", channel, "noisier_than_declared", detail, advice, value=noise.std)


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


def unusable_clock(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Nothing else can be examined if time does not run."""
    if log.samples < 3:
        yield Finding("error", "t", "too_short", f"the log has {log.samples} samples", "record at least some seconds")
        return
    backwards = ~(np.diff(log.time) > 0.0)
    if backwards.any():
        row = int(np.argmax(backwards)) + 2
        detail = f"time does not increase at {int(backwards.sum())} places, first at {log.time[row - 1]:.6g} s"
        advice = "sort the rows by time and drop repeated ones; a clock that was reset needs two logs"
        yield Finding("error", "t", "time_not_increasing", detail, advice, row, float(log.time[row - 1]))


def rate_differs(log: Log, expected: Expectation) -> Iterator[Finding]:
    if expected.rate_hz is None:
        return
    ratio = log.rate_hz / expected.rate_hz
    if abs(ratio - 1.0) > expected.criteria.rate:
        detail = f"sampled at {log.rate_hz:.4g} Hz, declared {expected.rate_hz:.4g} Hz"
        advice = "is t in seconds? Otherwise correct the declared rate"
        severe = abs(ratio - 1.0) > expected.criteria.rate_wrong
        yield Finding("error" if severe else "warning", "t", "rate_differs", detail, advice, value=log.rate_hz)


def slowly_sampled(log: Log, expected: Expectation) -> Iterator[Finding]:
    if log.rate_hz < expected.criteria.slowest_rate_hz and not any(rate_differs(log, expected)):
        detail = f"sampled at {log.rate_hz:.3g} Hz: how friction turns round with a joint falls between the samples"
        advice = "log at 50 Hz or more; of slower logs weights are to be believed, friction and rotor inertia not"
        yield Finding("warning", "t", SLOWLY_SAMPLED, detail, advice, value=log.rate_hz)


def clock_jitters(log: Log, expected: Expectation) -> Iterator[Finding]:
    periods = np.diff(log.time)
    median = float(np.median(periods))
    whole = periods[periods <= expected.criteria.gap * median]
    low, high = np.quantile(whole, [0.01, 0.99])
    late = np.abs(whole / median - 1.0) > expected.criteria.late
    advice = "positions do not tell whether samples jitter or only their stamps: if only these do, give a rate instead"
    if high - low > expected.criteria.jitter * median:
        detail = f"sample periods vary from {1e3 * low:.3g} to {1e3 * high:.3g} ms (median {1e3 * median:.3g} ms)"
        yield Finding("warning", "t", "clock_jitters", detail, advice, value=float(high - low) / median)
    elif late.any():
        row = (
            int(
                np.argmax(
                    (np.abs(periods / median - 1.0) > expected.criteria.late)
                    & (periods <= expected.criteria.gap * median)
                )
            )
            + 1
        )
        detail = (
            f"{int(late.sum())} sample periods are more than half off the median of {1e3 * median:.3g} ms, "
            f"the longest {1e3 * float(whole.max()):.3g} ms"
        )
        yield Finding("warning", "t", "clock_jitters", detail, advice, row, float(late.mean()))


def clock_has_gaps(log: Log, expected: Expectation) -> Iterator[Finding]:
    periods = np.diff(log.time)
    gaps = periods > expected.criteria.gap * np.median(periods)
    if gaps.any():
        row = int(np.argmax(periods)) + 1
        detail = (
            f"{int(gaps.sum())} gap(s) without samples, the longest {periods[row - 1]:.3g} s "
            f"after t = {log.time[row - 1]:.6g} s"
        )
        advice = "a study cuts the log there: filters and derivatives would reach across a gap"
        yield Finding("warning", "t", "clock_has_gaps", detail, advice, row, float(periods[row - 1]))


def what_was_done(log: Log, expected: Expectation) -> Iterator[Finding]:
    for note in log.notes:
        yield Finding("warning", "t", note.rule, note.detail, note.advice, note.row)


def stored_low_passed(log: Log, expected: Expectation) -> Iterator[Finding]:
    """One finding for all efforts: a recorder filters them alike."""
    edge = stored_edge(log)
    if edge is None:
        return
    kind = max(("tau.*", "i.*"), key=lambda each: len(joint_channels(log, each.partition(".")[0])))
    steep = (
        f"end at about {edge.hz:.2g} Hz: within an octave and a half their spectra fall by {edge.fall_db:.0f} dB, "
        "and no sensor's noise is left above"
    )
    gentle = f"fade with the positions: above {edge.hz:.2g} Hz the sensors' noise falls by {edge.fall_db:.0f} dB in all"
    detail = steep if edge.steep else gentle
    advice = (
        "log the signals as they are sampled. If these were low-passed before they were stored, friction looks soft "
        "where a joint turns round: run the step `discrepancy`, which filters the model alike, before you name anything"
    )
    yield Finding("warning", kind, "stored_low_passed", detail, advice, value=edge.hz)
