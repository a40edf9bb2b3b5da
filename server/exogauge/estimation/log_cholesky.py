"""The cone of possible bodies: pseudo-inertias, a parametrisation that cannot leave it, and a distance within it.

Ten inertial parameters phi = [m, mx, my, mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz], about the origin of the body's frame
[kg, kg·m, kg·m²], are possible for a body of positive density exactly when the 4×4 pseudo-inertia

    J = ∫ [r; 1][r; 1]ᵀ dm = [[½ tr(I) 1 - I, h], [hᵀ, m]],  h = [mx, my, mz]

is positive definite: positive mass, positive moments about the centre of mass, and their triangle inequality in one.
Every function works on stacks: phi (..., 10), J (..., 4, 4), theta (..., 10).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_UPPER = {"s12": (0, 1), "s23": (1, 2), "s13": (0, 2), "t1": (0, 3), "t2": (1, 3), "t3": (2, 3)}


def pseudo_inertia(phi: Array) -> Array:
    """J, (..., 4, 4), symmetric and linear in phi (..., 10)."""
    m, mx, my, mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz = np.moveaxis(phi, -1, 0)
    xx, yy, zz = (Iyy + Izz - Ixx) / 2, (Ixx + Izz - Iyy) / 2, (Ixx + Iyy - Izz) / 2
    rows = [[xx, -Ixy, -Ixz, mx], [-Ixy, yy, -Iyz, my], [-Ixz, -Iyz, zz, mz], [mx, my, mz, m]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def inertial_parameters(J: Array) -> Array:
    """phi, (..., 10), of pseudo-inertias J (..., 4, 4); the inverse of `pseudo_inertia`."""
    xx, yy, zz = J[..., 0, 0], J[..., 1, 1], J[..., 2, 2]
    inertia = [yy + zz, -J[..., 0, 1], xx + zz, -J[..., 0, 2], -J[..., 1, 2], xx + yy]
    return np.stack([J[..., 3, 3], J[..., 0, 3], J[..., 1, 3], J[..., 2, 3], *inertia], axis=-1)


def central_moments(phi: Array) -> Array:
    """∫ r rᵀ dm about the centre of mass, (..., 3, 3) [kg·m²]; positive definite for a possible body. Needs m ≠ 0."""
    J = pseudo_inertia(phi)
    h = J[..., :3, 3]
    moments: Array = J[..., :3, :3] - h[..., :, None] * h[..., None, :] / J[..., 3, 3, None, None]
    return moments


def from_log_cholesky(theta: Array) -> Array:
    """phi, (..., 10), of theta = [α, d1, d2, d3, s12, s23, s13, t1, t2, t3]: J = U Uᵀ, possible for any real theta."""
    U = _factor(theta)
    return inertial_parameters(U @ np.swapaxes(U, -1, -2))


def to_log_cholesky(phi: Array) -> Array:
    """theta, (..., 10), of possible bodies; `numpy.linalg.LinAlgError` for an impossible one."""
    flipped = pseudo_inertia(phi)[..., ::-1, ::-1]
    U = np.linalg.cholesky(flipped)[..., ::-1, ::-1]
    scale = U[..., 3, 3]
    diagonal = [np.log(U[..., i, i] / scale) for i in range(3)]
    return np.stack([np.log(scale), *diagonal, *(U[..., i, j] / scale for i, j in _UPPER.values())], axis=-1)


def log_cholesky_jacobian(theta: Array) -> Array:
    """∂phi/∂theta, (..., 10, 10): column k is the change of phi with theta_k."""
    U = _factor(theta)
    dU = np.zeros((*theta.shape[:-1], 10, 4, 4))
    dU[..., 0, :, :] = U
    for k in range(3):
        dU[..., 1 + k, k, k] = U[..., k, k]
    for k, (i, j) in enumerate(_UPPER.values()):
        dU[..., 4 + k, i, j] = U[..., 3, 3]
    dJ = dU @ np.swapaxes(U, -1, -2)[..., None, :, :]
    return np.swapaxes(inertial_parameters(dJ + np.swapaxes(dJ, -1, -2)), -1, -2)


def log_det_distance(phi: Array, phi_ref: Array) -> Array:
    """tr(J_ref⁻¹ J) - log det(J_ref⁻¹ J) - 4, (...): ≥ 0, 0 at the reference, ∞ at the border of the possible.

    It does not depend on the frame in which both bodies are written, unlike a Euclidean distance.
    """
    ratio = _eigenvalues_relative(phi, phi_ref)
    possible = ratio.min(axis=-1) > 0
    safe = np.where(possible[..., None], ratio, 1.0)
    return np.where(possible, np.sum(safe - 1 - np.log(safe), axis=-1), np.inf)


def relative_margin(phi: Array, phi_ref: Array) -> Array:
    """Smallest eigenvalue of J_ref⁻¹ J, (...): 1 at the reference, 0 on the border, negative for an impossible body."""
    margin: Array = _eigenvalues_relative(phi, phi_ref).min(axis=-1)
    return margin


def nearest_possible(phi: Array, gyration: float = 5e-3, thinness: float = 1e-4) -> Array:
    """phi, (..., 10), with the moments about the centre of mass raised where they are too small; mass and centre stay.

    Each principal ∫ r² dm becomes at least m·gyration² [m] and at least `thinness` times the largest. Needs m > 0.
    """
    m, h = phi[..., 0], phi[..., 1:4]
    value, axes = np.linalg.eigh(central_moments(phi))
    floor = np.maximum(m * gyration**2, thinness * value.max(axis=-1))
    raised = np.maximum(value, floor[..., None])
    J: Array = pseudo_inertia(phi)
    central = (axes * raised[..., None, :]) @ np.swapaxes(axes, -1, -2)
    J[..., :3, :3] = central + h[..., :, None] * h[..., None, :] / m[..., None, None]
    return np.where((value >= floor[..., None]).all(axis=-1)[..., None], phi, inertial_parameters(J))


def _factor(theta: Array) -> Array:
    """Upper triangular U, (..., 4, 4), with J = U Uᵀ."""
    U = np.zeros((*theta.shape[:-1], 4, 4))
    for k in range(3):
        U[..., k, k] = np.exp(theta[..., 1 + k])
    for k, (i, j) in enumerate(_UPPER.values()):
        U[..., i, j] = theta[..., 4 + k]
    U[..., 3, 3] = 1.0
    scaled: Array = np.exp(theta[..., 0])[..., None, None] * U
    return scaled


def _eigenvalues_relative(phi: Array, phi_ref: Array) -> Array:
    """Eigenvalues of J_ref⁻¹ J, (..., 4), ascending; the reference must be possible."""
    L_inverse = np.linalg.inv(np.linalg.cholesky(pseudo_inertia(phi_ref)))
    ratio = L_inverse @ pseudo_inertia(phi) @ np.swapaxes(L_inverse, -1, -2)
    return np.asarray(np.linalg.eigvalsh(ratio), dtype=np.float64)
