"""Units that a mapping may name, and their factor to SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from exogauge.logs.channels import Channel

STANDARD_GRAVITY = 9.80665
POUND_FORCE = 0.45359237 * STANDARD_GRAVITY  # [N] by definition: an international pound is so many kilograms
_DEG = math.pi / 180.0


@final
@dataclass(frozen=True)
class Unit:
    """si = value * factor + offset. dimension: what it measures."""

    dimension: str
    factor: float
    offset: float = 0.0


_TABLE: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": _DEG, "rev": 2 * math.pi},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "angular velocity": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": _DEG, "rev/s": 2 * math.pi, "rpm": math.pi / 30.0},
    "velocity": {"m/s": 1.0, "mm/s": 1e-3},
    "angular acceleration": {"rad/s^2": 1.0, "deg/s^2": _DEG},
    "acceleration": {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY},
    "current": {"A": 1.0, "mA": 1e-3},
    "torque": {
        "Nm": 1.0,
        "mNm": 1e-3,
        "Nmm": 1e-3,
        "Ncm": 1e-2,
        "kNm": 1e3,
        "kgfcm": 1e-2 * STANDARD_GRAVITY,
        "kgfm": STANDARD_GRAVITY,
        "lbfin": 0.0254 * POUND_FORCE,
        "lbfft": 0.3048 * POUND_FORCE,
    },
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "kgf": STANDARD_GRAVITY, "lbf": POUND_FORCE},
    "ratio": {"1": 1.0},
}
UNITS: Mapping[str, Unit] = {
    **{name: Unit(dimension, factor) for dimension, row in _TABLE.items() for name, factor in row.items()},
    "degC": Unit("temperature", 1.0),
    "K": Unit("temperature", 1.0, -273.15),
}
_DIMENSIONS: Mapping[str, tuple[str, ...]] = {
    "t": ("time",),
    "q": ("angle", "length"),
    "dq": ("angular velocity", "velocity"),
    "ddq": ("angular acceleration", "acceleration"),
    "i": ("current",),
    "tau": ("torque", "force"),
    "acc": ("acceleration",),
    "gyro": ("angular velocity",),
    "temp": ("temperature",),
}


def find_unit(name: str) -> Unit | None:
    """The unit of that name; `N·m`, `N.m`, `N*m`, `N-m` are `Nm`, `µ` is `u`, `°` is `deg`, `²` is `^2`."""
    plain = name.strip()
    for sign, letters in (("µ", "u"), ("μ", "u"), ("°C", "degC"), ("°", "deg"), ("²", "^2"), ("s2", "s^2")):
        plain = plain.replace(sign, letters)
    for sign in ("·", ".", "*", " ", "⋅", "-"):
        plain = plain.replace(sign, "")
    return UNITS.get(plain)


def dimensions_of(channel: Channel) -> tuple[str, ...]:
    """What a channel may be measured in (either of two for joints, which may be revolute or prismatic)."""
    if channel.kind == "ft":
        return ("force",) if channel.axis[0] == "f" else ("torque",)
    if channel.kind == "base":
        return ("ratio",) if channel.axis[0] == "q" else ("length",)
    return _DIMENSIONS[channel.kind]


def units_of(dimensions: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the units that measure one of the dimensions."""
    return tuple(name for name, unit in UNITS.items() if unit.dimension in dimensions)
