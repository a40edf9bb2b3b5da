"""A body between two teeth that give way a little: free flight, landing, ringing and rest, step by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FINEST_S = 2.5e-4  # of a step: teeth ring at some tens of hertz


def between_teeth(
    pull: Array, back: Array, tooth: Array, damping: Array, drag: Array, step: float
) -> tuple[Array, Array]:
    """s and s̈, (T, L) each and means over the time to the next sample, of what follows

    s̈ = pull - back s - drag ṡ - [tooth (s ∓ 1) + damping ṡ where |s| > 1],

    pull, tooth [1/s²], damping, drag [1/s]: (T, L), L bodies that know nothing of each other, side by side; back
    [1/s²]: (T,); step [s] between samples. From rest on the tooth that the first pull presses to. Implicit steps,
    stable however stiff a tooth is.
    """
    from exogauge.loops.dead_zone import fly

    if len(pull) < 2:
        return np.where(pull < 0.0, -1.0, 1.0), np.zeros(pull.shape)
    parts = max(1, int(np.ceil(step / FINEST_S)))
    s, s_ddot = np.empty(pull.shape), np.empty(pull.shape)
    fly(pull, back, tooth, damping, drag, step / parts, parts, s, s_ddot)
    return s, s_ddot
