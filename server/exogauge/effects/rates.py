"""Rates of change of what a shaped effect sees, zero where a log is too short to have any."""

from __future__ import annotations

from exogauge.effects.shaped import Array
from exogauge.logs.derivatives import differentiate, differentiate_twice


def rate_of_change(values: Array, time: Array) -> Array:
    """(T,) d/dt of values (T,), evenly sampled at time (T,) [s]."""
    return differentiate(values, _rate_hz(time)) if len(time) > 2 else 0.0 * values


def second_rate_of_change(values: Array, time: Array) -> Array:
    """(T,) d²/dt² of values (T,), evenly sampled at time (T,) [s]."""
    return differentiate_twice(values, _rate_hz(time)) if len(time) > 2 else 0.0 * values


def _rate_hz(time: Array) -> float:
    return (len(time) - 1) / float(time[-1] - time[0])
