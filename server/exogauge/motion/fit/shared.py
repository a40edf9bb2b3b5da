"""What all frames share: scales and where the points sit. The frames' own angles are eliminated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_fit import MotionFit
from exogauge.motion.fit.body import SCALES, HumanBody
from exogauge.motion.fit.kinematics import places, pose, shared_slopes, slopes
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


def shared_fit(body: HumanBody, observed: Observed, q: Array, scale: Array, criteria: MotionFit) -> Shared:
    """Gauss-Newton on scales, offsets and the angles of a few frames, whose blocks are eliminated (Schur complement).

        min Σ_t Σ_m |x_tm − p_m(q_t; s, δ_m)|² / σ² + Σ_i (s_i − 1)² / σ_s² + Σ_m |δ_m|² / σ_m² + stated angles

    σ is estimated from what is left, over the degrees of freedom, and the fit repeated with it.
    q: (F, K) to start from. scale: (S,) likewise.
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
    z = np.concatenate([scale, np.zeros(3 * M)])
    P_q = observed.weight + criteria.angle_sd**-2.0
    eye, noise, settled = np.eye(K), criteria.start_noise, False

    def left(q: Array, z: Array) -> Array:
        at = pose(body, q, z[:S])
        place = places(at, observed.points, z[:S], z[S:].reshape(M, 3))
        return (target - place).reshape(F, -1) * rows

    def cost(q: Array, z: Array, noise: float) -> float:
        e = left(q, z)
        return float(np.sum(e**2) + noise**2 * (np.sum(P_q * (q - observed.mean) ** 2) + prior @ (z - z_0) ** 2))

    for n in range(criteria.shared_steps):
        at = pose(body, q, z[:S])
        place = places(at, observed.points, z[:S], z[S:].reshape(M, 3))
        r = (target - place).reshape(F, -1) * rows
        J = slopes(body, at, observed.points, place) * rows[..., None]
        G = shared_slopes(body, at, observed.points) * rows[..., None]
        A = np.swapaxes(J, 1, 2) @ J + noise**2 * P_q[..., None] * eye
        B = np.swapaxes(J, 1, 2) @ G
        g = np.einsum("tnk,tn->tk", J, r) + noise**2 * P_q * (observed.mean - q)
        flat = G.reshape(-1, G.shape[2])
        C = flat.T @ flat + np.diag(noise**2 * prior)
        h = flat.T @ r.ravel() + noise**2 * prior * (z_0 - z)
        solved = np.linalg.solve(A, np.concatenate([B, g[..., None]], axis=2))
        AB, Ag = solved[..., :-1], solved[..., -1]
        C -= B.reshape(-1, len(z)).T @ AB.reshape(-1, len(z))
        h -= np.einsum("tkz,tk->z", B, Ag)
        dz = np.linalg.solve(C, h)
        dq = Ag - AB @ dz
        before, share = cost(q, z, noise), 1.0
        while share > 1e-3:
            tried = z + share * dz
            tried[:S] = np.clip(tried[:S], least, largest)
            if cost(q + share * dq, tried, noise) <= before:
                break
            share *= 0.5
        q, moved = q + share * dq, tried - z
        z = tried
        inverse = np.linalg.inv(C)
        spent = F * K + len(z) - noise**2 * float(prior @ np.diag(inverse)) - _stated(A, P_q, noise)
        free = max(1.0, 3.0 * seen.sum() - spent)
        e = left(q, z)
        found = max(criteria.least_noise, float(np.sqrt(np.sum(e**2) / free * _memory(e, rows, criteria))))
        step = max(np.abs(moved).max(), np.abs(share * dq).max())
        changed, noise = abs(found / noise - 1.0), found
        if n > 1 and (step < criteria.settled or (step < criteria.nearly and changed < criteria.same_noise)):
            settled = True
            break
    covariance = np.asarray(noise**2 * inverse, np.float64)
    own = noise**2 * np.einsum("tkk->tk", np.linalg.inv(A))
    q_sd = np.asarray(np.sqrt(own + np.einsum("tkz,tkz->tk", AB @ covariance, AB)), np.float64)
    return Shared(z[:S], z[S:].reshape(M, 3), noise, q, covariance, q_sd, settled)


def _memory(e: Array, rows: Array, criteria: MotionFit) -> float:
    """How many of the frames (F, 3 M) say the same: (1 + ρ) / (1 − ρ) of a first-order process (Bartlett 1946).

    Skin slides with the posture and not from frame to frame. Of white noise this is 1.
    """
    both = rows[1:] * rows[:-1]
    power = np.sum(both * (e[1:] ** 2 + e[:-1] ** 2)) / 2.0
    rho = float(np.sum(both * e[1:] * e[:-1]) / power) if power > 0.0 else 0.0
    rho = min(max(rho, 0.0), criteria.longest_memory)
    return (1.0 + rho) / (1.0 - rho)


def _stated(A: Array, P_q: Array, noise: float) -> float:
    """Degrees of freedom of the angles that their priors decide."""
    return float(noise**2 * np.sum(P_q * np.einsum("tkk->tk", np.linalg.inv(A))))
