"""The moving bodies of a robot as arrays: what every batched kernel reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class RigidTree:
    """N moving bodies, parents before children; J actuated joints; every body frame is its URDF link's frame.

    Floating: body 0 is the base link, without a joint (dof -1, parent -1). Fixed: the base link is no body, bodies
    that hang on it have parent -1. Links joined by fixed joints are one body, named by the link its joint moves.

    bodies: (N,) link names. joints: (J,) names, in the order of the log's columns.
    parent: (N,) body index or -1. dof: (N,) column in q, or -1 for the floating base and for a body that is fixed to
    its parent, or to the base, behind a force/torque sensor (`robots.cuts`).
    axis: (N, 3) unit joint axis. prismatic: (N,) bool.
    T_before, T_after: N poses; T_parent_body(q) = T_before · motion(axis, q) · T_after
    (T_after is the identity except where the tree was re-rooted).
    phi: (N, 10) a-priori [m, mx, my, mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz] about the body frame's origin [kg, kg·m, kg·m²].
    frames: frame or link name -> (body index, -1 = fixed base; pose in that body).
    lower, upper: (J,) position limits [rad or m]; velocity_limit, effort_limit: (J,), inf where unknown.
    locked: joints of the URDF that could move and are held at zero. dropped: links beyond a cut, whose inertia is not
    in `phi`.
    cuts: frame of a sensor -> bodies that it carries. parts: body behind a sensor -> its links; their frames are those
    of the body that moves them.
    """

    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    floating: bool
    parent: IntArray
    dof: IntArray
    axis: Array
    prismatic: NDArray[np.bool_]
    T_before: tuple[pin.SE3, ...]
    T_after: tuple[pin.SE3, ...]
    phi: Array
    frames: Mapping[str, tuple[int, pin.SE3]]
    lower: Array
    upper: Array
    velocity_limit: Array
    effort_limit: Array
    locked: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    cuts: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @cached_property
    def subtree(self) -> NDArray[np.bool_]:
        """(N, N) entry [i, k]: body k is body i or carried by it. Not to be written to."""
        carried = np.eye(len(self.bodies), dtype=np.bool_)
        for k, parent in enumerate(self.parent.tolist()):
            if parent >= 0:
                carried[:, k] |= carried[:, parent]
        carried.flags.writeable = False
        return carried

    @property
    def sliding(self) -> frozenset[str]:
        """Prismatic joints, by name: bodies and joints are counted and ordered apart."""
        return frozenset(self.joints[dof] for dof in self.dof[self.prismatic].tolist())

    @property
    def mass(self) -> float:
        """A-priori total mass of the moving bodies [kg]."""
        return float(self.phi[:, 0].sum())

    @property
    def idle(self) -> tuple[str, ...]:
        """Joints that move nothing that weighs. Those beyond a contact sensor do not count: what is there weighs 0."""
        loaded = self.phi[:, 0] > 0.0
        for link in self.dropped:
            loaded[self.frames[link][0]] |= self.frames[link][0] >= 0
        for body in range(len(self.bodies) - 1, -1, -1):
            if loaded[body] and self.parent[body] >= 0:
                loaded[self.parent[body]] = True
        idle = {int(self.dof[body]) for body in np.flatnonzero(~loaded)}
        return tuple(name for dof, name in enumerate(self.joints) if dof in idle)
