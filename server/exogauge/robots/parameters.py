"""Names and units of the inertial parameters, body by body, in the order of `RigidTree.phi`.

The combinations of inertial parameters that the equations of motion can tell apart.

Columns of the regressor are taken from the base outwards; one that random motions show to be a combination of those
already kept is dropped and regrouped into them. So a leaf keeps seven parameters at a revolute joint, and its mass
moves to its parent: the kept columns of the force rows become few, which is what makes `row_blocks` fast.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.robots.motion import Motion
from exogauge.robots.regressor import cut_regressor, regressor
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]

SYMBOLS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
UNITS = ("kg", *("kg·m",) * 3, *("kg·m²",) * 6)


def parameter_names(tree: RigidTree) -> tuple[str, ...]:
    """(10N,) `m[link]` mass, `mx[link]` … first moments, `Ixx[link]` … inertia about the link frame's origin."""
    return tuple(f"{symbol}[{body}]" for body in tree.bodies for symbol in SYMBOLS)


def parameter_units(tree: RigidTree) -> tuple[str, ...]:
    """(10N,) SI units."""
    return UNITS * len(tree.bodies)


def of_slide(unit: str) -> str:
    """A turning joint's unit as that of one that slides: N·m·s/rad is N·s/m, kg·m² is kg, N·m/A is N/A."""
    return unit.replace("kg·m²", "kg").replace("N·m", "N").replace("rad", "m")


def unit_at(tree: RigidTree, joint: str, unit: str) -> str:
    """A turning joint's unit as it is at this joint, which turns or slides."""
    return of_slide(unit) if joint in tree.sliding else unit


def inertia_by_first_moment(c: Array) -> Array:
    """(6, 3) of the inertia about the origin by m c where the mass keeps its inertia about its centre c (3,)."""
    x, y, z = c
    return np.array([
        [0.0, 2 * y, 2 * z], [-y, -x, 0.0], [2 * x, 0.0, 2 * z],
        [-z, 0.0, -x], [0.0, -z, -y], [2 * x, 2 * y, 0.0],
    ])  # fmt: skip


DEPENDENT = 1e-8  # what is left of a unit column that depends on the kept ones; 1e-14 and 1e-3 are seen


@final
@dataclass(frozen=True)
class BaseParameters:
    """B combinations of the 10N standard parameters: Y φ = Y[:, columns] @ φ_base.

    columns: (B,) indices of the kept standard parameters, ascending. regroup: (B, 10N), φ_base = regroup @ φ.ravel().
    names: (B,) the kept parameters; each stands for its combination (`combination`).
    """

    columns: IntArray
    regroup: Array
    names: tuple[str, ...]

    @property
    def rank(self) -> int:
        return len(self.columns)

    def combination(self, k: int, names: tuple[str, ...], digits: int = 4) -> str:
        """The k-th base parameter written out, without terms below 1e-6. names: (10N,) of the standard parameters."""
        row, kept = self.regroup[k], self.columns[k]
        others = [i for i in np.flatnonzero(np.abs(row) > 1e-6) if i != kept]
        return str(names[kept]) + "".join(f" {row[i]:+.{digits}g}·{names[i]}" for i in others)


def find_base_parameters(
    tree: RigidTree, rng: np.random.Generator | None = None, up: Array | None = None
) -> BaseParameters:
    """Base parameters from the rows [Y_o; Y_j], and those of sensors inside the robot, of random motions.

    up: (3,) [m/s²] proper acceleration of a fixed base at rest, in its frame; default 9.81 along z.

    Implements [Evaluator] (11), (13), text: minimal set of inertial parameters.
    """
    negligible = 1e-14  # regrouping coefficients below this are zeros; rounding leaves 1e-15, angles like 1.5708 1e-12
    rng = np.random.default_rng(0) if rng is None else rng
    n = 10 * len(tree.bodies)
    rows_each = len(tree.joints) + (6 if tree.floating else 0)
    samples = max(60, int(np.ceil(4 * n / max(rows_each, 1))))
    motion = _random_motion(tree, samples, rng, up)
    seen = [regressor(tree, motion), *(cut_regressor(tree, motion, frame) for frame in tree.cuts)]
    Y = np.concatenate(seen, axis=1).reshape(-1, n)
    scale = np.linalg.norm(Y, axis=0)
    live = scale > 1e-12 * scale.max(initial=1e-300)
    order = [c for c in _preference(tree) if live[c]]
    kept, Q = _keep_independent(Y[:, order] / scale[order])
    columns = np.sort(np.array([order[k] for k in kept], dtype=np.intp))
    dependent = np.setdiff1d(np.flatnonzero(live), columns)
    A = Y[:, columns] / scale[columns]
    D = Y[:, dependent] / scale[dependent]
    R = Q.T @ A
    K = np.linalg.solve(R, Q.T @ D)
    K += np.linalg.solve(R, Q.T @ (D - A @ K))  # one refinement
    K *= scale[dependent] / scale[columns][:, None]
    K[np.abs(K) < negligible] = 0.0
    regroup = np.zeros((len(columns), n))
    regroup[np.arange(len(columns)), columns] = 1.0
    regroup[:, dependent] = K
    names = parameter_names(tree)
    return BaseParameters(columns, regroup, tuple(names[c] for c in columns))


def _random_motion(tree: RigidTree, samples: int, rng: np.random.Generator, up: Array | None) -> Motion:
    """Every angle, velocity and acceleration, of a size that lets gravity and inertia weigh alike."""
    shape = (samples, len(tree.joints))
    q = rng.uniform(-np.pi, np.pi, shape)
    q[:, tree.dof[tree.prismatic]] /= np.pi
    dq, ddq = 3.0 * rng.normal(size=shape), 10.0 * rng.normal(size=shape)
    if not tree.floating:
        still = np.zeros((samples, 3))
        return Motion(q, dq, ddq, still + (np.array([0.0, 0.0, 9.81]) if up is None else up), still, still)
    acc, gyro, gyro_dot = (size * rng.normal(size=(samples, 3)) for size in (10.0, 3.0, 10.0))
    return Motion(q, dq, ddq, acc, gyro, gyro_dot)


def _preference(tree: RigidTree) -> list[int]:
    """Standard parameters, those to keep first: from the base outwards, then those the joint's axis concerns least.

    What a revolute joint makes dependent is the mass on its axis, the first moment along it and the inertia of a thin
    rod along it, 1 − a aᵀ: the largest component of each is dropped, so that no small number is divided by.
    """
    order: list[int] = []
    for i, joint_axis in enumerate(tree.axis):
        if tree.dof[i] < 0 or tree.prismatic[i]:
            order += range(10 * i, 10 * i + 10)
            continue
        a = tree.T_after[i].rotation.T @ joint_axis
        rod = np.eye(3) - np.outer(a, a)
        weight = np.r_[np.inf, np.abs(a), np.abs(rod[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]])]
        inertia = 4 + np.argsort(weight[4:], kind="stable")
        first = 1 + np.argsort(weight[1:4], kind="stable")
        order += [10 * i + int(k) for k in (*inertia, *first, 0)]
    return order


def _keep_independent(A: Array) -> tuple[list[int], Array]:
    """Indices of the columns that do not depend on earlier kept ones, and an orthonormal basis of them.

    Gram-Schmidt, every projection done twice.
    """
    Q = np.empty((A.shape[0], min(A.shape)), order="F")
    kept: list[int] = []
    for k in range(A.shape[1]):
        column = A[:, k]
        basis = Q[:, : len(kept)]
        for _ in range(2):
            column = column - basis @ (basis.T @ column)
        size = float(scipy.linalg.norm(column))
        if size > DEPENDENT:
            Q[:, len(kept)] = column / size
            kept.append(k)
    return kept, Q[:, : len(kept)]
