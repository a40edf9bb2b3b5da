"""Shapes are searched in sizes of the axis' own motion; a user reads them in SI."""

from __future__ import annotations

import math

OWN_SIZES = ("rms velocity", "rms torque", "range", "cycles per range")


def in_si(unit: str, speed_scale: float, torque_scale: float, span: float) -> tuple[float, str]:
    """What a value in this unit of a shape is multiplied by on an axis, and the unit it then has.

    speed_scale, torque_scale, span: the axis' rms velocity [rad/s], rms torque [N·m] and range [rad] (`AxisSignals`).
    Other units than `OWN_SIZES` stay as they are.
    """
    sizes = {
        "rms velocity": (speed_scale, "rad/s"),
        "rms torque": (torque_scale, "N·m"),
        "range": (span, "rad"),
        "cycles per range": (2.0 * math.pi / span if span else 0.0, "1/rev"),
    }
    return sizes.get(unit, (1.0, unit))
