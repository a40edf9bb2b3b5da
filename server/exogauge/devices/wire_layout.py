"""What of a robot its bands move, found once: joints, via points, segments, and which joint bends which band.

Segments of a wire one by one and their Jacobians, outward over the joints between the via points.

Arrays have the component first and time last, so that every product runs over whole rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band
from exogauge.errors import BadInput, Fault
from exogauge.robots.kinematics import Kinematics, cross
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]

REST = -1  # a body that nothing below moves


@final
@dataclass(frozen=True)
class ViaPlace:
    """A via point on the tree. body: index, -1 = fixed base. xyz: (3,) [m] in that body's frame."""

    body: int
    xyz: Array


@final
@dataclass(frozen=True)
class WireLayout:
    """D joints that lie between via points, parents first; P via points; S segments of W wires; K pairs (wire, joint).

    Only those joints move: a body whose own joint is none of them rests, its frame is the origin of all it carries.
    A joint's frame stands at the joint, turned as its body.

    columns: (D,) into q, rising. dof: (D,) column in q of each joint. parent: (D,) joint that carries it, or REST.
    E_0, E_c, E_s: (D, 3, 3) R_parent_joint(q) = E_0 + E_c cos q + E_s sin q. before, axis: (D, 3) the joint's place [m]
    and unit axis in its parent's frame. prismatic: (D,) bool.
    point_joint, point: (P,), (P, 3) the joint's frame or REST, and the point in it [m]; points of a joint together.
    start, end, wire: (S,) the points a segment joins and the wire it is part of.
    constant: (W,) [m] length of the segments that lie on one body, which are none of the S.
    pair_wire, pair_joint, pair_column: (K,) each wire with each joint it passes; column: into `columns`.
    carried: (K, S) +1 where the joint moves the segment's end, -1 where it moves its start, 0 where both or none.
    """

    columns: IntArray
    dof: IntArray
    parent: IntArray
    E_0: Array
    E_c: Array
    E_s: Array
    before: Array
    axis: Array
    prismatic: NDArray[np.bool_]
    point_joint: IntArray
    point: Array
    start: IntArray
    end: IntArray
    wire: IntArray
    constant: Array
    pair_wire: IntArray
    pair_joint: IntArray
    pair_column: IntArray
    carried: Array

    @classmethod
    def of(cls, tree: RigidTree, wires: Sequence[Sequence[ViaPlace]], *, all_segments: bool = False) -> WireLayout:
        """wires: their via points in order, two or more each. all_segments: those on one body are among the S too."""
        constant = np.zeros(len(wires))
        segments: list[tuple[int, ViaPlace, ViaPlace]] = []
        for w, via in enumerate(wires):
            for a, b in pairwise(via):
                if a.body == b.body and not all_segments:
                    constant[w] += np.linalg.norm(b.xyz - a.xyz)
                else:
                    segments.append((w, a, b))
        paths = [_between(tree, a.body, b.body) for _, a, b in segments]
        moved = sorted({body for path in paths for body in path})  # parents come first in a tree
        local = {body: k for k, body in enumerate(moved)}

        kinematics = Kinematics(tree)
        up = tree.parent[moved]
        offset = np.vstack([kinematics.offset_in_body, np.zeros(3)])  # of a joint's frame to its body's; -1: the base
        from_joint = [offset[u] * (u in local) for u in up]
        points, (start, end) = _distinct((a for _, a, _ in segments), (b for _, _, b in segments))
        columns = np.sort(tree.dof[moved])
        pairs = sorted({(w, local[body]) for (w, _, _), path in zip(segments, paths, strict=True) for body in path})
        carried = np.zeros((len(pairs), len(segments)))
        row = {pair: k for k, pair in enumerate(pairs)}
        for s, ((w, _, _), path) in enumerate(zip(segments, paths, strict=True)):
            for body, sign in path.items():
                carried[row[w, local[body]], s] = sign
        pair_wire, pair_joint = _ints(pairs).reshape(-1, 2).T
        dof = tree.dof[moved]
        return cls(
            columns=columns,
            dof=dof,
            parent=_ints([local.get(u, REST) for u in up]),
            E_0=kinematics.E_0[moved],
            E_c=kinematics.E_c[moved],
            E_s=kinematics.E_s[moved],
            before=kinematics.p_before[moved] + np.reshape(from_joint, (-1, 3)),
            axis=kinematics.axis_in_parent[moved],
            prismatic=tree.prismatic[moved],
            point_joint=_ints([local.get(p.body, REST) for p in points]),
            point=np.reshape([p.xyz + offset[p.body] * (p.body in local) for p in points], (-1, 3)),
            start=start,
            end=end,
            wire=_ints([w for w, _, _ in segments]),
            constant=constant,
            pair_wire=pair_wire,
            pair_joint=pair_joint,
            pair_column=np.searchsorted(columns, dof[pair_joint]),
            carried=carried,
        )


def places(tree: RigidTree, bands: Iterable[Band]) -> tuple[tuple[ViaPlace, ...], ...]:
    """Per band, its via points on the tree. Raises BadInput where a link is unknown or a band too short."""
    faults: list[Fault] = []
    found: list[tuple[ViaPlace, ...]] = []
    for band in bands:
        if len(band.via_points) < 2:
            advice = "Give two or more via points, in the order in which the band passes them"
            faults.append(Fault(f"band {band.name!r} has fewer than two via points", "band_too_short", advice,
                                value=band.name))  # fmt: skip
        unknown = dict.fromkeys(via.link for via in band.via_points if via.link not in tree.frames)
        for link in unknown:
            close = get_close_matches(link, list(tree.frames), n=1)
            advice = f"Did you mean {close[0]!r}?" if close else "Name a link or fixed joint of the URDF"
            faults.append(Fault(f"band {band.name!r} passes {link!r}, which the robot does not have", "link_unknown",
                                advice, value=link[:80]))  # fmt: skip
        if not unknown:
            poses = [(*tree.frames[via.link], via.xyz) for via in band.via_points]
            found.append(tuple(ViaPlace(body, T.act(np.array(xyz, dtype=np.float64))) for body, T, xyz in poses))
    if faults:
        raise BadInput(faults)
    return tuple(found)


def _between(tree: RigidTree, a: int, b: int) -> dict[int, float]:
    """Bodies whose joints lie between bodies a and b; +1 where the joint carries b, -1 where it carries a."""

    def inward(body: int) -> list[int]:
        way = []
        while body >= 0:
            way.append(body)
            body = int(tree.parent[body])
        return way

    to_a, to_b = inward(a), inward(b)
    signs = {body: -1.0 for body in to_a if body not in to_b} | {body: 1.0 for body in to_b if body not in to_a}
    return {body: sign for body, sign in signs.items() if tree.dof[body] >= 0}


def _distinct(*ends: Iterable[ViaPlace]) -> tuple[list[ViaPlace], list[IntArray]]:
    """Every place once, by body, and where each of the given ones is among them."""
    lists = [[(p.body, *p.xyz) for p in places] for places in ends]
    keys = sorted({key for keys in lists for key in keys})
    index = {key: i for i, key in enumerate(keys)}
    return [ViaPlace(int(key[0]), np.array(key[1:])) for key in keys], [_ints([index[k] for k in ks]) for ks in lists]


def _ints(values: Sequence[int] | Sequence[tuple[int, int]]) -> IntArray:
    return np.array(values, dtype=np.intp)


SLICE = 90_000  # joints, points and segments times samples at once: what they hold stays in the cache


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
        tiny = 1e-150  # [m] stands in for the length of a segment that has none: its direction is then 0, not NaN
        self.layout = layout
        self._move(np.ascontiguousarray(q.T[layout.dof]))
        point = self._points()
        self._start = point[:, layout.start]
        self.direction = point[:, layout.end]
        self.direction -= self._start
        self.length: Array = np.sqrt(np.einsum("xst,xst->st", self.direction, self.direction))
        self.direction /= np.maximum(self.length, tiny)

    def slopes(self) -> Array:
        """(K, T) change of a wire's length with a joint's position, pair by pair.

        A joint that carries a segment's end moves it by S · [e; p x e], one that carries its start by the opposite; the
        line [e; p x e] is the same at both ends.
        """
        layout, e = self.layout, self.direction
        line = np.concatenate([e, cross(self._start, e, axis=0)])
        pulled = np.matmul(layout.carried, line)
        motion = np.concatenate([cross(self._place, self._axis, axis=0), self._axis])
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
