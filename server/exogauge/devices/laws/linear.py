"""A spring that pulls and never pushes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from exogauge.devices.laws.law import Array, Quantity, WireMotion


@final
class Linear:
    """T = k (l - l_0) where l ≥ l_0, else 0; f = -T.

    Implements [Evaluator] (25). Differs from print: 0 for l < l_0 (printed l < 0).
    """

    name = "linear"
    sentence = "The band pulls in proportion to its stretch, and is slack below its natural length."
    values: tuple[Quantity, ...] = ()
    per_segment = False

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        return stiffness * np.maximum(motion.length - natural_length, 0.0)


LAW = Linear()
