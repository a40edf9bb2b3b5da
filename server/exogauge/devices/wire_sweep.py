"""Segments of a wire one by one and their Jacobians, outward over the joints between the via points.

Arrays have the component first and time last, so that every product runs over whole rows.
"""

from __future__ import annotations

from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.wire_layout import REST, WireLayout

Array = NDArray[np.float64]

SLICE = 90_000  # joints, points and segments times samples at once: what they hold stays in the cache
TINY = 1e-150  # [m] stands in for the length of a segment that has none: its direction is then 0, not NaN


def slices(layout: WireLayout, samples: int) -> list[slice]:
    """Neighbouring parts of the samples, alike in size, each small enough for the cache."""
    held = 4 * len(layout.dof) + 2 * len(layout.point) + 3 * len(layout.wire) + 2 * len(layout.pair_wire)
    count = -(-samples // max(100, SLICE // max(held, 1)))
    ends = np.linspace(0, samples, count + 1).astype(int)
    return [slice(start, end) for start, end in pairwise(ends)]


@final
class WireSweep:
    """T samples. length: (S, T) [m]. direction: (3, S, T) unit vectors from start to end, 0 where the length is 0."""

    def __init__(self, layout: WireLayout, q: Array) -> None:
        self.layout = layout
        self._move(np.ascontiguousarray(q.T[layout.dof]))
        point = self._points()
        self._start = point[:, layout.start]
        self.direction = point[:, layout.end]
        self.direction -= self._start
        self.length: Array = np.sqrt(np.einsum("xst,xst->st", self.direction, self.direction))
        self.direction /= np.maximum(self.length, TINY)

    def slopes(self) -> Array:
        """(K, T) change of a wire's length with a joint's position, pair by pair.

        A joint that carries a segment's end moves it by S · [e; p x e], one that carries its start by the opposite; the
        line [e; p x e] is the same at both ends.
        """
        layout, e = self.layout, self.direction
        line = np.concatenate([e, _cross(self._start, e)])
        pulled = np.matmul(layout.carried, line)
        motion = np.concatenate([_cross(self._place, self._axis), self._axis])
        slides = layout.prismatic
        motion[:3, slides], motion[3:, slides] = self._axis[:, slides], 0.0
        slopes: Array = np.einsum("xkt,xkt->kt", pulled, motion[:, layout.pair_joint])
        return slopes

    def _move(self, q: Array) -> None:
        """R: D times (3, 3, T). place, axis: (3, D, T) the joint's position [m] and axis. q: (D, T)."""
        layout, joints, samples = self.layout, *q.shape
        cos, sin = np.cos(q), np.sin(q)
        self._R: list[Array] = []
        self._place, self._axis = np.empty((3, joints, samples)), np.empty((3, joints, samples))
        for k, up in enumerate(layout.parent):
            E = layout.E_c[k, :, :, None] * cos[k]
            E += layout.E_s[k, :, :, None] * sin[k]
            E += layout.E_0[k, :, :, None]
            place, axis = self._place[:, k], self._axis[:, k]
            if up == REST:
                self._R.append(E)
                place[:], axis[:] = layout.before[k, :, None], layout.axis[k, :, None]
            else:
                above = self._R[up]
                self._R.append(np.einsum("ikt,kjt->ijt", above, E))
                np.einsum("ijt,j->it", above, layout.before[k], out=place)
                np.einsum("ijt,j->it", above, layout.axis[k], out=axis)
                place += self._place[:, up]
            if layout.prismatic[k]:
                place += axis * q[k]

    def _points(self) -> Array:
        """(3, P, T) [m] the via points."""
        layout = self.layout
        point = np.empty((3, len(layout.point), self._place.shape[2]))
        for k in np.unique(layout.point_joint):
            of_joint = layout.point_joint == k
            x = layout.point[of_joint]
            if k == REST:
                point[:, of_joint] = x.T[:, :, None]
            else:
                point[:, of_joint] = np.matmul(x, self._R[k]) + self._place[:, k, None]
        return point


def _cross(u: Array, v: Array) -> Array:
    """(3, N, T) along axis 0."""
    out = np.empty_like(v)
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(u[y], v[z], out=out[x])
        out[x] -= u[z] * v[y]
    return out
