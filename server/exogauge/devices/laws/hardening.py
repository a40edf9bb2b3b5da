"""A spring that grows stiffer the further it is stretched."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from exogauge.devices.laws.law import Array, Quantity, WireMotion


@final
class Hardening:
    """T = k x + k_2 x², x = max(l - l_0, 0)."""

    name = "hardening"
    sentence = "The band grows stiffer the further it is stretched."
    values = (Quantity("hardening", "N/m²", "Half of the rise of the stiffness per metre of stretch.", 400.0),)
    per_segment = False

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        x = np.maximum(motion.length - natural_length, 0.0)
        return (stiffness + values["hardening"] * x) * x


LAW = Hardening()
