"""Where a force/torque sensor cuts the robot in two: what hangs rigidly beyond it becomes a body of its own.

Without that, a tool behind a wrist sensor and the link before it would be one body, and nobody could say what the
sensor has to carry.

What a force/torque sensor inside the robot reads, as rows of a regressor: the bodies beyond it and nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.kinematics import Kinematics, Sweep
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import BaseParameters
from exogauge.robots.tree import IntArray, RigidTree


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
    carried = tree.subtree
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


Array = NDArray[np.float64]


@final
class CutRows:
    """Six rows, force then moment about the origin of one sensor's frame, in its axes: what moves the bodies beyond."""

    def __init__(self, tree: RigidTree, base: BaseParameters, frame: str) -> None:
        self.tree, self.frame = tree, frame
        body, kind = np.divmod(base.columns, 10)
        beyond = np.isin(body, tree.cuts[frame])
        mass, inertia = (np.flatnonzero(beyond & chosen) for chosen in (kind < 4, kind >= 4))
        self._mass, self._inertia = body[mass] * 4 + kind[mass], body[inertia] * 6 + kind[inertia] - 4
        self.columns: tuple[IntArray, ...] = (mass,) * 3 + (np.concatenate([mass, inertia]),) * 3
        self._kinematics = Kinematics(tree)

    def fill(self, motion: Motion, extra: Sequence[int] = (0,) * 6) -> list[Array]:
        """Per row (T, k_r + extra[r]), Fortran order: regressor columns, then zeros."""
        sweep = self._kinematics.sweep(motion)
        k_1, k_2 = len(self._mass), len(self._inertia)
        columns = np.zeros((6, k_1 + k_2, motion.samples))
        columns[:, :k_1] = mass_columns(self._mass, sweep)
        columns[3:, k_1:] = inertia_columns(self._inertia, sweep)
        blocks = []
        rows = in_sensor(self.tree, self.frame, sweep, columns)
        for row, width, more in zip(rows, (k_1,) * 3 + (k_1 + k_2,) * 3, extra, strict=True):
            block = np.zeros((width + more, motion.samples))
            block[:width] = row[:width]
            blocks.append(block.T)
        return blocks


def in_sensor(tree: RigidTree, frame: str, sweep: Sweep, wrench: Array) -> Array:
    """(6, K, T) wrenches about the base origin in the base frame, about a sensor's origin in its axes."""
    R, p = _pose(tree, frame, sweep, wrench.shape[2])
    force, moment = wrench[:3], wrench[3:] - np.cross(p[:, None], wrench[:3], axis=0)
    return np.concatenate([np.einsum("jit,jkt->ikt", R, each) for each in (force, moment)])


def _pose(tree: RigidTree, frame: str, sweep: Sweep, samples: int) -> tuple[Array, Array]:
    """R_base_sensor (3, 3, T) and its place in the base frame (3, T)."""
    body, T = tree.frames[frame]
    if body < 0:
        return np.repeat(T.rotation[:, :, None], samples, 2), np.repeat(T.translation[:, None], samples, 1)
    R = np.einsum("ijt,jk->ikt", sweep.R[body], T.rotation)
    return R, sweep.p[body] + np.einsum("ijt,j->it", sweep.R[body], T.translation)


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
