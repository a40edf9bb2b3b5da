"""Where a force/torque sensor cuts the robot in two: what hangs rigidly beyond it becomes a body of its own.

Without that, a tool behind a wrist sensor and the link before it would be one body, and nobody could say what the
sensor has to carry.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import pinocchio as pin

from exogauge.robots.kinematics import subtree
from exogauge.robots.tree import RigidTree


@final
@dataclass(frozen=True)
class Beyond:
    """What a sensor at `frame` carries. links: rigidly fixed to it, the first one nearest. joints: moving ones that
    hang on it or on those links. inertia: of the links together, in the frame of the body that they are part of."""

    frame: str
    links: tuple[str, ...]
    joints: tuple[str, ...]
    inertia: pin.Inertia


def split(tree: RigidTree, sensors: Sequence[Beyond]) -> RigidTree:
    """The tree with one more body, without a joint (dof -1), for the links beyond each sensor; `cuts` filled in.

    Frames stay on the body that moves them, so that bands and contacts do not notice. A sensor whose links another one
    carries already shares its body.
    """
    owner: dict[str, int] = {}
    for sensor in sorted(sensors, key=lambda each: len(each.links)):
        own = [link for link in sensor.links if link not in owner]
        if not own:
            continue
        inner = {owner[link] for link in sensor.links if link in owner}
        tree = _with_body(tree, own, sensor.inertia, inner)
        owner |= dict.fromkeys(own, len(tree.bodies) - 1)
    carried = subtree(tree)
    moved_by = {joint: int(np.flatnonzero(tree.dof == k)[0]) for k, joint in enumerate(tree.joints)}
    cuts: dict[str, tuple[int, ...]] = {}
    for sensor in sensors:
        roots = {owner[link] for link in sensor.links} | {moved_by[joint] for joint in sensor.joints}
        cuts[sensor.frame] = tuple(int(k) for k in np.flatnonzero(np.any([carried[root] for root in roots], axis=0)))
    return replace(tree, cuts=cuts)


def _with_body(tree: RigidTree, links: Sequence[str], inertia: pin.Inertia, inner: set[int]) -> RigidTree:
    """inertia: of the links and of the inner bodies together, which have left the moving body already."""
    body, T_body_link = tree.frames[links[0]]
    own = inertia.toDynamicParameters()
    for other in inner:
        own = own - tree.T_before[other].act(pin.Inertia.FromDynamicParameters(tree.phi[other])).toDynamicParameters()
    phi = tree.phi.copy()
    if body >= 0:
        phi[body] -= own
        phi[body][np.abs(phi[body]) < 1e-12] = 0.0
    in_link = T_body_link.actInv(pin.Inertia.FromDynamicParameters(own)).toDynamicParameters() if own[0] else 0.0 * own
    identity = pin.SE3.Identity()
    return replace(
        tree,
        bodies=(*tree.bodies, links[0]),
        parent=np.append(tree.parent, body),
        dof=np.append(tree.dof, -1),
        axis=np.vstack([tree.axis, np.zeros(3)]),
        prismatic=np.append(tree.prismatic, False),
        T_before=(*tree.T_before, T_body_link),
        T_after=(*tree.T_after, identity),
        phi=np.vstack([phi, in_link]),
        parts={**tree.parts, links[0]: tuple(links)},
    )


def links_of(tree: RigidTree, body: int, links: Sequence[str]) -> list[str]:
    """Of the given links, those whose inertia is in this body."""
    apart: Mapping[str, tuple[str, ...]] = tree.parts
    name = tree.bodies[body]
    if name in apart:
        return [link for link in links if link in apart[name]]
    split_off = {link for part in apart.values() for link in part}
    return [link for link in links if link not in split_off and tree.frames[link][0] == body]


def pose_in_body(tree: RigidTree, body: int, link: str) -> pin.SE3:
    """T_body_link of a link that is part of the body."""
    pose = tree.frames[link][1]
    return tree.T_before[body].inverse() * pose if tree.bodies[body] in tree.parts else pose
