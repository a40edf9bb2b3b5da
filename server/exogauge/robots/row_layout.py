"""Which base-parameter columns each equation has: the structure of the regressor's zeros, found once per robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.base_parameters import BaseParameters
from exogauge.robots.kinematics import subtree
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]


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
class RowLayout:
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
    def of(cls, tree: RigidTree, base: BaseParameters, axes_from_joints: Array) -> RowLayout:
        """axes_from_joints: (J, J) C; an axis row is the same row of C⁻ᵀ times the joint rows."""
        body, kind = np.divmod(base.columns, 10)
        mass, inertia = np.flatnonzero(kind < 4), np.flatnonzero(kind >= 4)
        moved = np.flatnonzero(tree.dof >= 0)
        body_of_joint = np.empty(len(tree.joints), dtype=np.intp)
        body_of_joint[tree.dof[moved]] = moved
        carried = subtree(tree)
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
