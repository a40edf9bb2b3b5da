"""Doctor's rules on the clock: rate, jitter, gaps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from exogauge.logs.findings import Expectation, Finding
from exogauge.logs.model import Log


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


def clock_jitters(log: Log, expected: Expectation) -> Iterator[Finding]:
    periods = np.diff(log.time)
    median = float(np.median(periods))
    whole = periods[periods <= expected.criteria.gap * median]
    low, high = np.quantile(whole, [0.01, 0.99])
    late = np.abs(whole / median - 1.0) > expected.criteria.late
    advice = "the log is resampled to an even clock; if only the stamps jitter, give a rate instead of them"
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
