"""A primal-dual interior-point method for least squares over pseudo-inertias, with a log-det distance to a reference.

    min over phi   ‖A phi - b‖² + Σ_i w_i (tr(C_i J_i) - log det(C_i J_i) - 4),   C_i = J_ref,i⁻¹,  J_i = J(phi_i) ≻ 0

At the minimum a multiplier Z_i ≻ 0 of every body satisfies

    Z_i = gradient_i + w_i C_i,   gradient = 2 Aᵀ(A phi - b) as matrices,      J_i Z_i = w_i 1

Newton's method goes for both at once, with w_i ρ in place of w_i and ρ falling to 1. In the coordinates of Nesterov and
Todd, J_i ← W_i (Λ_i + S_i) W_iᵀ and Z_i ← W_i⁻ᵀ (Λ_i + S'_i) W_i⁻¹ with the same diagonal Λ_i, a step is the linear
least-squares problem [A W; √½ 1] s = [-(A phi - b); √½ (ρ w Λ⁻¹ - Wᵀ w C W)], solved by QR: A is never squared. Each
step looks ahead once without centring, and corrects for what the linearisation missed (Mehrotra).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from exogauge.estimation.log_cholesky import inertial_parameters, pseudo_inertia

Array = NDArray[np.float64]

CLOSEST_TO_BORDER = 0.98
"""A step goes at most this part of the way to the border."""
SHORT = 0.2
"""A step that cannot go further than this part of its length is replaced by one that only centres."""


def minimise(
    A: Array, b: Array, phi_ref: Array, weights: Array, tolerance: float, max_iterations: int
) -> tuple[Array, float, int, bool]:
    """(phi (N, 10), bound on the objective's excess over its minimum, steps, whether that is within the tolerance).

    A: (M, 10 N). b: (M,). phi_ref: (N, 10) possible bodies. weights: (N,) positive.
    """
    w, bodies = weights, len(phi_ref)
    phi = phi_ref
    C = np.asarray(np.linalg.inv(pseudo_inertia(phi_ref)), dtype=np.float64)
    r = A @ phi.ravel() - b
    start = np.maximum(w, float(r @ r) / (8.0 * bodies))
    Z = start[:, None, None] * C
    best, best_excess, steps = phi, np.inf, 0
    while True:
        try:
            excess = _excess(A, r, phi, w, C)
            if excess < best_excess or not np.isfinite(best_excess):
                best, best_excess = phi, excess
            if best_excess <= tolerance or steps >= max_iterations:
                return best, best_excess, steps, best_excess <= tolerance
            phi, Z = _step(A, r, phi, Z, w, C)
        except np.linalg.LinAlgError:  # by rounding, on the border: the last body inside is the answer
            return best, best_excess, steps, False
        r = A @ phi.ravel() - b
        steps += 1


def _excess(A: Array, r: Array, phi: Array, w: Array, C: Array) -> float:
    """Duality gap at phi: Σ_i w_i Σ_k (e/w_i - 1 - log(e/w_i)), e the eigenvalues of J_i Z_i, Z_i from stationarity.

    ∞ where that Z_i is not positive definite: then it bounds nothing.
    """
    Z = _gradient(2 * (A.T @ r).reshape(phi.shape)) + w[:, None, None] * C
    L = np.linalg.cholesky(pseudo_inertia(phi))
    e = np.linalg.eigvalsh(np.swapaxes(L, -1, -2) @ Z @ L) / w[:, None]
    if e.min() <= 0:
        return float(np.inf)
    return float(w @ np.sum(e - 1 - np.log(e), axis=1))


def _step(A: Array, r: Array, phi: Array, Z: Array, w: Array, C: Array) -> tuple[Array, Array]:
    """The next (phi, Z)."""
    bodies, rows = len(phi), A.shape[0]
    W, lam = _scaling(pseudo_inertia(phi), Z)
    W_T = np.swapaxes(W, -1, -2)
    T = np.swapaxes(inertial_parameters(W[:, None] @ SYMMETRIC @ W_T[:, None]), -1, -2)  # step of phi_i = T_i s_i
    c = w[:, None, None] * (W_T @ C @ W)
    A_s = (A.reshape(rows, bodies, 10).swapaxes(0, 1) @ T).swapaxes(0, 1).reshape(rows, 10 * bodies)
    system = np.vstack([A_s, np.sqrt(0.5) * np.eye(10 * bodies)])
    Q, triangle = sl.qr(system, mode="economic", overwrite_a=True, check_finite=False)

    def solve(complementarity: Array) -> tuple[Array, Array]:
        """(S, S') of the step for which Λ∘(S + S') is the given matrix: S + S' = D."""
        D = 2 * complementarity / (lam[:, :, None] + lam[:, None, :])
        target = np.einsum("nij,kij->nk", D + _diagonal(lam) - c, SYMMETRIC)
        s = sl.solve_triangular(triangle, Q.T @ np.concatenate([-r, np.sqrt(0.5) * target.ravel()]))
        S = np.einsum("nk,kij->nij", s.reshape(bodies, 10), SYMMETRIC)
        return S, D - S

    ahead = solve(_diagonal(w[:, None] - lam**2))
    reached = min(1.0, _to_border(lam, *ahead))
    rho = float(np.sum(lam**2) / (4 * np.sum(w)))
    left = [_diagonal(lam) + reached * side for side in ahead]
    rho_ahead = float(np.sum(left[0] * left[1]) / (4 * np.sum(w)))
    rho_next = max(1.0, rho * min(1.0, max(rho_ahead / rho, 0.0)) ** 3)
    missed = (ahead[0] @ ahead[1] + ahead[1] @ ahead[0]) / 2
    S, S_dual = solve(_diagonal(rho_next * w[:, None] - lam**2) - missed)
    t = min(1.0, CLOSEST_TO_BORDER * _to_border(lam, S, S_dual))
    if t < SHORT:  # the border is too near for that: back towards the middle first
        S, S_dual = solve(_diagonal(max(1.0, rho) * w[:, None] - lam**2))
        t = min(1.0, CLOSEST_TO_BORDER * _to_border(lam, S, S_dual))

    W_inverse = np.linalg.inv(W)
    s = np.einsum("nij,kij->nk", S, SYMMETRIC)
    Z_next = Z + t * np.swapaxes(W_inverse, -1, -2) @ S_dual @ W_inverse
    return phi + t * np.einsum("npk,nk->np", T, s), (Z_next + np.swapaxes(Z_next, -1, -2)) / 2


def _scaling(J: Array, Z: Array) -> tuple[Array, Array]:
    """(W (N, 4, 4), Λ (N, 4)): W⁻¹ J W⁻ᵀ = Wᵀ Z W = diag(Λ)."""
    L_J, L_Z = np.linalg.cholesky(J), np.linalg.cholesky(Z)
    _, lam, V_T = np.linalg.svd(np.swapaxes(L_Z, -1, -2) @ L_J)
    return L_J @ np.swapaxes(V_T, -1, -2) / np.sqrt(lam)[:, None, :], lam


def _to_border(lam: Array, S: Array, S_dual: Array) -> float:
    """The largest t for which every Λ + t S and Λ + t S' stay positive semidefinite."""
    root = np.sqrt(lam)
    relative = np.concatenate([S, S_dual]) / np.tile(root[:, :, None] * root[:, None, :], (2, 1, 1))
    lowest = float(np.linalg.eigvalsh(relative).min())
    return float(np.inf) if lowest >= 0 else -1.0 / lowest


def _gradient(slope: Array) -> Array:
    """Matrices G_i, (N, 4, 4), with tr(G_i dJ_i) = slope_i · dphi_i, for slopes (N, 10)."""
    parameters = inertial_parameters(SYMMETRIC)  # of each of the 10 basis matrices
    matrices: Array = np.einsum("np,kp,kij->nij", slope, parameters, SYMMETRIC)
    return matrices


def _diagonal(values: Array) -> Array:
    """(N, 4, 4) diagonal matrices of (N, 4) values."""
    diagonal: Array = np.asarray(values)[:, :, None] * np.eye(4)
    return diagonal


def _orthonormal_symmetric() -> Array:
    """(10, 4, 4) basis of the symmetric matrices, orthonormal in the Frobenius norm."""
    basis = np.zeros((10, 4, 4))
    for k, (i, j) in enumerate(zip(*np.triu_indices(4), strict=True)):
        basis[k, i, j] = basis[k, j, i] = 1.0 if i == j else np.sqrt(0.5)
    return basis


SYMMETRIC = _orthonormal_symmetric()
