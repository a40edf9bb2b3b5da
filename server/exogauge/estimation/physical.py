"""Least squares over bodies that can exist: every pseudo-inertia stays positive definite.

    min over phi, other   ‖R [phi; other] - z‖² + Σ_i w_i d(phi_i, phi_ref_i)
    d(phi, ref) = tr(J_ref⁻¹ J) - log det(J_ref⁻¹ J) - 4

R and z are a least-squares problem in square-root form, rows divided by their standard deviation. The problem is
convex in phi itself, so it is solved there (`interior_point`) and what is found is the global minimum, with a bound on
how far it can be off. Log-Cholesky coordinates also keep bodies possible, but bend the problem, and run to -∞ when
the answer lies on the border. Three uses:

- weights of the size of what is believed: the log-det distance is the a-priori term of phi, and R holds no other;
- weights that are small beside that: R holds what is believed, and the distance keeps bodies from the border;
- no weights: the distance is only a barrier, too light to cost anything that matters; bodies may end at the border.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from exogauge.errors import PhysicallyImpossible
from exogauge.estimation.interior_point import SYMMETRIC, minimise
from exogauge.estimation.log_cholesky import (
    inertial_parameters,
    log_det_distance,
    nearest_possible,
    pseudo_inertia,
    relative_margin,
)
from exogauge.remarks import About, Remark

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class PhysicalSolution:
    """phi: (N, 10). other: (K,). x: (10 N + K,) both, in the order of R's columns.

    cost: ‖R x - z‖². distance: (N,) log-det distance to the reference; margin: (N,) smallest eigenvalue of J_ref⁻¹ J,
    positive for a possible body; both nan for a held body. held: (N,) bodies kept at the reference.
    excess: bound on how far the objective (without weights: the cost) still lies above its minimum.
    iterations: Newton steps, each one QR of about 20 N rows and 10 N columns.
    """

    phi: Array
    other: Array
    x: Array
    cost: float
    distance: Array
    margin: Array
    held: BoolArray
    excess: float
    iterations: int
    converged: bool
    remarks: tuple[Remark, ...]


def solve_physical(
    R: Array,
    z: Array,
    phi_ref: Array,
    *,
    weight: float | Array | None = None,
    held: BoolArray | None = None,
    names: tuple[str, ...] = (),
    tolerance: float = 1e-4,
    max_iterations: int = 100,
) -> PhysicalSolution:
    """The least-squares solution among bodies that can exist.

    R: (M, 10 N + K) any matrix, columns [phi_0 … phi_{N-1}, other]. z: (M,). phi_ref: (N, 10) a-priori bodies.
    weight: scalar or (N,), in units of R's squared rows; None (or 0 for a body) = the distance is only a barrier.
    held: (N,) bodies kept at phi_ref; bodies without any mass or inertia in phi_ref are always held.
    names: of the bodies, in what is said of them; default: their numbers from 0.
    tolerance: how far above its minimum the objective may end, in units of R's squared rows (squared standard
    deviations); at the default nobody can tell the two apart.

    A reference that no body can have is replaced by the nearest possible one, with a remark; one without positive
    mass has none: `PhysicallyImpossible`.
    """
    bodies = phi_ref.shape[0]
    others = R.shape[1] - 10 * bodies
    if others < 0 or z.shape != (R.shape[0],):
        raise ValueError(f"R {R.shape}, z {z.shape} and {bodies} bodies do not fit together")
    remarks: list[Remark] = []
    held = np.all(phi_ref == 0, axis=1) | (np.zeros(bodies, bool) if held is None else held)
    reference = _possible_references(phi_ref, held, names or tuple(str(k) for k in range(bodies)), remarks)
    free = ~held

    R_phi, R_other = R[:, : 10 * bodies].reshape(-1, bodies, 10), R[:, 10 * bodies :]
    z_free = z - np.einsum("mnp,np->m", R_phi[:, held], phi_ref[held])
    phi, excess, iterations, converged = phi_ref.copy(), 0.0, 0, True
    if free.any():
        A, b = _no_surer(*_without_others(R_phi[:, free].reshape(len(R), -1), z_free, R_other), reference[free])
        barrier = tolerance / (32.0 * bodies)  # at the border it costs 4 of these a body, and its trace about as much
        weights = np.maximum(_checked(weight, bodies), barrier)
        phi[free], excess, iterations, converged = minimise(
            A, b, reference[free], weights[free], tolerance / 2, max_iterations
        )
    margin, distance = np.full(bodies, np.nan), np.full(bodies, np.nan)
    margin[free] = relative_margin(phi[free], reference[free])
    distance[free] = log_det_distance(phi[free], reference[free])
    if weight is None:
        excess += barrier * float(np.sum(4 + np.abs(distance[free]))) if free.any() else 0.0
    if not converged:
        remarks.append(Remark(About.NOT_CONVERGED, numbers=(iterations, excess, tolerance)))
    other = _least_squares_others(R_other, z_free - np.einsum("mnp,np->m", R_phi[:, free], phi[free]), remarks)
    x = np.concatenate([phi.ravel(), other])
    cost = float(np.sum((R @ x - z) ** 2))
    return PhysicalSolution(phi, other, x, cost, distance, margin, held, excess, iterations, converged, tuple(remarks))


def _possible_references(phi_ref: Array, held: BoolArray, names: tuple[str, ...], remarks: list[Remark]) -> Array:
    massless = [names[k] for k in np.flatnonzero(~held & (phi_ref[:, 0] <= 0))]
    if massless:
        raise PhysicallyImpossible(
            f"these bodies have no positive mass before identification: {', '.join(massless)}; give one, or hold them",
            massless,
        )
    reference = phi_ref.copy()
    reference[~held] = nearest_possible(phi_ref[~held])
    raised = [names[k] for k in np.flatnonzero(np.any(reference != phi_ref, axis=1))]
    if raised:
        remarks.append(Remark(About.REFERENCE_IMPOSSIBLE, tuple(raised)))
    return reference


def _checked(weight: float | Array | None, bodies: int) -> Array:
    weights = np.array(np.broadcast_to(np.asarray(0.0 if weight is None else weight, dtype=np.float64), (bodies,)))
    if not np.all(weights >= 0):
        raise ValueError("weights of the log-det distance must not be negative")
    return weights


def _without_others(R_phi: Array, z: Array, R_other: Array) -> tuple[Array, Array]:
    """(A, b): min over other of ‖R_phi phi + R_other other - z‖² = ‖A phi - b‖² + constant; A: at most 10 N rows."""
    rest: Array = np.column_stack([R_phi, z])
    if R_other.size:
        U, singular, _ = sl.svd(R_other, full_matrices=False, lapack_driver="gesvd")  # gesdd may not converge
        Q = U[:, singular > 1e-13 * singular[0]]
        rest = np.asarray(rest - Q @ (Q.T @ rest), dtype=np.float64)
    columns = R_phi.shape[1]
    if rest.shape[0] > columns:
        (triangle,) = sl.qr(rest, mode="r", check_finite=False)
        rest = np.asarray(triangle[:columns], dtype=np.float64)
    return rest[:, :-1], rest[:, -1]


def _no_surer(A: Array, b: Array, reference: Array) -> tuple[Array, Array]:
    """(A, b) in which no combination is known better than to a millionth of the bodies' own size.

    Logs without noise claim ten digits and more. Squared, rounding of those is larger than all that the others say,
    and the search does not end. What has six digits moves by less than a thousandth of its standard deviation.
    """
    enough = 1e6  # standard deviations in the size of a body
    root = np.linalg.cholesky(pseudo_inertia(reference))
    turned = root[:, None] @ SYMMETRIC @ np.swapaxes(root, -1, -2)[:, None]
    of_unit = np.swapaxes(inertial_parameters(turned), -1, -2)  # a change by the size of body i, phi_i = of_unit_i s_i
    scaled = np.einsum("mnp,npk->mnk", A.reshape(len(A), *reference.shape), of_unit).reshape(A.shape)
    if np.linalg.norm(scaled) <= enough:
        return A, b
    U, singular, V_T = sl.svd(scaled, full_matrices=False, lapack_driver="gesvd")
    kept = np.minimum(1.0, enough / np.maximum(singular, enough))
    held = ((kept * singular)[:, None] * V_T).reshape(-1, *reference.shape)
    back = np.einsum("mnk,nkp->mnp", held, np.linalg.inv(of_unit))
    return back.reshape(-1, A.shape[1]), kept * (U.T @ b)


def _least_squares_others(R_other: Array, z: Array, remarks: list[Remark]) -> Array:
    if not R_other.shape[1]:
        return np.zeros(0)
    other, _, rank, _ = np.linalg.lstsq(R_other, z, rcond=1e-13)
    if rank < R_other.shape[1]:
        open_ones = R_other.shape[1] - int(rank)
        remarks.append(Remark(About.UNDECIDED_COMBINATIONS, numbers=(open_ones,)))
    return np.asarray(other, dtype=np.float64)
