"""The regressor row by row, only where it is not zero, for many samples at once: the fast path of identification.

One block per equation: six base rows when floating, then one row per actuator axis. A base force row has columns for
masses and first moments only, an axis row for the bodies its joints carry only. With axes a = C q an axis torque is
C⁻ᵀ times the joint torques.

Each body's columns are computed once, as force and moment about the base origin in the base frame; a joint row is then
the joint's motion (a six-vector) times those columns in its subtree.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.base_parameters import BaseParameters
from exogauge.robots.kinematics import Kinematics, Sweep
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import inverse_dynamics
from exogauge.robots.row_layout import RowLayout, Segment
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]

SLICE = 8000  # bodies times samples at once in NumPy: their columns stay in the cache


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
    """The reference, in NumPy. Threads may share it."""

    def __init__(self, tree: RigidTree, base: BaseParameters, axes_from_joints: Array) -> None:
        self.tree, self.base, self.axes_from_joints = tree, base, axes_from_joints
        self.layout = RowLayout.of(tree, base, axes_from_joints)
        self.columns = self.layout.columns
        self.kinematics = Kinematics(tree)

    def fill(self, motion: Motion, extra: int = 0, out: Sequence[Array] | None = None) -> list[Array]:
        """See `Rows.fill`."""
        blocks = ready_blocks(self.columns, motion.samples, extra, out)
        size = max(100, SLICE // max(len(self.tree.bodies), 1))
        for start in range(0, motion.samples, size):
            part = slice(start, start + size)
            self._fill_slice(motion.rows(part), [block.T[:, part] for block in blocks])
        return blocks

    def _fill_slice(self, motion: Motion, blocks: list[Array]) -> None:
        """blocks: per row (k_r + extra, T), time last."""
        layout, sweep = self.layout, self.kinematics.sweep(motion)
        mass = mass_columns(layout.mass_standard, sweep)
        inertia = inertia_columns(layout.inertia_standard, sweep)
        first_axis = 6 if self.tree.floating else 0
        k_1, k_2 = len(layout.mass), len(layout.inertia)
        for row in range(first_axis):
            blocks[row][:k_1] = mass[row]
            if row >= 3:
                blocks[row][k_1 : k_1 + k_2] = inertia[row - 3]
        for axis, rows in enumerate(blocks[first_axis:]):
            for segment in layout.mass_segments[axis]:
                _project(_combined(sweep, segment), mass, segment, rows)
            for segment in layout.inertia_segments[axis]:
                _project(_combined(sweep, segment)[3:], inertia, segment, rows)

    def predict(self, motion: Motion, phi_base: Array) -> Array:
        """See `Rows.predict`."""
        return predict(self.tree, self.base, self.axes_from_joints, motion, phi_base)


def ready_blocks(
    columns: Sequence[IntArray], samples: int, extra: int, out: Sequence[Array] | None = None
) -> list[Array]:
    """Blocks (T, k_r + extra), Fortran order, one array behind all; extra columns zero; `out` itself where it fits."""
    blocks: list[Array] = []
    last = np.cumsum([0, *(len(c) + extra for c in columns)])
    whole = buffer_of(out) if out else None
    if whole is None or whole.shape != (last[-1], samples):
        whole = np.empty((last[-1], samples))
    elif out is not None and [block.shape[1] for block in out] == np.diff(last).tolist():
        blocks = list(out)
    if not blocks:
        blocks = [whole[i:j].T for i, j in itertools.pairwise(last)]
    for block in blocks:
        block[:, block.shape[1] - extra :] = 0.0
    return blocks


def buffer_of(blocks: Sequence[Array]) -> Array | None:
    """(rows of all blocks, T) the array that blocks from `ready_blocks` share, time last; None for any others."""
    whole = blocks[0].base if blocks else None
    if not isinstance(whole, np.ndarray) or whole.ndim != 2 or not whole.flags.c_contiguous:
        return None
    return whole if all(block.base is whole for block in blocks) else None


def predict(tree: RigidTree, base: BaseParameters, axes_from_joints: Array, motion: Motion, phi_base: Array) -> Array:
    """(T, rows): the inverse dynamics of the body whose kept parameters are phi_base and the others zero."""
    phi = np.zeros(10 * len(tree.bodies))
    phi[base.columns] = phi_base
    rows = inverse_dynamics(tree, motion, phi.reshape(-1, 10))
    joints = rows[:, -len(tree.joints) :] if tree.joints else rows[:, :0]
    joints[...] = joints @ np.linalg.inv(axes_from_joints)  # rows of (C⁻ᵀ τ)ᵀ
    return rows


def mass_columns(chosen: IntArray, sweep: Sweep) -> Array:
    """(6, K_1, T) force and moment about the base origin, base frame, per mass [kg] or first moment [kg·m].

    chosen: (K_1,) body · 4 + 0..3."""
    n, samples = sweep.p.shape[0], sweep.p.shape[2]
    b, p, R, B = sweep.b, sweep.p, sweep.R, sweep.B
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
    return np.take(columns.reshape(6, 4 * n, samples), chosen, axis=1)


def inertia_columns(chosen: IntArray, sweep: Sweep) -> Array:
    """(3, K_2, T) moment, base frame, per entry of the inertia about the body's origin [kg·m²].

    chosen: (K_2,) body · 6 + 0..5.
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
    return np.take(columns.reshape(3, 6 * n, samples), chosen, axis=1)


def _combined(sweep: Sweep, segment: Segment) -> Array:
    """(6, T) weighted sum of the joint motions of a segment."""
    if segment.weights == (1.0,):
        single: Array = sweep.S[segment.bodies[0]]
        return single
    total: Array = np.einsum("b,brt->rt", np.array(segment.weights), sweep.S[list(segment.bodies)])
    return total


def _project(S: Array, columns: Array, segment: Segment, rows: Array) -> None:
    """rows of the segment: S (C, T) times its columns (C, K, T)."""
    out = rows[segment.start : segment.start + segment.last - segment.first]
    np.einsum("ct,ckt->kt", S, columns[:, segment.first : segment.last], out=out)
