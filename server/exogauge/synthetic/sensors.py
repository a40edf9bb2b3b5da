"""From what is to what is logged: quantisation and white noise of every sensor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ENCODER_STEP = 2 * math.pi / (2**17 * 100)  # a 17-bit motor encoder behind a gear of 100 [rad]
COMMAND_STEP = 0.002  # of the current that the controller asks for [A]
# q: the encoder's error (1.4e-7), and how steps of the commanded current and of friction shake the joints faster than
# any plan moves them; root mean square over the joints, the light fingers shake most. The rest is noise of sensors.
NOISE = {"q": 2.6e-7, "i": 0.02, "acc": 0.03, "gyro": 0.003, "force": 0.5, "moment": 0.04}
_STEP = {"i": 0.005, "acc": 0.002, "gyro": 0.0002, "force": 0.05, "moment": 0.002}  # of the converters


def encoder(angle: Array) -> Array:
    """Joint angle as counted [rad]; its error is even over one step: std step / sqrt 12 = 1.4e-7."""
    return np.asarray(np.round(angle / ENCODER_STEP) * ENCODER_STEP)


def noisy(values: Array, kind: str, rng: np.random.Generator) -> Array:
    """White noise of the kind's std, then the converter's steps."""
    return np.asarray(np.round((values + NOISE[kind] * rng.standard_normal(values.shape)) / _STEP[kind]) * _STEP[kind])
