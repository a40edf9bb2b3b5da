"""The disc or magnet of a joint's encoder sits beside the axis, or askew."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, EncoderSignals
from exogauge.effects.shaped import Shape


@final
class EncoderEccentricity:
    """θ_true = θ + Σ a_n sin nθ + b_n cos nθ, n = 1 (beside the axis) and 2 (askew, or two heads that are unlike).

    What the joint carries stands, turns and gains speed otherwise than is read: beside gravity's part the torque has
    one with the acceleration and one with the square of the speed, which no spring has. The rotor turns along.

    Within less than a quarter of a turn it is a zero and a scale: `applies` says no.
    """

    name = "encoder_eccentricity"
    words = "an eccentric encoder"
    place = "encoder"
    sentence = "The encoder errs once or twice per turn, as a disc does that sits beside the axis or askew."
    most = 0.1  # [rad] judgement: 6°, what a magnet a millimetre beside its chip makes
    coefficients = (
        Quantity("once_sin", "rad", -most, most, words="angle beyond what is read, with the sine of the angle"),
        Quantity("once_cos", "rad", -most, most, words="the same with the cosine"),
        Quantity("twice_sin", "rad", -most, most, words="the same with the sine of twice the angle"),
        Quantity("twice_cos", "rad", -most, most, words="the same with the cosine of twice the angle"),
    )
    shapes: tuple[Shape, ...] = ()
    confounds = ("encoder_zero", "joint_spring", "first moments", "motor_offset")
    needs = "Motion of the joint through a whole turn, or as much as it can, slow and fast, others standing apart."
    coordinate = "position"

    def errors(self, signals: EncoderSignals, shape: tuple[float, ...]) -> Array:
        q = signals.position
        return np.stack([np.sin(q), np.cos(q), np.sin(2.0 * q), np.cos(2.0 * q)], axis=1)

    def applies(self, signals: EncoderSignals) -> bool:
        return len(signals.time) > 0 and float(np.ptp(signals.position)) > 0.5 * np.pi


EFFECT = EncoderEccentricity()
