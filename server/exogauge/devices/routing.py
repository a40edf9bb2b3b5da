"""How long each band is and what a joint does to its length, for all samples at once.

Only the joints between a band's via points matter: base pose, base velocity and every other joint leave its length as
it is. So those joints alone are moved, from frames that stand still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band
from exogauge.devices.wire_layout import WireLayout, places
from exogauge.devices.wire_sweep import WireSweep, slices
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]

CHUNK = 8192  # samples whose sines are held at once
AXES = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1]])  # x, the next, the one after


@final
@dataclass(frozen=True)
class Geometry:
    """W bands, D joints (`Routing.columns`); time contiguous in both.

    length: (T, W) [m]. jacobian: (T, W, D) [m/rad, or 1 for a prismatic joint] change of the length with the joint's
    position, 0 for joints that a band does not pass.
    """

    length: Array
    jacobian: Array


@final
@dataclass(frozen=True)
class SegmentGeometry:
    """The S straight segments of one band in order; D joints as in `Geometry`; time contiguous.

    length: (T, S) [m]. jacobian: (T, S, D) [m/rad or 1]. wrap: (T, S-1) [rad] by how much the band turns at each via
    point between its ends, 0 next to a segment without length.
    """

    length: Array
    jacobian: Array
    wrap: Array


@final
class Routing:
    """The bands of a device on a robot. Threads may share it.

    columns: (D,) into q, rising, of the joints that lie between two neighbouring via points of any band, whatever the
    posture; joints: (D,) their names.
    Raises BadInput where a band names a link that the tree does not have, or has fewer than two via points.
    """

    def __init__(self, tree: RigidTree, bands: Sequence[Band]) -> None:
        self.tree, self.bands = tree, tuple(bands)
        self._places = places(tree, self.bands)
        self._layout = WireLayout.of(tree, self._places)
        self.columns: IntArray = self._layout.columns
        self.joints: tuple[str, ...] = tuple(tree.joints[column] for column in self.columns)

    def geometry(self, q: Array) -> Geometry:
        """Lengths and their Jacobians. q: (T, J) [rad or m].

        A segment without length has no direction; its part of the Jacobian is 0.

        Implements [Evaluator] (22), (23), (24).
        """
        length = np.empty((len(self.bands), len(q)))
        jacobian = np.zeros((len(self.bands), len(self.columns), len(q)))
        _measure(self._layout, q, length, jacobian)
        return Geometry(length.T, jacobian.transpose(2, 0, 1))

    def lengths(self, q: Array) -> Array:
        """(T, W) [m]. q: (T, J) [rad or m].

        Implements [Evaluator] (23), (24).
        """
        length = np.empty((len(self.bands), len(q)))
        _measure(self._layout, q, length, None)
        return length.T

    def segments(self, q: Array, band_index: int) -> SegmentGeometry:
        """One band segment by segment, for what rubs at its via points. q: (T, J) [rad or m]."""
        wires = list(pairwise(self._places[band_index]))
        layout = WireLayout.of(self.tree, wires, all_segments=True)
        column = np.searchsorted(self.columns, layout.columns)[layout.pair_column]
        length = np.empty((len(wires), len(q)))
        jacobian = np.zeros((len(wires), len(self.columns), len(q)))
        wrap = np.empty((len(wires) - 1, len(q)))
        for part in slices(layout, len(q)):
            sweep = WireSweep(layout, q[part])
            length[:, part] = sweep.length
            jacobian[layout.pair_wire, column, part] = sweep.slopes()
            e = sweep.direction
            turned = np.linalg.norm(np.cross(e[:, :-1], e[:, 1:], axis=0), axis=0)
            wrap[:, part] = np.arctan2(turned, np.einsum("xst,xst->st", e[:, :-1], e[:, 1:]))
        return SegmentGeometry(length.T, jacobian.transpose(2, 0, 1), wrap.T)


def _measure(layout: WireLayout, q: Array, length: Array, jacobian: Array | None) -> None:
    """Fills length (W, T) [m], and jacobian (W, D, T) where asked for, which comes filled with zeros. q: (T, J)."""
    from exogauge.loops.wires import measure_wires

    slopes = np.empty((0, 0, len(q))) if jacobian is None else jacobian
    joints = len(layout.dof)
    for start in range(0, len(q), CHUNK):
        part = slice(start, start + CHUNK)
        angle = np.ascontiguousarray(q[part].T[layout.dof], dtype=np.float64)
        measure_wires(
            layout.parent, layout.prismatic,
            layout.E_0.reshape(joints, 9), layout.E_c.reshape(joints, 9), layout.E_s.reshape(joints, 9),
            layout.before, layout.axis, layout.point_joint, layout.point,
            layout.start, layout.end, layout.wire, layout.constant,
            layout.pair_wire, layout.pair_joint, layout.pair_column, layout.carried,
            np.stack([angle, np.cos(angle), np.sin(angle)]), AXES, start, length, slopes,
        )  # fmt: skip
