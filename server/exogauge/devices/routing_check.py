"""Whether a changed routing is one: links that exist, segments that have a length, joints to act on.

The same rules, in the same words, as for a device file.
"""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from itertools import pairwise

import numpy as np

from exogauge.devices.device import Band, ViaPoint
from exogauge.devices.posture import Posture
from exogauge.errors import BadInput, Fault
from exogauge.robots.tree import RigidTree

FEWEST_POINTS, MOST_POINTS = 2, 50
FARTHEST_M = 100.0  # from the link's origin
SAME_PLACE_M = 1e-6
SHOWN_LINKS = 30


def check_routing(band: Band, tree: RigidTree, key: str) -> None:
    """Raises BadInput. key: what the user changed, for the faults' `column`."""
    points = band.via_points
    if not FEWEST_POINTS <= len(points) <= MOST_POINTS:
        detail = f"band {band.name!r} would have {len(points)} via points"
        advice = f"A band has {FEWEST_POINTS} to {MOST_POINTS}."
        raise BadInput(Fault(detail, "number_of_points", advice, column=key, value=str(len(points))))
    faults = [fault for k, point in enumerate(points) for fault in _point_faults(band, k, point, tree, key)]
    if not faults:
        faults = _segment_faults(band, tree, key)
    if faults:
        raise BadInput(faults)


def _point_faults(band: Band, index: int, point: ViaPoint, tree: RigidTree, key: str) -> list[Fault]:
    faults = []
    if point.link not in tree.frames:
        faults.append(Fault("the robot has no such link or frame", "unknown_link", _link_advice(point.link, tree),
                            column=key, value=point.link[:80]))  # fmt: skip
    if not max(map(abs, point.xyz)) <= FARTHEST_M:
        detail = f"via point {index} of band {band.name!r} is more than {FARTHEST_M:g} m from its link"
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
        if apart[j] < SAME_PLACE_M
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
