"""Friction that is another one from some log on."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.order import present, since_log
from exogauge.effects.shaped import Array, AxisSignals


@final
class FrictionShift:
    """From log `since` on (counted from 0 in the order of the study) τ = - Δτ_c sgn q̇ - Δk_d q̇.

    Grease that was changed, a brake that drags, a cover that was put on between two recordings: the logs before are
    the reference. A change between the fitted logs and all held-out ones is not seen.
    """

    name = "friction_shift"
    words = "friction that changed since the reference log"
    place = "joint"
    sentence = "Coulomb and viscous friction are others from one of the logs on."
    coefficients = (
        Quantity("tau_c_change", "N·m", words="change of Coulomb friction"),
        Quantity("k_d_change", "N·m·s/rad", words="change of viscous friction"),
    )
    shapes = (since_log(),)
    confounds = ("coulomb", "viscous", "thermal_viscous")
    needs = "Logs of the same motion from before and after the change, in the order in which they were recorded."
    coordinate = "velocity"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        after = float(present(self.shapes, shape, signals.number))
        return np.asarray(-after * np.stack([signals.direction, signals.velocity], axis=1))

    def applies(self, signals: AxisSignals) -> bool:
        return bool(np.any(signals.direction != 0.0))


EFFECT = FrictionShift()
