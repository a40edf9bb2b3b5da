"""A spring beside a second one that lets go with time: creep and relaxation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from exogauge.devices.laws.law import Array, Quantity, WireMotion


@final
class Maxwell:
    """T = max(k x + k_M s, 0) where x = max(l - l_0, 0) > 0, else 0; ṡ = ẋ - s/τ_r.

    s is what the second spring is stretched by; it has let go at the first sample. The step is exact for a length that
    changes evenly between samples: s ← E s + τ_r (1 - E) Δx/h with E = e^{-h/τ_r}; no step is too long.
    A cycle x = x_0 + A sin ωt, always taut, costs π A² k_M ω τ_r / (1 + ω² τ_r²).
    """

    name = "maxwell"
    sentence = "Held at one stretch, the band's pull falls off with time; stretched fast, it is stiffer."
    values = (
        Quantity("branch_stiffness", "N/m", "Stiffness that is added when stretched fast.", 50.0),
        Quantity("relaxation_time", "s", "Time in which the added pull falls to 37 %.", 0.5),
    )
    per_segment = False

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        k_M, tau = values["branch_stiffness"], values["relaxation_time"]
        x = np.maximum(motion.length - natural_length, 0.0)
        pulled: Array = stiffness * x + k_M * branch_stretch(motion.time, x, tau)
        return np.where(x > 0.0, np.maximum(pulled, 0.0), 0.0)


def branch_stretch(time: Array, x: Array, relaxation_time: float) -> Array:
    """(T,) s [m] from 0 on. time: (T,) [s]. x: (T,) [m]."""
    s = np.zeros_like(x)
    if relaxation_time > 0.0 and len(x) > 1:
        steps = np.diff(time) / relaxation_time
        kept, driven = np.exp(-steps), -np.expm1(-steps) / steps * np.diff(x)
        stretch, found = 0.0, []
        for E, rise in zip(kept.tolist(), driven.tolist(), strict=True):
            stretch = E * stretch + rise
            found.append(stretch)
        s[1:] = found
    return s


LAW = Maxwell()
