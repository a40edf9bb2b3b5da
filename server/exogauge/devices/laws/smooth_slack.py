"""A spring that comes taut gradually, as cloth does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from exogauge.devices.laws.law import Array, Quantity, WireMotion


@final
class SmoothSlack:
    """T = k δ ln(1 + e^{x/δ}), x = l - l_0: the linear law within k δ ln 2, which it is off by at x = 0."""

    name = "smooth_slack"
    sentence = "The band comes taut gradually, over a transition about its natural length."
    values = (Quantity("transition", "m", "Stretch over which the band comes taut.", 0.005),)
    per_segment = False

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        x, delta = motion.length - natural_length, values["transition"]
        if delta == 0.0:
            return stiffness * np.maximum(x, 0.0)
        with np.errstate(under="ignore"):  # far below its natural length it is slack
            return stiffness * delta * np.logaddexp(0.0, x / delta)


LAW = SmoothSlack()
