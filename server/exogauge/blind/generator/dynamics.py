"""Inverse dynamics of a tree of bodies on a base that stands still: Newton and Euler, over all samples at once.

A table of links as a tree of moving bodies.

Every link frame is parallel to the base frame at zero posture and every joint turns about x, y or z of its link.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.inertia import Mass, joined
from exogauge.synthetic.robot_facts import Link

Array = NDArray[np.float64]

GRAVITY = 9.81
UP = np.array([0.0, 0.0, GRAVITY])  # minus gravity, seen from a base that stands upright


@final
@dataclass(frozen=True)
class Kinematics:
    """Of every body, (T, 3) each in its own frame: angular velocity, angular acceleration, acceleration of the origin
    minus gravity. cosine, sine: (J, T) of the joint angles. up: (3,) minus gravity, in the base frame."""

    omega: list[Array]
    alpha: list[Array]
    acc: list[Array]
    cosine: Array
    sine: Array
    up: Array


def joint_torques(tree: Tree, phi: Array, q: Array, dq: Array, ddq: Array, up: Array = UP) -> Array:
    """(T, J) [N·m] that the bodies phi (J, 10) ask of their joints; q, dq, ddq: (T, J); up: (3,) minus gravity."""
    return inverse_dynamics(tree, phi, kinematics(tree, q, dq, ddq, up))[0]


def inverse_dynamics(tree: Tree, phi: Array, moving: Kinematics) -> tuple[Array, Array]:
    """`joint_torques`, and the wrench (T, 6) that carries all these bodies, on the base link, about its origin and in
    its frame."""
    wrenches = [body_wrench(moving, body, phi[body]) for body in range(len(phi))]
    samples = moving.cosine.shape[1]
    torque, carried = np.empty((samples, len(phi))), np.zeros((samples, 6))
    for body in reversed(range(len(phi))):
        force, moment = wrenches[body]
        torque[:, body] = moment[:, tree.axis[body]]
        force, moment = seen_from_parent(tree, moving, body, force, moment)
        above = tree.parent[body]
        if above >= 0:
            wrenches[above] = (wrenches[above][0] + force, wrenches[above][1] + moment)
        else:
            carried += np.hstack([force, moment])
    return torque, carried


def regressor_row(tree: Tree, moving: Kinematics, joint: int) -> Array:
    """(T, 10·B) of one joint's torque by the parameters of the B bodies it carries."""
    columns = []
    for body in range(len(tree.parent)):
        path = path_down(tree, body, joint)
        if path is None:
            continue
        for unit in np.eye(10):
            force, moment = body_wrench(moving, body, unit)
            for each in path:
                force, moment = seen_from_parent(tree, moving, each, force, moment)
            columns.append(moment[:, tree.axis[joint]])
    return np.column_stack(columns)


def kinematics(tree: Tree, q: Array, dq: Array, ddq: Array, up: Array = UP) -> Kinematics:
    """From the base outwards; up: (3,) minus gravity, in the base frame."""
    still = np.zeros((len(q), 3))
    upwards = np.tile(up, (len(q), 1))
    cosine, sine = np.cos(q.T), np.sin(q.T)
    omega, alpha, acc = list[Array](), list[Array](), list[Array]()
    for body, (above, r, axis) in enumerate(zip(tree.parent, tree.origin, tree.axis, strict=True)):
        w, dw, a = (omega[above], alpha[above], acc[above]) if above >= 0 else (still, still, upwards)
        at_joint = a + np.cross(dw, r) + np.cross(w, np.cross(w, r))
        c, s = cosine[body], -sine[body]  # turned back: into the link's frame
        carried, u = _turned(w, axis, c, s), np.eye(3)[axis]
        omega.append(carried + np.outer(dq[:, body], u))
        alpha.append(_turned(dw, axis, c, s) + np.outer(ddq[:, body], u) + np.cross(carried, np.outer(dq[:, body], u)))
        acc.append(_turned(at_joint, axis, c, s))
    return Kinematics(omega, alpha, acc, cosine, sine, up)


def body_wrench(moving: Kinematics, body: int, phi: Array) -> tuple[Array, Array]:
    """Force and moment about the link's origin that move what sits on one body, in its frame: (T, 3) each.

    body -1: the base, which stands still.
    """
    if body < 0:
        still = np.zeros_like(moving.omega[0])
        w, dw, a = still, still, still + moving.up
    else:
        w, dw, a = moving.omega[body], moving.alpha[body], moving.acc[body]
    m, h, (Ixx, Ixy, Iyy, Ixz, Iyz, Izz) = phi[0], phi[1:4], phi[4:]
    I = np.array([[Ixx, Ixy, Ixz], [Ixy, Iyy, Iyz], [Ixz, Iyz, Izz]])  # noqa: E741
    force = m * a + np.cross(dw, h) + np.cross(w, np.cross(w, h))
    return force, dw @ I + np.cross(w, w @ I) + np.cross(h, a)


def seen_from_parent(tree: Tree, moving: Kinematics, body: int, force: Array, moment: Array) -> tuple[Array, Array]:
    axis, c, s = tree.axis[body], moving.cosine[body], moving.sine[body]
    turned = _turned(force, axis, c, s)
    return turned, _turned(moment, axis, c, s) + np.cross(tree.origin[body], turned)


def _turned(v: Array, axis: int, c: Array, s: Array) -> Array:
    """(T, 3) turned about a coordinate axis."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    out = v.copy()
    out[:, j] = c * v[:, j] - s * v[:, k]
    out[:, k] = s * v[:, j] + c * v[:, k]
    return out


def path_down(tree: Tree, body: int, to: int) -> list[int] | None:
    """Bodies from `body` down to the one above body `to`, which is left out; None where `to` does not carry it.

    to -1: the base, which carries all.
    """
    path = []
    while body != to:
        if body < 0:
            return None
        path.append(body)
        body = tree.parent[body]
    return path


_AXIS = {"x": 0, "y": 1, "z": 2}


@final
@dataclass(frozen=True)
class Tree:
    """J moving bodies, parents before children.

    names: of their links. parent: index of the body it hangs on, -1 for the base. origin: (J, 3) [m] of the joint in
    the parent body's frame. axis: (J,) 0, 1, 2 for x, y, z.
    """

    names: tuple[str, ...]
    parent: tuple[int, ...]
    origin: Array
    axis: tuple[int, ...]


def tree_of(links: Sequence[Link]) -> Tree:
    """Links without a joint belong to the body they are fixed to."""
    moving = [link for link in links if link.joint is not None]
    names = [link.name for link in moving]
    parent, origin = [], []
    for link in moving:
        on, offset = carrier(links, link.parent)
        parent.append(names.index(on) if on in names else -1)
        origin.append(offset + link.origin)
    return Tree(
        tuple(names), tuple(parent), np.array(origin), tuple(_AXIS[link.joint.axis] for link in moving if link.joint)
    )


def bodies_of(links: Sequence[Link], masses: Mapping[str, Mass]) -> Array:
    """(J, 10) of the moving bodies, fixed links merged in; order m, mx … mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz."""
    moving = [link.name for link in links if link.joint is not None]
    return np.array([_body(links, masses, name).phi() for name in moving])


def _body(links: Sequence[Link], masses: Mapping[str, Mass], name: str) -> Mass:
    carriers = {link.name: carrier(links, link.name) for link in links if link.name in masses}
    return joined(masses[each].moved(offset) for each, (on, offset) in carriers.items() if on == name)


def carrier(links: Sequence[Link], name: str | None) -> tuple[str, Array]:
    """The link whose joint moves `name` (or the base), and the origin of `name` seen from it."""
    by_name = {link.name: link for link in links}
    link, offset = by_name[name or links[0].name], np.zeros(3)
    while link.joint is None and link.parent is not None:
        offset += link.origin
        link = by_name[link.parent]
    return link.name, offset
