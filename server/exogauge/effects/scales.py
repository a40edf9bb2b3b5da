"""Shapes are searched in sizes of the axis' own motion; a user reads them in SI."""

from __future__ import annotations

import numpy as np

from exogauge.effects.shaped import AxisSignals, Shape

OWN_SIZES = ("rms velocity", "rms load", "range", "cycles per range")
TURN = 2.0 * np.pi


def in_si(shape: Shape, value: float, signals: AxisSignals) -> tuple[float, str]:
    """Value and unit of a shape on this axis: 0.1 rms velocity -> (0.04, rad/s). Others are as they are."""
    sizes = {
        "rms velocity": (signals.speed_scale, "rad/s"),
        "rms load": (signals.torque_scale, "N·m"),
        "range": (signals.range, "rad"),
        "cycles per range": (TURN / (signals.range or 1.0), "1/rev"),
    }
    size, unit = sizes.get(shape.unit, (1.0, shape.unit))
    return value * size, unit
