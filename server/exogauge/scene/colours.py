"""Colours of the 3D view, chosen to be told apart on a light and on a dark ground."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[int, int, int]

BODY, BODY_DARKER = (214, 219, 227), (168, 176, 190)
VIA_POINT: Rgb = (70, 80, 98)
SLACK: Rgb = (128, 128, 128)
UNKNOWN: Rgb = (30, 110, 220)
TORQUE: Rgb = (235, 110, 0)
SUPPORT: Rgb = (0, 150, 90)
FORCE: Rgb = (190, 30, 160)
MARK: Rgb = (220, 20, 40)
GHOST: Rgb = (140, 60, 190)
TENSION = np.array([[25, 70, 220], [0, 150, 190], [30, 150, 50], [220, 140, 0], [220, 25, 15]], dtype=np.float64)


def tension_colour(share: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(…, 3) along the scale of tensions; share: 0 (none) to 1 (the scale's end)."""
    at = np.linspace(0.0, 1.0, len(TENSION))
    channels = [np.interp(share, at, TENSION[:, k]) for k in range(3)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def round_up(value: float) -> float:
    """The next of 1, 2, 2.5, 5 × 10^n: where a scale ends."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(step * power for step in (1.0, 2.0, 2.5, 5.0, 10.0) if step * power >= value * (1 - 1e-9)))


def as_hex(colour: Rgb | NDArray[np.uint8]) -> str:
    return "#" + "".join(f"{int(channel):02x}" for channel in colour)
