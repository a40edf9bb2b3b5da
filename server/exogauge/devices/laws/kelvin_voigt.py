"""A spring beside a damper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from exogauge.devices.laws.law import Array, Quantity, WireMotion


@final
class KelvinVoigt:
    """T = max(k x + c l̇, 0) where x = l - l_0 > 0, else 0. A cycle x = x_0 + A sin ωt, always taut, costs π A² c ω."""

    name = "kelvin_voigt"
    sentence = "The band pulls more while it is stretched than while it shortens, in proportion to speed."
    values = (Quantity("damping", "N·s/m", "Added tension per speed of stretching.", 10.0),)
    per_segment = False

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        x = motion.length - natural_length
        return np.where(x > 0.0, np.maximum(stiffness * x + values["damping"] * motion.rate, 0.0), 0.0)


LAW = KelvinVoigt()
