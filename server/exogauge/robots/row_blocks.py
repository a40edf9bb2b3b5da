"""The regressor row by row, only where it is not zero, for many samples at once: the fast path of identification.

One block per equation: six base rows when floating, then one row per actuator axis. A base force row has columns for
masses and first moments only, an axis row for the bodies its joints carry only. With axes a = C q an axis torque is
C⁻ᵀ times the joint torques.

Each body's columns are computed once, as force and moment about the base origin in the base frame; a joint row is then
the joint's motion (a six-vector) times those columns in its subtree.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.base_parameters import BaseParameters
from exogauge.robots.kinematics import Kinematics, Sweep
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import inverse_dynamics
from exogauge.robots.row_layout import RowLayout
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]


class Rows(Protocol):
    """What `RowBlocks` and its compiled twin offer.

    base: the parameters of the columns. columns: per row r (k_r,), which of them its block has.
    """

    @property
    def base(self) -> BaseParameters: ...

    @property
    def columns(self) -> tuple[IntArray, ...]: ...

    def fill(self, motion: Motion, extra: int = 0, out: Sequence[Array] | None = None) -> list[Array]:
        """Per row a block (T, k_r + extra), Fortran order (time contiguous): regressor columns, then `extra` zeros.

        Accumulate with `scipy.linalg.blas.dsyrk(1.0, block, trans=1, beta=1.0, c=gram, overwrite_c=1)`, no copy.
        out: blocks of an earlier call, overwritten if their shape fits, which saves page faults.
        """
        ...

    def predict(self, motion: Motion, phi_base: Array) -> Array:
        """(T, rows) regressor times base parameters, without building the regressor. phi_base: (B,)."""
        ...


def row_blocks(tree: RigidTree, base: BaseParameters, axes_from_joints: Array, fast: bool | None = None) -> Rows:
    """The compiled rows where numba is installed, else NumPy's. fast: True insists on numba, False on NumPy."""
    if fast is False:
        return RowBlocks(tree, base, axes_from_joints)
    try:
        from exogauge.robots.row_blocks_numba import CompiledRowBlocks
    except ImportError:
        if fast:
            raise
        return RowBlocks(tree, base, axes_from_joints)
    return CompiledRowBlocks(tree, base, axes_from_joints)


@final
class RowBlocks:
    """The reference, in NumPy; chunks of 250 to 500 samples are fastest. Threads may share it."""

    def __init__(self, tree: RigidTree, base: BaseParameters, axes_from_joints: Array) -> None:
        self.tree, self.base, self.axes_from_joints = tree, base, axes_from_joints
        self.layout = RowLayout.of(tree, base, axes_from_joints)
        self.columns = self.layout.columns
        self.kinematics = Kinematics(tree)

    def fill(self, motion: Motion, extra: int = 0, out: Sequence[Array] | None = None) -> list[Array]:
        """See `Rows.fill`."""
        blocks = ready_blocks(self.columns, motion.samples, extra, out)
        layout, sweep = self.layout, self.kinematics.sweep(motion)
        mass, inertia = _mass_columns(layout, sweep), _inertia_columns(layout, sweep)
        first_axis = 6 if self.tree.floating else 0
        k_1, k_2 = len(layout.mass), len(layout.inertia)
        for row in range(first_axis):
            blocks[row].T[:k_1] = mass[row]
            if row >= 3:
                blocks[row].T[k_1 : k_1 + k_2] = inertia[row - 3]
        for axis, block in enumerate(blocks[first_axis:]):
            rows = block.T
            for s in layout.mass_segments[axis]:
                S = _combined(sweep, s.bodies, s.weights)
                np.einsum("rt,rkt->kt", S, mass[:, s.first : s.last], out=rows[s.start : s.start + s.last - s.first])
            for s in layout.inertia_segments[axis]:
                S = _combined(sweep, s.bodies, s.weights)[3:]
                if S.any():  # a sliding joint feels no inertia
                    np.einsum(
                        "rt,rkt->kt", S, inertia[:, s.first : s.last], out=rows[s.start : s.start + s.last - s.first]
                    )
                else:
                    rows[s.start : s.start + s.last - s.first] = 0.0
        return blocks

    def predict(self, motion: Motion, phi_base: Array) -> Array:
        """See `Rows.predict`."""
        return predict(self.tree, self.base, self.axes_from_joints, motion, phi_base)


def ready_blocks(
    columns: Sequence[IntArray], samples: int, extra: int, out: Sequence[Array] | None = None
) -> list[Array]:
    """Blocks (T, k_r + extra) in Fortran order, their extra columns zero; `out` itself where it fits."""
    shapes = [(samples, len(c) + extra) for c in columns]
    if out is not None and [block.shape for block in out] == shapes and all(b.flags.f_contiguous for b in out):
        blocks = list(out)
    else:
        blocks = [np.empty(shape, order="F") for shape in shapes]
    for block in blocks:
        block[:, block.shape[1] - extra :] = 0.0
    return blocks


def predict(tree: RigidTree, base: BaseParameters, axes_from_joints: Array, motion: Motion, phi_base: Array) -> Array:
    """(T, rows): the inverse dynamics of the body whose kept parameters are phi_base and the others zero."""
    phi = np.zeros(10 * len(tree.bodies))
    phi[base.columns] = phi_base
    rows = inverse_dynamics(tree, motion, phi.reshape(-1, 10))
    joints = rows[:, -len(tree.joints) :] if tree.joints else rows[:, :0]
    joints[...] = joints @ np.linalg.inv(axes_from_joints)  # rows of (C⁻ᵀ τ)ᵀ
    return rows


def _mass_columns(layout: RowLayout, sweep: Sweep) -> Array:
    """(6, K_1, T) force and moment about the base origin, base frame, per mass [kg] or first moment [kg·m]."""
    n, samples = sweep.p.shape[0], sweep.p.shape[2]
    w, dw, b, p, R = sweep.omega, sweep.alpha, sweep.b, sweep.p, sweep.R
    B = w[:, :, None] * w[:, None]  # [α]× + [ω]×², with [ω]×² = ω ωᵀ − |ω|² 1
    size = B[:, 0, 0] + B[:, 1, 1] + B[:, 2, 2]
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        B[:, x, x] -= size
        B[:, y, x] += dw[:, z]
        B[:, x, y] -= dw[:, z]
    columns = np.empty((6, n, 4, samples))
    for x in range(3):
        columns[x, :, 0] = b[:, x]
        np.einsum("njt,njkt->nkt", B[:, x], R, out=columns[x, :, 1:])
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # p x f, and for first moments h x b
        moment = columns[3 + x]
        np.multiply(p[:, y, None], columns[z], out=moment)
        moment -= p[:, z, None] * columns[y]
        moment[:, 1:] += R[:, y] * b[:, z, None]
        moment[:, 1:] -= R[:, z] * b[:, y, None]
    chosen: Array = np.take(columns.reshape(6, 4 * n, samples), layout.mass_standard, axis=1)
    return chosen


def _inertia_columns(layout: RowLayout, sweep: Sweep) -> Array:
    """(3, K_2, T) moment, base frame, per entry of the inertia about the body's origin [kg·m²].

    With r_k the axes of the body: entry (k, l) moves as r_k α_l + (ω x r_k) ω_l, plus the same with k and l exchanged.
    """
    n, samples = sweep.p.shape[0], sweep.p.shape[2]
    R, w = sweep.R, sweep.omega
    rates = np.empty((n, 2, 3, samples))  # in the body frame
    np.einsum("njkt,njt->nkt", R, sweep.alpha, out=rates[:, 0])
    np.einsum("njkt,njt->nkt", R, w, out=rates[:, 1])
    axes = np.empty((n, 2, 3, samples))
    columns = np.empty((3, n, 6, samples))
    outer = np.empty((n, 3, 3, samples))
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        axes[:, 0] = R[:, x]
        np.multiply(w[:, y, None], R[:, z], out=axes[:, 1])
        axes[:, 1] -= w[:, z, None] * R[:, y]
        np.einsum("nskt,nslt->nklt", axes, rates, out=outer)
        for place, k in ((0, 0), (2, 1), (5, 2)):
            columns[x, :, place] = outer[:, k, k]
        for place, k, l in ((1, 0, 1), (3, 0, 2), (4, 1, 2)):  # noqa: E741 (entry k, l)
            np.add(outer[:, k, l], outer[:, l, k], out=columns[x, :, place])
    chosen: Array = np.take(columns.reshape(3, 6 * n, samples), layout.inertia_standard, axis=1)
    return chosen


def _combined(sweep: Sweep, bodies: Sequence[int], weights: Sequence[float]) -> Array:
    """(6, T) weighted sum of joint motions."""
    if len(bodies) == 1 and weights[0] == 1.0:
        return sweep.S[bodies[0]]
    total: Array = np.einsum("b,brt->rt", np.array(weights), sweep.S[list(bodies)])
    return total
