"""A spring that rubs where it is led round: its tension changes from segment to segment against the way it slides."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from exogauge.devices.laws.law import Array, Quantity, WireMotion

SHORTEST = 1e-9  # [m] a segment without length counts as one this long


@final
class ViaFriction:
    """Capstan: T_{j+1} = T_j e^{±μ φ_j} while the band slides over via point j, |ln(T_{j+1} / T_j)| ≤ μ φ_j while not.

    Segment j of length L_j holds n_j of the unstretched band, Σ n_j = l_0, and T_j = k l_0 (L_j / n_j - 1). From one
    sample to the next, what friction cannot hold slides towards the greater tension. At the first sample, and when the
    band has been slack, the tension is the same all along.
    """

    name = "via_friction"
    sentence = "The band rubs at its via points, so that its tension differs along its way."
    values = (Quantity("friction", "1", "Coefficient of friction between the band and its via points.", 0.2),)
    per_segment = True

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        from exogauge.loops.via_friction import slide_along

        if motion.segment_length is None or motion.wrap is None:
            raise ValueError("friction at via points needs segment lengths and wrap angles")
        lengths = np.ascontiguousarray(np.maximum(motion.segment_length, SHORTEST))
        ratios = np.ascontiguousarray(np.exp(values["friction"] * motion.wrap))
        strain = np.zeros_like(lengths)
        slide_along(lengths, ratios, natural_length, strain)
        return stiffness * natural_length * strain


LAW = ViaFriction()
