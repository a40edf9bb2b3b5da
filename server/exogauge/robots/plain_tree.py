"""A tree as plain numbers and names, to be handed from the process that read the robot to one that uses it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from exogauge.robots.tree import Array, RigidTree

MOST_BODIES, MOST_FRAMES = 1000, 20_000


def to_plain(tree: RigidTree) -> dict[str, Any]:
    """What JSON can hold; without limits of velocity and effort, which may be infinite."""
    return {
        "bodies": list(tree.bodies),
        "joints": list(tree.joints),
        "floating": tree.floating,
        "parent": tree.parent.tolist(),
        "dof": tree.dof.tolist(),
        "axis": tree.axis.tolist(),
        "prismatic": tree.prismatic.tolist(),
        "T_before": [_numbers(T) for T in tree.T_before],
        "T_after": [_numbers(T) for T in tree.T_after],
        "phi": tree.phi.tolist(),
        "frames": {name: [body, _numbers(T)] for name, (body, T) in tree.frames.items()},
        "locked": list(tree.locked),
        "dropped": list(tree.dropped),
    }


def from_plain(plain: Mapping[str, Any]) -> RigidTree:
    """The tree, its limits unknown. Raises ValueError, KeyError or TypeError where `plain` is none."""
    bodies, joints = _names(plain["bodies"]), _names(plain["joints"])
    count, frames = len(bodies), plain["frames"]
    if count > MOST_BODIES or len(frames) > MOST_FRAMES:
        raise ValueError("too many bodies or frames")
    parent, dof = (np.array(plain[key], dtype=np.intp) for key in ("parent", "dof"))
    if parent.shape != (count,) or not ((parent >= -1) & (parent < np.arange(count))).all():
        raise ValueError("parents come before their children")
    if dof.shape != (count,) or sorted(dof[dof >= 0].tolist()) != list(range(len(joints))) or (dof < -1).any():
        raise ValueError("every joint moves one body")
    unknown = np.full(len(joints), np.inf)
    return RigidTree(
        bodies=bodies,
        joints=joints,
        floating=bool(plain["floating"]),
        parent=parent,
        dof=dof,
        axis=_array(plain["axis"], (count, 3)),
        prismatic=np.array(plain["prismatic"], dtype=np.bool_).reshape(count),
        T_before=_poses(plain["T_before"], count),
        T_after=_poses(plain["T_after"], count),
        phi=_array(plain["phi"], (count, 10)),
        frames={str(name): (_body(body, count), _pose(T)) for name, (body, T) in frames.items()},
        lower=-unknown,
        upper=unknown,
        velocity_limit=unknown,
        effort_limit=unknown,
        locked=_names(plain["locked"]),
        dropped=_names(plain["dropped"]),
    )


def _numbers(T: pin.SE3) -> list[float]:
    """Rotation row by row, then place."""
    return [*np.asarray(T.rotation).ravel().tolist(), *np.asarray(T.translation).tolist()]


def _pose(numbers: Sequence[float]) -> pin.SE3:
    values = _array(numbers, (12,))
    return pin.SE3(values[:9].reshape(3, 3), values[9:])


def _poses(plain: Sequence[Sequence[float]], count: int) -> tuple[pin.SE3, ...]:
    if len(plain) != count:
        raise ValueError("every body has a pose")
    return tuple(_pose(T) for T in plain)


def _array(values: Any, shape: tuple[int, ...]) -> Array:
    found = np.array(values, dtype=np.float64).reshape(shape)
    if not np.isfinite(found).all():
        raise ValueError("a number is not finite")
    return found


def _body(body: int, count: int) -> int:
    if not -1 <= int(body) < count:
        raise ValueError("a frame is on no body")
    return int(body)


def _names(values: Sequence[Any]) -> tuple[str, ...]:
    return tuple(str(value) for value in values)
