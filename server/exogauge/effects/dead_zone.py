"""A body between two teeth that give way a little: free flight, landing, ringing and rest, step by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.compiled import compiled

Array = NDArray[np.float64]

FINEST_S = 2.5e-4  # of a step: teeth ring at some tens of hertz
MOST_TURNS = 4  # within one step


def between_teeth(
    pull: Array, back: Array, tooth: Array, damping: Array, drag: Array, step: float
) -> tuple[Array, Array]:
    """s and s̈, (T,) each and means over the time to the next sample, of what follows

    s̈ = pull - back s - drag ṡ - [tooth (s ∓ 1) + damping ṡ where |s| > 1],

    pull, back, tooth [1/s²], damping, drag [1/s]: (T,); step [s] between samples. From rest on the tooth that the first
    pull presses to. Implicit steps, stable however stiff a tooth is.
    """
    if len(pull) < 2:
        return np.where(pull < 0.0, -1.0, 1.0), np.zeros(len(pull))
    parts = max(1, int(np.ceil(step / FINEST_S)))
    s, s_ddot = np.empty(len(pull)), np.empty(len(pull))
    _steps(pull, back, tooth, damping, drag, step / parts, parts, s, s_ddot)
    return s, s_ddot


@compiled
def _steps(
    pull: Array, back: Array, tooth: Array, damping: Array, drag: Array, h: float, parts: int, s: Array, s_ddot: Array
) -> None:
    side = -1.0 if pull[0] < 0.0 else 1.0
    at, v, touching = side + pull[0] / tooth[0], 0.0, True
    last = len(pull) - 1
    for n in range(len(pull)):
        rise = (pull[min(n + 1, last)] - pull[n]) / parts
        place, gained = 0.0, 0.0
        for part in range(parts):
            left = h
            for _ in range(MOST_TURNS):  # a step is parted where it reaches a tooth or leaves it
                k, d = (tooth[n], damping[n] + drag[n]) if touching else (0.0, drag[n])
                over = at - side if touching else 0.0
                force = pull[n] + rise * part - back[n] * at - k * (over + left * v) - d * v
                acc = force / (1.0 + left * d + left * left * (k + max(back[n], 0.0)))
                new = at + left * (v + left * acc)
                if touching:
                    turns, edge = new * side < 1.0, side
                else:
                    edge = 1.0 if new > 0.0 else -1.0
                    turns = new * edge > 1.0
                share = min(max((edge - at) / (new - at), 0.0), 1.0) if turns and new != at else 1.0
                passed = share * left
                v += passed * acc
                at = edge if turns else new
                place += passed * at
                gained += passed * acc
                left -= passed
                if not turns:
                    break
                side, touching = edge, not touching
        s[n], s_ddot[n] = place / (h * parts), gained / (h * parts)
