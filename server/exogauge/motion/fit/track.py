"""All frames, body and points fixed: angles that fit and do not jerk."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from exogauge.criteria.motion_fit import MotionFit
from exogauge.motion.fit.body import HumanBody
from exogauge.motion.fit.kinematics import beyond, normal, places, pose
from exogauge.motion.fit.observed import Observed, at_frames

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
BoolArray = NDArray[np.bool_]


def track(
    body: HumanBody, observed: Observed, q: Array, scale: Array, offset: Array, noise: float, rate: float,
    criteria: MotionFit,
) -> tuple[Array, BoolArray]:  # fmt: skip
    """(T, K) that minimises Σ |x − p(q)|² / σ² + Σ |q_{t+1} − 2 q_t + q_{t−1}|² / (S Δt³) + stated angles.

    The second is a motion that white acceleration of density S drives; no frame is pulled to the one before.
    q: (T, K) to start from: of a capture at many frames a second, some of them are tracked first, and the rest begins
    between those. Of a long motion `at_once` frames at a time, with `beside` of those before and after. And (T,) which
    frames have not settled.
    """
    out, T = np.empty_like(q), len(q)
    moving = np.zeros(T, dtype=bool)
    few = int(np.ceil(T * criteria.first_hz / rate)) + 1
    if few > 3 and 2 * few < T:
        at = np.linspace(0.0, T - 1.0, few).round().astype(np.intp)
        first, _ = track(
            body, at_frames(observed, at), q[at], scale, offset, noise, rate * (few - 1) / (T - 1), criteria
        )
        q = CubicSpline(at, first)(np.arange(T))
    for start in range(0, T, criteria.at_once):
        stop = min(start + criteria.at_once, T)
        part = slice(max(start - criteria.beside, 0), stop + criteria.beside)
        found, going = _tracked(body, at_frames(observed, part), q[part], scale, offset, noise, rate, criteria)
        own = slice(start - part.start, stop - part.start)
        out[start:stop], moving[start:stop] = found[own], going[own]
    return out, moving


def _tracked(
    body: HumanBody, observed: Observed, q: Array, scale: Array, offset: Array, noise: float, rate: float,
    criteria: MotionFit,
) -> tuple[Array, BoolArray]:  # fmt: skip
    """Gauss-Newton; frames are coupled by the second differences alone, so the normal equations are one band of 2 K.

    Each frame has its own damping (Levenberg 1944, Marquardt 1963), by what it gained of what was predicted (Madsen,
    Nielsen & Tingleff 2004, 3.2): an arm that hangs straight says little of how it is turned, and swung to and fro, the
    trunk with it. Frames that have settled are left alone, so are those beside which nothing moves any more.
    """
    smooth = noise**2 * rate**3 / criteria.acceleration
    prior = noise**2 * (observed.weight + criteria.angle_sd**-2.0)
    allowed = criteria.track_settled * noise**2
    beside = 2 * int(np.ceil(criteria.felt_s * rate)) + 1
    T, K = q.shape

    def judged(q: Array, at: Indices) -> tuple[Array, Array, Array]:
        """Of frames `at`: cost (n,), second derivatives (K, n, K) in lower band form, descent (n, K), all halved and
        times σ²; what couples the frames aside."""
        cost, band, slope = np.empty(len(at)), np.zeros((K, len(at), K)), np.empty((len(at), K))
        for start in range(0, len(at), criteria.chunk):
            part, own = slice(start, start + criteria.chunk), at[start : start + criteria.chunk]
            off = observed.mean[own] - q[own]
            cost[part], A, down = _normal(body, observed, own, q[own], scale, offset)
            out, stiff = (noise**2 * each for each in beyond(body, q[own], criteria.reach_sd))
            cost[part] += np.sum(prior[own] * off**2 + (out * criteria.reach_sd / noise) ** 2, axis=1)
            slope[part] = down + prior[own] * off - out
            for d in range(K):
                band[d, part, : K - d] = np.einsum("tkk->tk", A[:, d:, : K - d])
            band[0, part] += prior[own] + stiff
        return cost, band, slope

    q, going, damping = q.copy(), np.arange(T), np.full(T, criteria.damping)
    cost, band, slope = judged(q, going)
    for _ in range(criteria.track_steps):
        bends, pulled, stiff = _coupled(q, smooth)
        down = slope + pulled
        matrix = np.zeros((2 * K + 1, len(going), K))
        matrix[:K] = band[:, going]
        matrix[0] = (matrix[0] + stiff[going, None]) * (1.0 + damping[going, None])
        _join(matrix, going, T, smooth)
        step = solveh_banded(matrix.reshape(2 * K + 1, -1), down[going].ravel(), lower=True, overwrite_ab=True,
                             check_finite=False).reshape(-1, K)  # fmt: skip
        tried, promised, gain = q.copy(), np.zeros(T), np.zeros(T)
        tried[going] += np.clip(step, -1.0, 1.0)
        cost_then, band_then, slope_then = judged(tried, going)
        promised[going] = np.sum(down[going] * step, axis=1)
        gain[going] = cost[going] - cost_then
        gain += bends - _coupled(tried, smooth)[0]
        near_gain, near_promised = (uniform_filter1d(each, 5, mode="constant") for each in (gain, promised))
        factor = np.where(near_gain < 0.25 * near_promised, 4.0, np.where(near_gain > 0.75 * near_promised, 0.1, 1.0))
        damping = np.clip(damping * factor, 1e-9, 1e3)
        parts = np.split(np.arange(len(going)), np.flatnonzero(np.diff(going) > 2) + 1)
        kept = np.concatenate([part for part in parts if gain[going[part]].sum() >= 0.0] or [np.arange(0)])
        now = going[kept]
        q[now], cost[now], band[:, now], slope[now] = tried[now], cost_then[kept], band_then[:, kept], slope_then[kept]
        unsettled = promised > allowed
        unsettled[going] |= ~np.isin(going, now)
        going = np.flatnonzero(maximum_filter1d(unsettled.astype(np.uint8), beside, mode="constant"))
        if not len(going):
            break
    moving = np.zeros(T, dtype=bool)
    moving[going] = True
    return q, moving


def _coupled(q: Array, smooth: float) -> tuple[Array, Array, Array]:
    """(T,) cost of what couples the frames, by the middle one of three; (T, K) its descent, (T,) its own stiffness."""
    cost, down, stiff = np.zeros(len(q)), np.zeros_like(q), np.zeros(len(q))
    if len(q) < 3:
        return cost, down, stiff
    second = q[2:] - 2.0 * q[1:-1] + q[:-2]
    cost[1:-1] = smooth * np.sum(second**2, axis=1)
    for n, share in enumerate((1.0, -2.0, 1.0)):
        down[n : len(q) - 2 + n] -= smooth * share * second
        stiff[n : len(q) - 2 + n] += smooth * share**2
    return cost, down, stiff


def _join(matrix: Array, frames: Indices, T: int, smooth: float) -> None:
    """Written to: what couples each of `frames`, of T, to the next and to the one after, where those are among them."""
    K = matrix.shape[2]
    if T < 3:
        return
    one = np.flatnonzero(np.diff(frames) == 1)
    outer = (frames[one] == 0).astype(float) + (frames[one] == T - 2)
    matrix[K, one] += (-2.0 * smooth * (2.0 - outer))[:, None]
    matrix[2 * K, np.flatnonzero(frames[2:] - frames[:-2] == 2)] += smooth


def _normal(
    body: HumanBody, observed: Observed, part: Indices, q: Array, scale: Array, offset: Array
) -> tuple[Array, Array, Array]:
    """rᵀr (T,), JᵀJ (T, K, K) and Jᵀr (T, K)."""
    seen = np.isfinite(observed.position[part, :, 0])
    at = pose(body, q, scale)
    place = places(at, observed.points, scale, offset)
    left = np.where(seen[..., None], observed.position[part] - place, 0.0)
    return np.sum(left**2, axis=(1, 2)), *normal(body, at, observed.points, place, left, seen.astype(np.float64))
