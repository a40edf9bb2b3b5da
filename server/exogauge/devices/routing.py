"""How long each band is and what a joint does to its length, for all samples at once.

Only the joints between a band's via points matter: base pose, base velocity and every other joint leave its length as
it is. So those joints alone are moved, from frames that stand still.

Whether a changed routing is one: links that exist, segments that have a length, joints to act on.

The same rules, in the same words, as for a device file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import DEVICES
from exogauge.devices.device import Band, ViaPoint
from exogauge.devices.posture import Posture
from exogauge.devices.wire_layout import WireLayout, WireSweep, places, slices
from exogauge.errors import BadInput, Fault
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


SHOWN_LINKS = 30


def check_routing(band: Band, tree: RigidTree, key: str) -> None:
    """Raises BadInput. key: what the user changed, for the faults' `column`."""
    points = band.via_points
    if not DEVICES.fewest_points <= len(points) <= DEVICES.most_points:
        detail = f"band {band.name!r} would have {len(points)} via points"
        advice = f"A band has {DEVICES.fewest_points} to {DEVICES.most_points}."
        raise BadInput(Fault(detail, "number_of_points", advice, column=key, value=str(len(points))))
    faults = [fault for k, point in enumerate(points) for fault in _point_faults(band, k, point, tree, key)]
    if not faults:
        faults = _segment_faults(band, tree, key)
    if faults:
        raise BadInput(faults)


def _point_faults(band: Band, index: int, point: ViaPoint, tree: RigidTree, key: str) -> list[Fault]:
    farthest_m = 100.0  # from the link's origin
    faults = []
    if point.link not in tree.frames:
        faults.append(Fault("the robot has no such link or frame", "unknown_link", _link_advice(point.link, tree),
                            column=key, value=point.link[:80]))  # fmt: skip
    if not max(map(abs, point.xyz)) <= farthest_m:
        detail = f"via point {index} of band {band.name!r} is more than {farthest_m:g} m from its link"
        value = ", ".join(f"{each:g}" for each in point.xyz)
        faults.append(Fault(detail, "too_far", "Places are in metres.", column=key, value=value))
    return faults


def _segment_faults(band: Band, tree: RigidTree, key: str) -> list[Fault]:
    """Seen in two postures: what coincides in both does so in all, or nearly."""
    postures = [Posture(tree), Posture(tree, np.linspace(0.1, 0.5, len(tree.joints)))]
    places = np.array([[posture.place(point) for point in band.via_points] for posture in postures])
    apart = np.linalg.norm(np.diff(places, axis=1), axis=2).max(axis=0)
    faults = [
        Fault(
            f"via points {j} and {k} of band {band.name!r} are at the same place",
            "no_segment",
            "Leave one of them out; it may be one point in the frames of two links.",
            column=key,
        )
        for j, k in pairwise(range(len(band.via_points)))
        if apart[j] < DEVICES.same_place_m
    ]
    bodies = {tree.frames[point.link][0] for point in band.via_points}
    if len(bodies) == 1:
        (body,) = bodies
        on = "the fixed base" if body < 0 else f"link {tree.bodies[body]!r}"
        detail = f"all via points of band {band.name!r} are on one rigid body ({on}): it acts on no joint"
        faults.append(Fault(detail, "acts_on_no_joint", "A band must cross a joint.", column=key))
    return faults


def _link_advice(link: str, tree: RigidTree) -> str:
    if link in tree.joints:
        moved = tree.bodies[int(np.flatnonzero(tree.dof == tree.joints.index(link))[0])]
        return f"It is a joint; the link that it moves is {moved!r}."
    if near := get_close_matches(link, list(tree.frames), n=3, cutoff=0.6):
        return f"Did you mean {' or '.join(map(repr, near))}?"
    return f"Links that move: {_listed(tree.bodies)}."


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:SHOWN_LINKS]) + (", …" if len(names) > SHOWN_LINKS else "")
