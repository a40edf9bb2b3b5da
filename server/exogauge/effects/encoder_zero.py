"""The encoder of a joint was zeroed at another angle than the URDF's."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.places import Array, EncoderSignals
from exogauge.effects.shaped import Shape

MOST = 0.2  # [rad] judgement: 11°, beyond which a robot is seen to stand askew


@final
class EncoderZero:
    """θ_true = θ + δ: all that the joint carries points elsewhere, so every row moves by ∂(Y φ)/∂θ δ.

    Where the links beyond it can turn along with it, first moments take its place: it shows where the next axis is not
    parallel, or bodies are known. Of the first joint of a fixed base it is a turn of the base.
    """

    name = "encoder_zero"
    words = "a wrong zero of the encoder"
    place = "encoder"
    sentence = "The joint stands at another angle than its encoder reads, by a constant."
    coefficients = (Quantity("encoder_offset", "rad", -MOST, MOST, words="angle of the joint beyond what is read"),)
    shapes: tuple[Shape, ...] = ()
    confounds = ("first moments", "motor_offset", "base_tilt", "joint_spring")
    needs = (
        "Slow motion of the joint and of those beyond it, each through its whole range while the others stand apart."
    )
    coordinate = "position"

    def errors(self, signals: EncoderSignals, shape: tuple[float, ...]) -> Array:
        return np.ones((len(signals.time), 1))

    def applies(self, signals: EncoderSignals) -> bool:
        return len(signals.time) > 0 and not signals.first


EFFECT = EncoderZero()
