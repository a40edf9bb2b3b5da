"""All frames, body and points fixed: angles that fit and do not jerk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from exogauge.criteria.motion_fit import MotionFit
from exogauge.motion.fit.body import HumanBody
from exogauge.motion.fit.kinematics import places, pose, slopes
from exogauge.motion.fit.observed import Observed

Array = NDArray[np.float64]


def track(
    body: HumanBody, observed: Observed, q: Array, scale: Array, offset: Array, noise: float, rate: float,
    criteria: MotionFit,
) -> Array:  # fmt: skip
    """(T, K) that minimises Σ |x − p(q)|² / σ² + Σ |q_{t+1} − 2 q_t + q_{t−1}|² / (S Δt³) + stated angles.

    The second is a motion that white acceleration of density S drives; no frame is pulled to the one before.
    q: (T, K) to start from. Of a long motion `at_once` frames at a time, with `beside` of those before and after.
    """
    out, T = np.empty_like(q), len(q)
    for start in range(0, T, criteria.at_once):
        stop = min(start + criteria.at_once, T)
        part = slice(max(start - criteria.beside, 0), stop + criteria.beside)
        some = replace(observed, position=observed.position[part], mean=observed.mean[part],
                       weight=observed.weight[part])  # fmt: skip
        found = _tracked(body, some, q[part], scale, offset, noise, rate, criteria)
        out[start:stop] = found[start - part.start : stop - part.start]
    return out


def _tracked(
    body: HumanBody, observed: Observed, q: Array, scale: Array, offset: Array, noise: float, rate: float,
    criteria: MotionFit,
) -> Array:  # fmt: skip
    """Gauss-Newton; frames are coupled by the second differences alone, so the normal equations are one band of 2 K."""
    T, K = q.shape
    P_q = observed.weight + criteria.angle_sd**-2.0
    smooth = noise**2 * rate**3 / criteria.acceleration
    for _ in range(criteria.track_steps):
        band, g = np.zeros((2 * K + 1, T, K)), np.empty((T, K))
        for start in range(0, T, criteria.chunk):
            part = slice(start, min(T, start + criteria.chunk))
            A, g[part] = _normal(body, observed, part, q[part], scale, offset)
            g[part] += noise**2 * P_q[part] * (observed.mean[part] - q[part])
            for d in range(K):
                band[d, part, : K - d] = np.einsum("tkk->tk", A[:, d:, : K - d])
            band[0, part] += noise**2 * P_q[part]
        if T >= 3:
            second = q[2:] - 2.0 * q[1:-1] + q[:-2]
            for n, share in enumerate((1.0, -2.0, 1.0)):
                g[n : T - 2 + n] -= smooth * share * second
                band[0, n : T - 2 + n] += smooth * share**2
            band[K, 1 : T - 1] -= 2.0 * smooth
            band[K, : T - 2] -= 2.0 * smooth
            band[2 * K, : T - 2] += smooth
        step = solveh_banded(band.reshape(2 * K + 1, T * K), g.ravel(), lower=True, overwrite_ab=True,
                             check_finite=False).reshape(T, K)  # fmt: skip
        longest = float(np.abs(step).max())
        q = q + step * min(1.0, 1.0 / longest) if longest > 0.0 else q
        if longest < criteria.track_settled:
            break
    return q


def _normal(
    body: HumanBody, observed: Observed, part: slice, q: Array, scale: Array, offset: Array
) -> tuple[Array, Array]:
    """JᵀJ (T, K, K) and Jᵀr (T, K)."""
    target = observed.position[part]
    seen = np.isfinite(target)
    at = pose(body, q, scale)
    place = places(at, observed.points, scale, offset)
    J = slopes(body, at, observed.points, place)
    unseen = ~seen.reshape(len(q), -1)
    if unseen.any():
        J[unseen] = 0.0
    r = np.where(seen, target - place, 0.0).reshape(len(q), -1, 1)
    J_t = np.swapaxes(J, 1, 2)
    return J_t @ J, (J_t @ r)[..., 0]
