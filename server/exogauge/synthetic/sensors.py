"""From what is to what is logged: quantisation and white noise of every sensor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ENCODER_STEP = 2 * math.pi / (4096 * 4 * 100)  # a 4096-line motor encoder, four edges, behind a gear of 100 [rad]
CURRENT_STEP = 0.01  # [A]
NOISE = {"q": 1.2e-6, "i": 0.03, "acc": 0.04, "gyro": 0.004, "force": 0.7, "moment": 0.05}
_STEP = {"i": CURRENT_STEP, "acc": 0.002, "gyro": 0.0002, "force": 0.05, "moment": 0.002}  # of the converters


def encoder(angle: Array) -> Array:
    """Joint angle as counted [rad]; its error is even over one step: std step / sqrt 12 = 1.1e-6."""
    return np.asarray(np.round(angle / ENCODER_STEP) * ENCODER_STEP)


def noisy(values: Array, kind: str, rng: np.random.Generator) -> Array:
    """White noise of the kind's std, then the converter's steps."""
    return np.asarray(np.round((values + NOISE[kind] * rng.standard_normal(values.shape)) / _STEP[kind]) * _STEP[kind])
