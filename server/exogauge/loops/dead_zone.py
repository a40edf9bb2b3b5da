"""The steps of `effects.dead_zone`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]

MOST_TURNS = 4  # within one step


@compiled(
    "f8[:,::1], f8[::1], f8[:,::1], f8[:,::1], f8[:,::1], f8, i8, f8[:,::1], f8[:,::1]",
    "f8[:,:], f8[::1], f8[:,:], f8[:,:], f8[:,:], f8, i8, f8[:,::1], f8[:,::1]",
)
def fly(
    pull: Array, back: Array, tooth: Array, damping: Array, drag: Array, h: float, parts: int, s: Array, s_ddot: Array
) -> None:
    """Fills s and s_ddot (T, L). h: of a step [s], `parts` of them a sample.

    Bodies are the inner loop: the processor works on one while it waits for another. While a body stays where it is,
    in the gap or on its tooth, s̈ = p + q part - α s - β ṡ with what a sample has in common.
    """
    length, bodies = pull.shape
    side, at, v, touching = np.empty(bodies), np.empty(bodies), np.zeros(bodies), np.ones(bodies, dtype=np.bool_)
    p, q, alpha, beta = np.empty(bodies), np.empty(bodies), np.empty(bodies), np.empty(bodies)
    rise, place, gained = np.empty(bodies), np.empty(bodies), np.empty(bodies)
    for b in range(bodies):
        side[b] = -1.0 if pull[0, b] < 0.0 else 1.0
        at[b] = side[b] + pull[0, b] / tooth[0, b]
    for n in range(length):
        for b in range(bodies):
            rise[b] = (pull[min(n + 1, length - 1), b] - pull[n, b]) / parts
            place[b], gained[b] = 0.0, 0.0
            p[b], q[b], alpha[b], beta[b] = _staying(
                pull[n, b], rise[b], back[n], tooth[n, b], damping[n, b], drag[n, b], h, side[b], touching[b]
            )
        for part in range(parts):
            for b in range(bodies):
                acc = p[b] + q[b] * part - alpha[b] * at[b] - beta[b] * v[b]
                new = at[b] + h * (v[b] + h * acc)
                stays = new * side[b] >= 1.0 if touching[b] else abs(new) <= 1.0
                if stays:
                    v[b] += h * acc
                    at[b] = new
                    place[b] += h * new
                    gained[b] += h * acc
                    continue
                at[b], v[b], side[b], touching[b], way, speed = _parted(
                    pull[n, b] + rise[b] * part, back[n], tooth[n, b], damping[n, b], drag[n, b], h,
                    at[b], v[b], side[b], touching[b],
                )  # fmt: skip
                place[b] += way
                gained[b] += speed
                p[b], q[b], alpha[b], beta[b] = _staying(
                    pull[n, b], rise[b], back[n], tooth[n, b], damping[n, b], drag[n, b], h, side[b], touching[b]
                )
        for b in range(bodies):
            s[n, b], s_ddot[n, b] = place[b] / (h * parts), gained[b] / (h * parts)


@compiled()
def _staying(
    pull: float,
    rise: float,
    back: float,
    tooth: float,
    damping: float,
    drag: float,
    h: float,
    side: float,
    touching: bool,
) -> tuple[float, float, float, float]:
    """p, q, α, β of an implicit step."""
    k, d = (tooth, damping + drag) if touching else (0.0, drag)
    divisor = 1.0 + h * d + h * h * (k + max(back, 0.0))
    return (pull + k * side) / divisor, rise / divisor, (back + k) / divisor, (k * h + d) / divisor


@compiled()
def _parted(
    pull: float,
    back: float,
    tooth: float,
    damping: float,
    drag: float,
    left: float,
    at: float,
    v: float,
    side: float,
    touching: bool,
) -> tuple[float, float, float, bool, float, float]:
    """A step that is parted where the body reaches a tooth or leaves it: s, ṡ, side and touch after it, ∫ s and ∫ s̈."""
    place, gained = 0.0, 0.0
    for _ in range(MOST_TURNS):
        k, d, over = (tooth, damping + drag, at - side) if touching else (0.0, drag, 0.0)
        acc = (pull - back * at - k * (over + left * v) - d * v) / (1.0 + left * d + left * left * (k + max(back, 0.0)))
        new = at + left * (v + left * acc)
        edge = side if touching else (1.0 if new > 0.0 else -1.0)
        turns = new * edge < 1.0 if touching else new * edge > 1.0
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
    return at, v, side, touching, place, gained
