"""A payload that gives way in its suckers, or a part of it that hangs on springs.

What hangs at p follows the specific force b of its place: with N(s) = s² + 2 z w s + w² it sags by -b / N along the
springs' axes, which turn with the sensor, and spring and damper pass (2 z w s + w²) / N b on instead of b.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.judging import CARRYING as USUAL
from exogauge.criteria.judging import Carrying
from exogauge.payload.missing.effect import Effect, Frame
from exogauge.payload.missing.stretch import Stretch
from exogauge.robots.kinematics import cross

Array = NDArray[np.float64]

FIRST_PLACES = [(x, y, z) for x in (-0.25, 0.25) for y in (-0.25, 0.25) for z in (0.0, 0.3)]


def spring(axes: str, criteria: Carrying = USUAL) -> Effect:
    """The payload, its mass and centre known, gives way along `axes` of the sensor."""

    def columns(frame: Frame, stretch: Stretch, shape: Sequence[float]) -> Array:
        m, c = frame.body[0], frame.body[1:4] / frame.body[0]
        return np.asarray(frame.sign * m * hung(stretch, c, shape, axes)[:, :, None])

    def told(frame: Frame, shape: Array, _value: Array) -> Array:
        return np.array([frame.body[0] * (2 * np.pi * shape[0]) ** 2, shape[0], shape[1]])

    starts = tuple((float(f), z) for f in np.geomspace(1.5, 15.0, 6) for z in (0.1, 0.5))
    parameters = (("stiffness", "N/m"), ("frequency", "Hz"), ("damping_ratio", "1"))
    bounds = (criteria.hangs_hz, criteria.hangs_damped)
    return Effect("spring", axes, parameters, columns, told, bounds, starts, unit=True, swings=True)


def second_body(criteria: Carrying = USUAL) -> Effect:
    """A part that hangs on springs alike in all directions, wherever it is; its own moments of inertia left out."""

    def columns(frame: Frame, stretch: Stretch, shape: Sequence[float]) -> Array:
        return frame.sign * hung(stretch, np.array(shape[:3]), shape[3:], "xyz")[:, :, None]

    def told(_frame: Frame, shape: Array, value: Array) -> Array:
        return np.concatenate([value, shape])

    starts = tuple((*place, float(f), 0.2) for place in FIRST_PLACES for f in np.geomspace(1.5, 12.0, 4))
    parameters = (("mass", "kg"), ("x", "m"), ("y", "m"), ("z", "m"), ("frequency", "Hz"), ("damping_ratio", "1"))
    reach = criteria.hangs_within_m
    bounds = (*((-reach, reach),) * 3, criteria.hangs_hz, criteria.hangs_damped)
    return Effect(
        "second_body", "payload", parameters, columns, told, bounds, starts, swings=True,
        possible=lambda numbers: bool(numbers[0] > 0.0),
    )  # fmt: skip


def hung(stretch: Stretch, p: Array, shape: Sequence[float], axes: str) -> Array:
    """(T, 6) wrench of 1 kg that hangs at p beyond that of 1 kg fixed there, s = +1. shape: frequency [Hz], z."""
    free, turning, omega = np.array([each in axes for each in "xyz"]), stretch.turning, stretch.motion.omega
    b = stretch.proper + turning @ p
    s = _sag(b, stretch, shape, free)
    felt = b + (turning @ s[:, :, None])[:, :, 0]
    if not stretch.still:
        felt += 2.0 * cross(omega, np.gradient(s, stretch.time, axis=0))
    s = _sag(felt, stretch, shape, free)
    f = np.where(free, _passed(felt, stretch, shape), felt)
    return np.hstack([f - b, cross(p + s, f) - cross(p, b)])


def _sag(b: Array, stretch: Stretch, shape: Sequence[float], free: NDArray[np.bool_]) -> Array:
    w = 2 * np.pi * shape[0]
    return np.where(free, -_filtered(b, stretch, shape, (0.0, w**2)) / w**2, 0.0)


def _passed(b: Array, stretch: Stretch, shape: Sequence[float]) -> Array:
    w = 2 * np.pi * shape[0]
    return _filtered(b, stretch, shape, (2 * shape[1] * w, w**2))


def _filtered(values: Array, stretch: Stretch, shape: Sequence[float], over: tuple[float, float]) -> Array:
    """(T, 3) (b s + c) / N of values, b and c those of `over`, by the bilinear transform; from rest at the first.
    Postures are at rest."""
    if stretch.still:
        return values
    frequency, z = shape
    w, k = 2 * np.pi * frequency, 2.0 * (len(stretch.time) - 1) / float(stretch.time[-1] - stretch.time[0])
    (b, c), scale = over, k**2 + 2 * z * w * k + w**2
    a = np.array([1.0, 2.0 * (w**2 - k**2) / scale, (k**2 - 2 * z * w * k + w**2) / scale])
    d = np.array([b * k + c, 2.0 * c, c - b * k]) / scale
    rest = np.array([d[1] - a[1] + d[2] - a[2], d[2] - a[2]])  # it passes what is constant
    return np.asarray(scipy.signal.lfilter(d, a, values, axis=0, zi=rest[:, None] * values[0])[0])
