"""Doctor's rules on joints: units of position, velocity and current against the limits, and dq against d(q)/dt."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.examining import Examining
from exogauge.criteria.logs import LOGS
from exogauge.logs.bandwidth import suggest_cutoff
from exogauge.logs.derivatives import derivative_noise_gain, differentiate
from exogauge.logs.filtering import LowPass
from exogauge.logs.findings import Expectation, Finding, JointLimits, Severity, first_row, joint_channels, varies
from exogauge.logs.model import Log
from exogauge.logs.noise import white_noise_std
from exogauge.logs.resampling import is_even

Array = NDArray[np.float64]


def joint_missing(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Every joint needs its position, and its current or torque where the robot's description says there is one."""
    effort = {"current": ("i",), "torque": ("tau",), "none": ()}
    for joint, actuation in expected.actuation.items():
        for channel in (f"{kind}.{joint}" for kind in ("q", *effort[actuation])):
            if channel not in log.channels:
                advice = "map the column that holds it, or correct the joint's name or actuation in robot.yaml"
                yield Finding("warning", channel, "joint_missing", "is expected but not in the log", advice)


def counts(log: Log, expected: Expectation) -> Iterator[Finding]:
    """A position that is never between whole numbers is told in counts: no joint stops at each radian."""
    for joint, values in joint_channels(log, "q").items():
        if not _whole(values, expected.criteria):
            continue
        low, high = np.nanmin(values), np.nanmax(values)
        detail = f"takes whole numbers alone, from {low:.5g} to {high:.5g}: counts of an encoder?"
        advice = (
            "state in a mapping what one count is, `scale`: 2 pi by the counts of a turn, and by the gear's ratio "
            "where the encoder sits at the motor"
        )
        yield Finding("error", f"q.{joint}", "counts", detail, advice, value=float(high - low))


def _whole(values: Array, criteria: Examining) -> bool:
    known = values[np.isfinite(values)]
    return bool(np.all(known == np.round(known))) and len(np.unique(known)) >= criteria.whole_numbers


def beyond_limits(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Positions beyond the joint's limits; or 57 times, or the gear, too large: then degrees, or the motor's."""
    for joint, values in joint_channels(log, "q").items():
        limits = expected.joints.get(joint)
        if limits is None or not np.isfinite(values).any() or _whole(values, expected.criteria):
            continue
        span = limits.upper - limits.lower
        margin = 0.02 * span + 0.01 if np.isfinite(span) else 0.05
        outside = (values < limits.lower - margin) | (values > limits.upper + margin)
        if not outside.any():
            continue
        row = first_row(outside)
        worst = float(np.nanmax(np.maximum(limits.lower - values, values - limits.upper)))
        otherwise = {
            "degrees": np.radians(values) if limits.turns else values,
            "motor_side": values / max(limits.gear, 1.0),
        }
        least = {"degrees": expected.criteria.far_beyond * span, "motor_side": span}  # who is 57 times off is far off
        fits = [
            rule
            for rule, each in otherwise.items()
            if np.nanmin(each) >= limits.lower - margin and np.nanmax(each) <= limits.upper + margin
            and worst > least[rule] and varies(values)
        ]  # fmt: skip
        if fits and np.isfinite(span):
            read = {"degrees": "degrees", "motor_side": f"the motor's side of a gear of {limits.gear:g}"}
            say = {"degrees": "declare the unit as deg", "motor_side": "say `side: motor`"}
            words = " or ".join(read[rule] for rule in fits)
            detail = f"goes {worst:.3g} rad beyond the joint's limits, but read as {words} it stays within"
            advice = f"{', or '.join(say[rule] for rule in fits)} in the mapping"
            advice += ": the limits do not tell which" if len(fits) > 1 else ""
            if limits.gear == 1.0:
                advice += "; is it the motor's angle, state `gear_ratio` in robot.yaml and `side: motor`"
            yield Finding("error", f"q.{joint}", fits[0], detail, advice, row, float(values[row - 1]))
        else:
            detail = f"goes {worst:.3g} beyond its limits [{limits.lower:.3g}, {limits.upper:.3g}]"
            advice = "check unit, sign and zero of the joint, or the limits of the URDF"
            yield Finding("warning", f"q.{joint}", "beyond_limits", detail, advice, row, float(values[row - 1]))


def jumps(log: Log, expected: Expectation) -> Iterator[Finding]:
    """A step or a spike: far faster than the joint can be, and than it moves right before and after."""
    criteria = expected.criteria
    for joint, values in joint_channels(log, "q").items():
        limits = expected.joints.get(joint, JointLimits())
        rows = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1])  # one value may be told for several samples
        if rows.size <= 2 * criteria.around or not np.isfinite(values).all():
            continue
        step, since = np.abs(np.diff(values[rows])), np.diff(log.time[rows])
        speed = step / np.minimum(since, 2.0 * np.median(since))
        known = 0.0 < limits.velocity < np.inf
        fastest = limits.velocity if known else float(np.quantile(speed, 0.99))
        warned, wrong = criteria.jump_speed
        usual = scipy.ndimage.median_filter(step, 2 * criteria.around + 1, mode="nearest")
        jumps = (step > criteria.jump * usual) & (speed > warned * fastest)
        turns = step[jumps] / (2.0 * np.pi)
        if not jumps.any() or np.mean(jumps) > criteria.jumps or (limits.turns and np.all(np.abs(turns % 1.0) > 0.9)):
            continue
        worst = int(np.argmax(np.where(jumps, speed, 0.0)))
        row = int(rows[worst + 1]) + 1
        times = "once, " if jumps.sum() == 1 else f"{jumps.sum()} times, most "
        can = "as fast as the joint can be" if known else "its top speed otherwise"
        ratio = float(speed[worst] / fastest)
        detail = f"jumps {times}from {values[row - 2]:.4g} to {values[row - 1]:.4g}: {ratio:.2g} times {can}"
        advice = "a wrong sample, or lost counts: repair these samples, or cut the log there (`rows`)"
        severity: Severity = "error" if ratio > wrong else "warning"
        yield Finding(severity, f"q.{joint}", "position_jumps", detail, advice, row, float(values[row - 1]))


def beyond_speed(log: Log, expected: Expectation) -> Iterator[Finding]:
    for joint, values in joint_channels(log, "dq").items():
        limits = expected.joints.get(joint)
        if limits is None or limits.velocity <= 0.0:
            continue
        outside = np.abs(values) > 1.5 * limits.velocity
        if np.mean(outside) > 0.01:
            worst = float(np.nanmax(np.abs(values)))
            detail = f"reaches {worst:.3g}, the limit is {limits.velocity:.3g}"
            advice = "is it in rad/s, and on the joint's side of the gear?"
            yield Finding("warning", f"dq.{joint}", "beyond_speed", detail, advice, first_row(outside), worst)


def current_in_milliamperes(log: Log, expected: Expectation) -> Iterator[Finding]:
    for joint, values in joint_channels(log, "i").items():
        largest = float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))
        if largest > expected.criteria.most_amperes:
            advice = "declare the unit as mA in the mapping, if that is what the driver logs"
            detail = f"reaches {largest:.4g} A"
            yield Finding("warning", f"i.{joint}", "current_in_milliamperes", detail, advice, value=largest)


def velocity_is_another(log: Log, expected: Expectation) -> Iterator[Finding]:
    """A logged velocity that is not the derivative of the logged position: unlike it, scaled, late, or filtered."""
    velocities = joint_channels(log, "dq")
    for joint, position in joint_channels(log, "q").items():
        if joint in velocities and varies(position) and varies(velocities[joint]):
            likeness = _likeness(log.time, position, velocities[joint], expected.criteria)
            if likeness is not None:
                yield from _judge(f"dq.{joint}", likeness, log.rate_hz, expected.criteria)


@final
@dataclass(frozen=True)
class Likeness:
    """correlation: at the best lag. lag: [samples], positive: dq is late. gain: dq per d(q)/dt.

    treble: gain of the upper half of the motion's band over that of the lower; None where there is no motion, or
    where the clock jitters, which makes the derivative itself noisy.
    """

    correlation: float
    lag: float
    gain: float
    treble: float | None


def _judge(channel: str, like: Likeness, rate_hz: float, criteria: Examining) -> Iterator[Finding]:
    use_position = "leave it out: velocities are then taken from the position"
    if abs(like.correlation) < criteria.unlike:
        detail = f"correlates only {like.correlation:.2f} with the derivative of the position"
        yield Finding("warning", channel, "velocity_unlike", detail, use_position, value=like.correlation)
    elif abs(like.gain - 1.0) > criteria.scale and (like.treble is None or like.treble > criteria.attenuation):
        detail = f"is {like.gain:.3g} times the derivative of the position"
        degrees = abs(like.gain * np.pi / 180.0 - 1.0) < criteria.scale
        advice = "declare the unit as deg/s in the mapping" if degrees else "check its unit, sign and side of the gear"
        severe = not 0.5 < like.gain < 2.0
        yield Finding("error" if severe else "warning", channel, "velocity_scaled", detail, advice, value=like.gain)
    elif abs(like.lag) > criteria.lag_samples:
        late = "late" if like.lag > 0.0 else "early"
        detail = f"is {1e3 * abs(like.lag) / rate_hz:.3g} ms ({abs(like.lag):.1f} samples) {late} against the position"
        yield Finding(
            "warning", channel, "velocity_lags", detail, f"a filtered velocity; {use_position}", None, like.lag
        )
    elif like.treble is not None and like.treble < criteria.attenuation:
        detail = f"has only {100 * like.treble:.0f} % of the derivative's amplitude where the motion is fast"
        advice = f"low-passed before it was logged; {use_position}"
        yield Finding("warning", channel, "velocity_filtered", detail, advice, value=like.treble)
    elif abs(like.lag) > criteria.noted_lag:
        detail = f"is {abs(like.lag):.1f} samples {'late' if like.lag > 0 else 'early'} against the position"
        yield Finding("note", channel, "velocity_lags_a_little", detail, "as one-sided differences do", None, like.lag)


def _likeness(time: Array, position: Array, velocity: Array, criteria: Examining) -> Likeness | None:
    """None where the joint moves too little, or the log is too short, to tell."""
    q, dq, rate = _evenly(time, position, velocity)
    if q.size < 64:
        return None
    cutoff = suggest_cutoff(q[:, None], rate)
    low_pass = LowPass(cutoff, rate)
    inner = slice(low_pass.settle_samples // 2, -(low_pass.settle_samples // 2) or None)
    derived, logged = low_pass.apply(differentiate(q, rate))[inner], low_pass.apply(dq)[inner]
    noise = white_noise_std(q, rate, LOGS.fastest * rate) * derivative_noise_gain(low_pass, 1)
    if derived.size < 64 or np.std(derived) < criteria.moves * noise or not varies(logged):
        return None
    derived, logged = derived - derived.mean(), logged - logged.mean()
    correlation, lag = _lag(derived, logged, round(criteria.longest_lag_s * rate), criteria.unlike)
    treble = _treble(derived, logged, criteria.moves * noise, LowPass(0.5 * cutoff, rate)) if is_even(time) else None
    gain = float(np.sign(correlation) * np.std(logged) / np.std(derived))
    return Likeness(correlation, lag, gain, treble)


def _evenly(time: Array, *signals: Array) -> tuple[Array, Array, float]:
    """The two signals on an even clock, holes and jitter bridged by straight lines: good enough for a diagnosis."""
    rate = float(1.0 / np.median(np.diff(time)))
    even = time if is_even(time) else np.arange(time[0], time[-1], 1.0 / rate)
    bridged = [np.interp(even, time[np.isfinite(s)], s[np.isfinite(s)]) for s in signals]
    return bridged[0], bridged[1], rate


def _lag(reference: Array, signal: Array, longest: int, unlike: float) -> tuple[float, float]:
    """Correlation at the best lag, and that lag in samples (positive: signal is late), to a fraction of one."""
    lags = scipy.signal.correlation_lags(signal.size, reference.size)
    near = np.abs(lags) <= longest
    scale = float(np.linalg.norm(reference) * np.linalg.norm(signal))
    correlation, lags = (scipy.signal.correlate(signal, reference, method="fft") / scale)[near], lags[near]
    at_zero = float(correlation[lags == 0][0])
    best = int(np.argmax(-correlation if at_zero < -unlike else correlation))
    shift = 0.0
    if 0 < best < correlation.size - 1:
        before, peak, after = correlation[best - 1 : best + 2]
        bend = before - 2.0 * peak + after
        shift = 0.5 * float(before - after) / float(bend) if bend != 0.0 else 0.0
    return float(correlation[best]), float(lags[best]) + shift


def _treble(derived: Array, logged: Array, least: float, low_pass: LowPass) -> float | None:
    bass_derived, bass_logged = low_pass.apply(derived), low_pass.apply(logged)
    treble_derived, treble_logged = derived - bass_derived, logged - bass_logged
    if np.std(treble_derived) < least:
        return None
    bass = float(np.std(bass_logged) / np.std(bass_derived))
    return float(np.std(treble_logged) / np.std(treble_derived)) / bass
