"""What all frames share: scales and where the points sit. The frames' own angles are eliminated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_fit import MotionFit
from exogauge.motion.fit.body import SCALES, HumanBody
from exogauge.motion.fit.kinematics import beyond, places, pose, scale_slopes, slopes
from exogauge.motion.fit.observed import Observed

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Shared:
    """scale: (S,); offset: (M, 3) [m]; noise: [m] sd of a coordinate of a point; q: (F, K) of the frames used.

    covariance: (S + 3 M, S + 3 M) of both; q_sd: (F, K), what they leave open included. settled: did it?
    """

    scale: Array
    offset: Array
    noise: float
    q: Array
    covariance: Array
    q_sd: Array
    settled: bool


def shared_fit(
    body: HumanBody, observed: Observed, q: Array, scale: Array, offset: Array, to_go: float, criteria: MotionFit
) -> Shared:  # fmt: skip
    """Gauss-Newton on scales, offsets and the angles of a few frames, whose blocks are eliminated (Schur complement).

        min Σ_t Σ_m |x_tm − p_m(q_t; s, δ_m)|² / σ² + Σ_i (s_i − 1)² / σ_s² + Σ_m |δ_m|² / σ_m² + stated angles

    σ is estimated from what is left, over the degrees of freedom, and the fit repeated with it.
    q: (F, K) to start from. scale: (S,), offset: (M, 3) likewise. It has settled where what a step promises is less
    than `to_go`, in σ²: all unknowns together would move by √to_go deviations; or where it gains less, though slopes
    promise some more, as of an arm that swings to and fro about where its turns are one.
    """
    F, K = q.shape
    S, M = len(SCALES), len(observed.labels)
    seen = np.asarray(np.isfinite(observed.position).all(axis=2))
    target = np.where(seen[..., None], observed.position, 0.0)
    rows = np.repeat(seen, 3, axis=1).astype(np.float64)
    depth = SCALES.index("lumbar_depth")
    sd = np.where(np.arange(S) == depth, criteria.depth_sd, criteria.scale_sd)
    least = np.where(np.arange(S) == depth, -np.inf, criteria.least_scale)
    largest = np.where(np.arange(S) == depth, np.inf, criteria.largest_scale)
    prior = np.concatenate([sd**-2.0, np.repeat(observed.offset_sd**-2.0, 3)])
    z_0 = np.concatenate([np.ones(S), np.zeros(3 * M)])
    z = np.concatenate([scale, offset.ravel()])
    P_q = observed.weight + criteria.angle_sd**-2.0
    eye, noise, settled = np.eye(K), criteria.start_noise, False

    def left(q: Array, z: Array) -> Array:
        at = pose(body, q, z[:S])
        place = places(at, observed.points, z[:S], z[S:].reshape(M, 3))
        return (target - place).reshape(F, -1) * rows

    def cost(q: Array, z: Array, noise: float) -> tuple[Array, float]:
        off = q - observed.mean
        out = beyond(body, q, criteria.reach_sd)[0] * criteria.reach_sd
        own = np.sum(left(q, z) ** 2, axis=1) + noise**2 * np.sum(P_q * off**2 + out**2, axis=1)
        return own, float(own.sum() + noise**2 * (prior @ (z - z_0) ** 2))

    damping = np.full(F, criteria.damping)
    for n in range(criteria.shared_steps):
        A, B, C, g, h = _equations(body, observed, q, z, left(q, z), seen)
        out, stiff = beyond(body, q, criteria.reach_sd)
        g += noise**2 * (P_q * (observed.mean - q) - out)
        A += noise**2 * (P_q + stiff)[..., None] * eye
        C += np.diag(noise**2 * prior)
        h += noise**2 * prior * (z_0 - z)
        own, before = cost(q, z, noise)
        inverse_A = np.linalg.inv(A + (damping[:, None] * np.einsum("tkk->tk", A))[..., None] * eye)
        AB, Ag = inverse_A @ B, np.einsum("tkl,tl->tk", inverse_A, g)
        inverse = np.linalg.inv(C - B.reshape(-1, len(z)).T @ AB.reshape(-1, len(z)))
        dz = inverse @ (h - np.einsum("tkz,tk->z", B, Ag))
        dq = Ag - AB @ dz
        promised, share = float(np.sum(g * dq) + h @ dz) / noise**2, 1.0
        while share > criteria.least_share:
            tried = z + share * dz
            tried[:S] = np.clip(tried[:S], least, largest)
            own_then, then = cost(q + share * dq, tried, noise)
            if then <= before * (1.0 + criteria.round_off):
                break
            damping[own_then > own] *= 10.0 if share == 1.0 else 1.0
            share *= 0.5
        else:
            damping *= 10.0
        damping *= 0.1 if share == 1.0 else 1.0
        if then > before * (1.0 + criteria.round_off):
            continue
        gained = (before - then) / noise**2
        q, moved = q + share * dq, tried - z
        z = tried
        spent = F * K + len(z) - noise**2 * float(prior @ np.diag(inverse))
        spent -= noise**2 * float(np.sum(P_q * np.einsum("tkk->tk", inverse_A)))  # what priors decide of the angles
        free = max(1.0, 3.0 * seen.sum() - spent)
        e = left(q, z)
        found = max(criteria.least_noise, float(np.sqrt(np.sum(e**2) / free * _memory(e, rows, criteria))))
        step = max(np.abs(moved).max(), np.abs(share * dq).max())
        changed, noise = abs(found / noise - 1.0), found
        enough = to_go * min(1.0, noise / criteria.real_noise)
        swings = share == 1.0 and gained < enough and promised < criteria.swings * enough
        near = (promised < enough or swings) and changed < criteria.same_noise
        if n > 1 and (step < criteria.settled or near or (step < criteria.nearly and changed < criteria.same_noise)):
            settled = True
            break
    if damping.max() > criteria.least_damping:
        inverse_A = np.linalg.inv(A)
        AB = inverse_A @ B
        inverse = np.linalg.inv(C - B.reshape(-1, len(z)).T @ AB.reshape(-1, len(z)))
    covariance = np.asarray(noise**2 * inverse, np.float64)
    alone = noise**2 * np.einsum("tkk->tk", inverse_A)
    q_sd = np.asarray(np.sqrt(alone + np.einsum("tkz,tkz->tk", AB @ covariance, AB)), np.float64)
    return Shared(z[:S], z[S:].reshape(M, 3), noise, q, covariance, q_sd, settled)


def _equations(
    body: HumanBody, observed: Observed, q: Array, z: Array, r: Array, seen: NDArray[np.bool_]
) -> tuple[Array, Array, Array, Array, Array]:  # fmt: skip
    """A (F, K, K) of the angles, B (F, K, S + 3 M) of both, C of scales and offsets; descents g (F, K), h (S + 3 M,);
    r: (F, 3 M) what is left of the points that are seen (F, M)."""
    (F, K), M, S = q.shape, len(observed.labels), len(SCALES)
    at = pose(body, q, z[:S])
    place = places(at, observed.points, z[:S], z[S:].reshape(M, 3))
    J = slopes(body, at, observed.points, place) * np.repeat(seen, 3, axis=1)[..., None]
    by_scale = scale_slopes(body, at, observed.points) * seen[..., None, None]
    turned = at.rotation[:, observed.points.joint] * seen[..., None, None]
    J_t, flat = np.swapaxes(J, 1, 2), by_scale.reshape(-1, S)
    by_offset = np.swapaxes(J.reshape(F, M, 3, K), 2, 3) @ turned  # (F, M, K, 3)
    B = np.concatenate([J_t @ by_scale.reshape(F, 3 * M, S), by_offset.transpose(0, 2, 1, 3).reshape(F, K, -1)], axis=2)
    C = np.zeros((len(z), len(z)))
    C[:S, :S] = flat.T @ flat
    both = np.einsum("tmas,tmab->smb", by_scale, turned, optimize=True).reshape(S, -1)
    C[:S, S:], C[S:, :S] = both, both.T
    C[S:, S:] = np.diag(np.repeat(seen.sum(axis=0), 3).astype(np.float64))
    h = np.concatenate([flat.T @ r.ravel(), np.einsum("tmab,tma->mb", turned, r.reshape(F, M, 3)).ravel()])
    return J_t @ J, B, C, (J_t @ r[..., None])[..., 0], h


def _memory(e: Array, rows: Array, criteria: MotionFit) -> float:
    """How many of the frames (F, 3 M) say the same: (1 + ρ) / (1 − ρ) of a first-order process (Bartlett 1946).

    Skin slides with the posture and not from frame to frame. Of white noise this is 1.
    """
    both = rows[1:] * rows[:-1]
    power = np.sum(both * (e[1:] ** 2 + e[:-1] ** 2)) / 2.0
    rho = float(np.sum(both * e[1:] * e[:-1]) / power) if power > 0.0 else 0.0
    rho = min(max(rho, 0.0), criteria.longest_memory)
    return (1.0 + rho) / (1.0 - rho)
