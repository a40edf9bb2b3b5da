"""One clock for everything: logs of several rates, and stamps that jitter, onto even samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadLog, Fault
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log

Array = NDArray[np.float64]

QUATERNION = ("base.qx", "base.qy", "base.qz", "base.qw")


def to_common_clock(
    logs: Sequence[Log], rate_hz: float | None = None, name: str = "", longest_gap_s: float | None = None
) -> Log:
    """The channels of several logs on one even clock, over the time that all of them cover; nothing is extrapolated.

    All clocks must count from the same instant. rate_hz: of the result; None: of the fastest log. Values between
    samples come from a cubic spline; a log faster than the result is low-passed at 0.4 x rate_hz first (zero phase).
    A channel without finite values for longer than longest_gap_s (None: 5 of its own sample periods) is refused.
    """
    if not logs:
        raise ValueError("no logs to bring to a common clock")
    _refuse_twins(logs)
    rate = max(log.rate_hz for log in logs) if rate_hz is None else rate_hz
    covered = np.array([_covered(log, longest_gap_s) for log in logs])
    start, end = float(covered[:, 0].max()), float(covered[:, 1].min())
    if end <= start:
        raise BadLog(_no_overlap(logs, start, end))
    time = start + np.arange(int(np.floor((end - start) * rate * (1.0 + 1e-12) + 1e-9)) + 1) / rate
    time[-1] = min(time[-1], end)
    channels: dict[str, Array] = {}
    for log in logs:
        for channel, values in _untwisted(log).items():
            channels[channel] = _at(time, rate, log.time, values)
    return Log(name or logs[0].name, time, _unit_quaternion(channels))


def uniform(log: Log, rate_hz: float | None = None, longest_gap_s: float | None = None) -> Log:
    """The same log on an even clock; rate_hz None: at its median rate, and returned as it is if already even
    and complete.

    Trusts the stamps: what they say is when the sample was taken, not when it was written down.
    """
    if rate_hz is None and is_even(log.time) and all(np.isfinite(v).all() for v in log.channels.values()):
        return log
    return to_common_clock([log], rate_hz, log.name, longest_gap_s)


def is_even(time: Array) -> bool:
    """Whether time (T,) [s] departs nowhere by more than 2 % of a period from an even clock."""
    if time.size < 3:
        return True
    even = np.linspace(time[0], time[-1], time.size)
    return bool(np.max(np.abs(time - even)) < LOGS.even * (time[-1] - time[0]) / (time.size - 1))


def _covered(log: Log, longest_gap_s: float | None) -> tuple[float, float]:
    """First and last time [s] between which every channel of the log has values, or BadLog where one has too few."""
    limit = LOGS.longest_gap / log.rate_hz if longest_gap_s is None else longest_gap_s
    start, end = float(log.time[0]), float(log.time[-1])
    faults = []
    for channel, values in log.channels.items():
        known = log.time[np.isfinite(values)]
        fence = np.concatenate([log.time[:1], known, log.time[-1:]])
        steps = np.diff(fence)
        widest = int(np.argmax(steps))
        if steps[widest] > limit * (1.0 + 1e-9):
            faults.append(_gap(log, channel, float(fence[widest]), float(steps[widest]), limit))
        elif known.size:
            start, end = max(start, float(known[0])), min(end, float(known[-1]))
    if faults:
        raise BadLog(faults)
    return start, end


def _at(time: Array, rate_hz: float, known_time: Array, known: Array) -> Array:
    """known (T,) at the new time (T',); whatever is not finite counts as not sampled."""
    finite = np.isfinite(known)
    known_time, known = known_time[finite], known[finite]
    # rows that were lost lower the mean rate, not the rate at which the rest was taken
    own_rate = float(1.0 / np.median(np.diff(known_time)))
    if own_rate > 1.05 * rate_hz:
        even = np.linspace(
            known_time[0], known_time[-1], max(2, round((known_time[-1] - known_time[0]) * own_rate) + 1)
        )
        even_rate = (even.size - 1) / float(even[-1] - even[0])
        known = LowPass(LOGS.anti_alias * rate_hz, even_rate).apply(_interpolate(known_time, known, even))
        known_time = even
    return _interpolate(known_time, known, time)


def _interpolate(time: Array, values: Array, wanted: Array) -> Array:
    if time.shape == wanted.shape and bool(np.all(time == wanted)):
        return values.copy()
    degree = 3 if time.size >= 4 else 1
    return np.asarray(scipy.interpolate.make_interp_spline(time, values, k=degree)(wanted))


def _untwisted(log: Log) -> dict[str, Array]:
    """The channels, with q and -q (the same rotation) made continuous."""
    channels = dict(log.channels)
    if log.has(*QUATERNION):
        quaternion = log.stack(QUATERNION)
        flips = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0.0
        sign = np.concatenate([[1.0], np.cumprod(np.where(flips, -1.0, 1.0))])
        channels.update(zip(QUATERNION, (quaternion * sign[:, None]).T, strict=True))
    return channels


def _unit_quaternion(channels: dict[str, Array]) -> dict[str, Array]:
    if all(name in channels for name in QUATERNION):
        length = np.sqrt(sum(channels[name] ** 2 for name in QUATERNION))
        channels.update({name: channels[name] / length for name in QUATERNION})
    return channels


def _gap(log: Log, channel: str, at: float, length: float, limit: float) -> Fault:
    return Fault(
        detail=f"channel {channel!r} has no values for {length:.3g} s from t = {at:.6g} s; "
        f"only {limit:.3g} s may be bridged by interpolation",
        rule="gap",
        advice="cut the log at the gap, or leave the channel out",
        file=log.name,
        row=int(np.searchsorted(log.time, at, side="right")),
        column=channel,
    )


def _refuse_twins(logs: Sequence[Log]) -> None:
    owner: dict[str, str] = {}
    faults = []
    for log in logs:
        for channel in log.channels:
            if channel in owner:
                faults.append(
                    Fault(
                        detail=f"channel {channel!r} is also in {owner[channel]!r}",
                        rule="channel_twice",
                        advice="keep it in one of the logs",
                        file=log.name,
                        column=channel,
                    )
                )
            owner.setdefault(channel, log.name)
    if faults:
        raise BadLog(faults)


def _no_overlap(logs: Sequence[Log], start: float, end: float) -> Fault:
    late = max(logs, key=lambda log: float(log.time[0]))
    return Fault(
        detail=f"log {late.name!r} starts at t = {start:.6g} s, when another has already ended (t = {end:.6g} s)",
        rule="no_common_time",
        advice="the clocks must count from the same instant: shift one of them in the mapping",
        file=late.name,
        column="t",
    )
