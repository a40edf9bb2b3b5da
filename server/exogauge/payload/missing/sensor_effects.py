"""What a sensor may do besides reading the wrench: another zero, shares of other channels, a delay; and the base."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.judging import CARRYING as USUAL
from exogauge.criteria.judging import Carrying
from exogauge.payload.missing.effect import CHANNELS, UNITS, Effect, Frame
from exogauge.payload.missing.stretch import Stretch

Array = NDArray[np.float64]

TURNED = "turned"


def inclination() -> Effect:
    def columns(frame: Frame, stretch: Stretch, _shape: Sequence[float]) -> Array:
        return frame.tilting(stretch)

    def told(_frame: Frame, _shape: Array, value: Array) -> Array:
        return np.degrees(value)

    return Effect("inclination", "base", (("about_x", "°"), ("about_y", "°")), columns, told)


def zero_of_log(log: str) -> Effect:
    """Another zero throughout a log than in the others."""

    def columns(_frame: Frame, stretch: Stretch, _shape: Sequence[float]) -> Array:
        return _every_channel(np.full(len(stretch.wrench), float(stretch.name == log)))

    return Effect("zero_of_log", log, _of_channels(), columns, _as_they_are, of_log=log)


def zero_step(log: str, time: Array) -> Effect:
    """The zero jumps once in a log. time: (T,) of its samples."""

    steps = 9  # moments of a log at which a step is tried first

    def columns(_frame: Frame, stretch: Stretch, shape: Sequence[float]) -> Array:
        return _every_channel(np.where(stretch.time >= shape[0], 1.0, 0.0) * (stretch.name == log))

    def told(_frame: Frame, shape: Array, value: Array) -> Array:
        return np.concatenate([shape, value])

    moments = tuple((float(each),) for each in np.linspace(time[0], time[-1], steps + 2)[1:-1])
    margin = 0.02 * (time[-1] - time[0])
    parameters = (("at", "s"), *_of_channels())
    return Effect(
        "zero_step",
        log,
        parameters,
        columns,
        told,
        ((float(time[0] + margin), float(time[-1] - margin)),),
        moments,
        log,
        jumps=True,
    )


def zero_between(postures: Stretch) -> Effect:
    """The zero jumps once between two postures; afterwards it is that of all that follows."""
    K, fewest = len(postures.wrench), 2  # postures before and after: one alone is one that something touched

    def columns(_frame: Frame, stretch: Stretch, shape: Sequence[float]) -> Array:
        return _every_channel(np.where((stretch.time < shape[0]) & stretch.still, -1.0, 0.0))

    def told(_frame: Frame, shape: Array, value: Array) -> Array:
        return np.concatenate([np.ceil(shape) + 1.0, value])

    moments = tuple((k - 0.5,) for k in range(fewest, K - fewest + 1))
    bounds = ((fewest - 0.75, K - fewest - 0.25),)
    parameters = (("from", "posture"), *_of_channels())
    return Effect("zero_step", postures.name, parameters, columns, told, bounds, moments, postures.name, jumps=True)


def zero_drift() -> Effect:
    """The zero moves on through a session and settles; where clocks do not say when a log was, evenly through every log
    with motion."""
    fastest = 0.2  # 1/s: what settles within seconds is a step

    def columns(_frame: Frame, stretch: Stretch, shape: Sequence[float]) -> Array:
        if stretch.session is None:
            return _every_channel(np.zeros(len(stretch.wrench)) if stretch.still else stretch.time - stretch.time[0])
        settling = max(shape[0], 1e-9)
        return _every_channel(-np.expm1(-settling * stretch.session) / settling)

    def told(_frame: Frame, shape: Array, value: Array) -> Array:
        return np.concatenate([shape, value])

    starts = tuple((each * fastest,) for each in (0.0, 0.03, 0.1, 0.2, 0.4))
    parameters = (("settling", "1/s"), *_of_channels("/s"))
    return Effect("zero_drift", "sensor", parameters, columns, told, ((0.0, fastest),), starts)


def crosstalk(read: int, of: int, criteria: Carrying = USUAL) -> Effect:
    """A channel reads a share of what another one should; of itself: a wrong gain."""

    def columns(frame: Frame, stretch: Stretch, _shape: Sequence[float]) -> Array:
        out = np.zeros((len(stretch.wrench), 6, 1))
        out[:, read, 0] = stretch.rigid[:, of] @ frame.body
        return out

    name, place = ("gain", CHANNELS[read]) if read == of else ("crosstalk", f"{CHANNELS[read]} of {CHANNELS[of]}")
    unit = {"NN·m": "1/m", "N·mN": "m"}.get(UNITS[read] + UNITS[of], "1")

    def possible(told: Array) -> bool:
        return unit != "1" or such_as_a_sensor_has(float(told[0]), criteria)

    return Effect(name, place, (("share", unit),), columns, _as_they_are, possible=possible)


def turned_axes(criteria: Carrying = USUAL) -> Effect:
    """The wrench is written in axes that stand off those of the frame, by a turn about each of these."""

    def columns(frame: Frame, stretch: Stretch, shape: Sequence[float]) -> Array:
        read = (stretch.rigid @ frame.body).reshape(-1, 2, 3)
        turn = pin.exp3(np.array(shape))
        return np.asarray((read @ turn - read).reshape(-1, 6, 1))

    def told(_frame: Frame, shape: Array, _value: Array) -> Array:
        return np.degrees(shape)

    most = criteria.farthest_turn_rad
    parameters = (("about_x", "°"), ("about_y", "°"), ("about_z", "°"))
    starts = ((0.0, 0.0, 0.0),)
    return Effect(TURNED, "sensor", parameters, columns, told, ((-most, most),) * 3, starts, unit=True)


def such_as_a_sensor_has(share: float, criteria: Carrying = USUAL) -> bool:
    """Of a gain beyond 1, or of what a channel reads of another one of its unit: beyond, a unit or an axis is wrong."""
    return bool(abs(share) < criteria.other_ratio - 1.0)


def delay(criteria: Carrying = USUAL) -> Effect:
    def columns(_frame: Frame, stretch: Stretch, _shape: Sequence[float]) -> Array:
        return np.zeros((len(stretch.wrench), 6, 0))

    def told(_frame: Frame, shape: Array, _value: Array) -> Array:
        return 1e3 * shape

    latest = criteria.latest_s
    starts = tuple((float(each),) for each in np.linspace(-0.8, 0.8, 5) * latest)
    return Effect("delay", "sensor", (("late", "ms"),), columns, told, ((-latest, latest),), starts, retimed=True)


def low_pass(variance: float | None = None) -> Effect:
    """The wrench is smoothed more than the pose. By the cumulants of a filter's response, ln H = -late s + variance
    s² / 2 - ...: what is late is `delay`, and half the variance [ms²] goes with the second derivative of what is read.
    One pole has its delay squared, two alike half of that, a maximally flat filter none."""
    apart = 0.05  # s of a second difference: 2 % less at 1.5 Hz, and no noise of smoothed accelerations to speak of

    def columns(frame: Frame, stretch: Stretch, _shape: Sequence[float]) -> Array:
        read, scale = stretch.rigid @ frame.body, 0.5e-6 * (1.0 if variance is None else variance)
        if stretch.still or len(read) < 3:
            return np.zeros((*read.shape, 1))
        period = (stretch.time[-1] - stretch.time[0]) / (len(read) - 1)
        n = min(max(round(apart / period), 1), (len(read) - 1) // 2)
        middle = np.clip(np.arange(len(read)), n, len(read) - 1 - n)
        bend = (read[middle + n] - 2.0 * read[middle] + read[middle - n]) / (n * period) ** 2
        return np.asarray(scale * bend[:, :, None])

    parameters = (("variance", "ms²"),)
    return Effect("low_pass", "sensor", parameters, columns, _as_they_are, unit=variance is not None)


def of_all_channels(criteria: Carrying = USUAL) -> list[Effect]:
    return [crosstalk(read, of, criteria) for read in range(6) for of in range(6)]


def _every_channel(course: Array) -> Array:
    return np.asarray(course[:, None, None] * np.eye(6))


def _of_channels(per: str = "") -> tuple[tuple[str, str], ...]:
    return tuple((name, unit + per) for name, unit in zip(CHANNELS, UNITS, strict=True))


def _as_they_are(_frame: Frame, _shape: Array, value: Array) -> Array:
    return value
