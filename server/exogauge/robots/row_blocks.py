"""The regressor row by row, only where it is not zero, for many samples at once: the fast path of identification.

One block per equation: six base rows when floating, then one row per actuator axis. A base force row has columns for
masses and first moments only, an axis row for the bodies its joints carry only. With axes a = C q an axis torque is
C⁻ᵀ times the joint torques.

Each body's columns are computed once, as force and moment about the base origin in the base frame; a joint row is then
the joint's motion (a six-vector) times those columns in its subtree.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import BaseParameters
from exogauge.robots.rows import RowLayout
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
TreeArrays: TypeAlias = tuple[Ints, Ints, NDArray[np.bool_], Array, Array, Array, Array, Array, Array]

AXES = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1]])  # x, the next, the one after
ENTRIES = np.array([[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]])  # Ixx, Ixy, Iyy, Ixz, Iyz, Izz


@final
class RowBlocks:
    """base: the parameters of the columns. columns: per row r (k_r,), which of them its block has.

    Threads may share it.
    """

    def __init__(self, tree: RigidTree, base: BaseParameters, axes_from_joints: Array) -> None:
        self.tree, self.base, self.axes_from_joints = tree, base, axes_from_joints
        self.layout = layout = BlockColumns.of(tree, base, axes_from_joints)
        self.columns = layout.columns
        self._tree, n = tree_arrays(Kinematics(tree)), len(tree.bodies)
        self._kept = (
            np.searchsorted(layout.mass_standard, 4 * np.arange(n + 1)).astype(np.int64),
            (layout.mass_standard % 4).astype(np.int64),
            np.searchsorted(layout.inertia_standard, 6 * np.arange(n + 1)).astype(np.int64),
            (layout.inertia_standard % 6).astype(np.int64),
        )
        rows = RowLayout.of(tree.floating, len(tree.joints), 0)
        whole: list[tuple[int, ...]] = []  # row, inertia-like?, first, last, start, first mover, last mover
        bodies: list[int] = []
        weights: list[float] = []
        for inertia, of_rows in enumerate((layout.mass_segments, layout.inertia_segments)):
            for axis, segments in enumerate(of_rows):
                for s in segments:
                    movers = (len(bodies), len(bodies) + len(s.bodies))
                    whole.append((rows.axis(axis), inertia, s.first, s.last, s.start, *movers))
                    bodies += s.bodies
                    weights += s.weights
        self._segments = (
            np.array(whole, dtype=np.int64).reshape(-1, 7),
            np.array(bodies, dtype=np.int64),
            np.array(weights, dtype=np.float64),
        )

    def fill(self, motion: Motion, extra: int = 0, out: Sequence[Array] | None = None) -> list[Array]:
        """Per row a block (T, k_r + extra), Fortran order (time contiguous): regressor columns, then `extra` zeros.

        Accumulate with `scipy.linalg.blas.dsyrk(1.0, block, trans=1, beta=1.0, c=gram, overwrite_c=1)`, no copy.
        out: blocks of an earlier call, overwritten if their shape fits, which saves page faults.
        """
        blocks = ready_blocks(self.columns, motion.samples, extra, out)
        whole = buffer_of(blocks)
        if whole is None or not motion.samples:
            return blocks
        from exogauge.loops.rows import fill_rows

        first = np.cumsum([0, *(block.shape[1] for block in blocks)], dtype=np.int64)
        swept = Swept.of(motion)
        fill_rows(self.tree.floating, *self._tree, *self._kept, *self._segments,
                  swept.signals, swept.base, AXES, ENTRIES, first, whole)  # fmt: skip
        return blocks


def tree_arrays(of: Kinematics) -> TreeArrays:
    """What the compiled sweep takes: parent, dof (J for none), which slide, and the constants of each body's joint."""
    tree, n = of.tree, len(of.tree.bodies)
    dof = np.where(tree.dof >= 0, tree.dof, len(tree.joints)).astype(np.int64)
    E_0, E_c, E_s = (each.reshape(n, 9) for each in (of.E_0, of.E_c, of.E_s))
    fixed = of.axis_in_parent, of.p_before, of.offset_in_body
    return tree.parent.astype(np.int64), dof, tree.prismatic, E_0, E_c, E_s, *fixed


@final
@dataclass(frozen=True)
class Swept:
    """What the compiled sweeps take of a motion. signals: (5, J + 1, T) q, cos q, sin q, dq, ddq, the last joint that
    of bodies without one. base: (9, T) acc, gyro, gyro_dot."""

    signals: Array
    base: Array

    @classmethod
    def of(cls, motion: Motion) -> Swept:
        base = np.concatenate([motion.acc.T, motion.gyro.T, motion.gyro_dot.T])
        signals = np.zeros((5, motion.q.shape[1] + 1, len(motion.q)))
        for place, x in ((0, motion.q), (3, motion.dq), (4, motion.ddq)):
            signals[place, :-1] = x.T
        np.cos(signals[0], out=signals[1])
        np.sin(signals[0], out=signals[2])
        return cls(signals, np.asfortranarray(base))  # as it is compiled for

    def with_joint(self, joint: int, more: Array) -> Swept:
        """The same but for one joint: more (3, T) is added to its position, its rate and the rate of that."""
        signals = self.signals.copy()
        own = signals[:, joint]
        own[[0, 3, 4]] += more
        np.cos(own[0], out=own[1])
        np.sin(own[0], out=own[2])
        return Swept(signals, self.base)

    @property
    def samples(self) -> int:
        return int(self.base.shape[1])

    @property
    def q(self) -> Array:
        """(T, J)."""
        return np.ascontiguousarray(self.signals[0, :-1].T)


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


@final
@dataclass(frozen=True)
class Segment:
    """Neighbouring columns of an axis row that the same joints carry.

    first, last: of the mass-like or of the inertia-like columns. start: their place in the row's block.
    bodies, weights: bodies whose joint motions add up there, and their weights, entries of C⁻ᵀ.
    """

    first: int
    last: int
    start: int
    bodies: tuple[int, ...]
    weights: tuple[float, ...]


@final
@dataclass(frozen=True)
class BlockColumns:
    """K_1 mass-like columns (m, mx, my, mz) and K_2 inertia-like ones, both in the order of the bodies.

    mass, inertia: (K_1,), (K_2,) their places among the base parameters. mass_standard: (K_1,) body · 4 + 0..3.
    inertia_standard: (K_2,) body · 6 + 0..5. mass_segments, inertia_segments: per axis row.
    columns: per row, base rows first, the base parameters of its block: mass-like, then inertia-like.
    """

    mass: IntArray
    inertia: IntArray
    mass_standard: IntArray
    inertia_standard: IntArray
    mass_segments: tuple[tuple[Segment, ...], ...]
    inertia_segments: tuple[tuple[Segment, ...], ...]
    columns: tuple[IntArray, ...]

    @classmethod
    def of(cls, tree: RigidTree, base: BaseParameters, axes_from_joints: Array) -> BlockColumns:
        """axes_from_joints: (J, J) C; an axis row is the same row of C⁻ᵀ times the joint rows."""
        body, kind = np.divmod(base.columns, 10)
        mass, inertia = np.flatnonzero(kind < 4), np.flatnonzero(kind >= 4)
        moved = np.flatnonzero(tree.dof >= 0)
        body_of_joint = np.empty(len(tree.joints), dtype=np.intp)
        body_of_joint[tree.dof[moved]] = moved
        carried = tree.subtree
        columns = [mass] * 3 + [np.concatenate([mass, inertia])] * 3 if tree.floating else []
        mass_segments, inertia_segments = [], []
        for weights in np.linalg.inv(axes_from_joints).T:
            joints = np.flatnonzero(np.abs(weights) > 1e-14 * np.abs(weights).max())
            weight_of = {int(body_of_joint[j]): float(weights[j]) for j in joints}
            first, chosen = _segments(carried, body[mass], weight_of, 0)
            then, chosen_inertia = _segments(carried, body[inertia], weight_of, len(chosen))
            mass_segments.append(first)
            inertia_segments.append(then)
            columns.append(np.concatenate([mass[chosen], inertia[chosen_inertia]]))
        return cls(
            mass=mass,
            inertia=inertia,
            mass_standard=body[mass] * 4 + kind[mass],
            inertia_standard=body[inertia] * 6 + kind[inertia] - 4,
            mass_segments=tuple(mass_segments),
            inertia_segments=tuple(inertia_segments),
            columns=tuple(columns),
        )


def _segments(
    carried: NDArray[np.bool_], body: IntArray, weight_of: Mapping[int, float], start: int
) -> tuple[tuple[Segment, ...], IntArray]:
    """The segments of one row, and the columns in them. body: (K,) that each column belongs to."""
    above = [tuple(mover for mover in weight_of if carried[mover, b]) for b in body]
    chosen = np.flatnonzero([bool(movers) for movers in above])
    segments: list[Segment] = []
    for place, k in enumerate(chosen, start):
        last = segments[-1] if segments else None
        if last and last.last == k and last.bodies == above[k]:
            segments[-1] = Segment(last.first, int(k) + 1, last.start, last.bodies, last.weights)
        else:
            weights = tuple(weight_of[mover] for mover in above[k])
            segments.append(Segment(int(k), int(k) + 1, place, above[k], weights))
    return tuple(segments), chosen


@final
class BodyLoads:
    """By the same sweep as `RowBlocks`, of whose columns only the sum is wanted. Threads may share it."""

    def __init__(
        self, tree: RigidTree, columns: IntArray, axes_from_joints: Array, sensor_frames: Sequence[str]
    ) -> None:
        """columns: (B,) places of the parameters that are given, among all standard ones."""
        self._columns, self._floating, self._joints = columns, tree.floating, len(tree.joints)
        self._bodies, self._to_axes = len(tree.bodies), np.asarray(np.linalg.inv(axes_from_joints).T)  # C⁻ᵀ
        self._mixed = not np.array_equal(self._to_axes, np.eye(self._joints))
        self._tree = tree_arrays(Kinematics(tree))
        places = [tree.frames[frame] for frame in sensor_frames]
        self._sensors: tuple[NDArray[np.bool_], NDArray[np.int64], Array, Array] = (
            np.array([np.isin(np.arange(self._bodies), tree.cuts[frame]) for frame in sensor_frames], dtype=np.bool_)
            .reshape(-1, self._bodies),
            np.array([body for body, _ in places], dtype=np.int64),
            np.array([pose.rotation for _, pose in places]).reshape(-1, 9),
            np.array([pose.translation for _, pose in places]).reshape(-1, 3),
        )  # fmt: skip

    def of(self, motion: Motion | Swept, phi: Array) -> Array:
        """(L, rows, T) of each of L parameter sets: six base rows when floating, actuator axes, six for each sensor.

        phi: (B, L).
        """
        from exogauge.loops.loads import fill_loads

        standard = np.zeros((10 * self._bodies, phi.shape[1]))
        standard[self._columns] = phi
        sets = np.ascontiguousarray(standard.T).reshape(-1, self._bodies, 10)
        live: NDArray[np.bool_] = np.any(sets != 0.0, axis=2)
        out = np.empty((len(sets), 6 + self._joints + 6 * len(self._sensors[0]), motion.samples))
        if motion.samples:
            swept = motion if isinstance(motion, Swept) else Swept.of(motion)
            fill_loads(*self._tree, sets, live, *self._sensors, swept.signals, swept.base, AXES, out)
        if self._mixed:
            joints = out[:, 6 : 6 + self._joints]
            joints[:] = self._to_axes @ joints
        return out if self._floating else out[:, 6:]
