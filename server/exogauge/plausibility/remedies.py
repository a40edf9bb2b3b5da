"""What a log would be, were one thing about one joint otherwise: each remedy undoes a slip, and is tried as a whole."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot

Array = NDArray[np.float64]
Kind = Literal["position", "effort", "both"]
ZEROS = tuple(np.radians([*range(-150, 0, 30), *range(30, 181, 30)]).tolist())  # tried: half a step is not told


@final
@dataclass(frozen=True)
class Remedy:
    """rule: a stable short code. joints: one, or those that are exchanged, the one half with the other in this order.

    undo: the snapshot as it should have been.
    cost: log of how much rarer such a slip is than a reversed sign. value: factor or angle, for the message.
    up: (3,) the direction away from gravity in the base's frame, where it is another.
    """

    rule: str
    kind: Kind
    joints: tuple[int, ...]
    undo: Callable[[Snapshot], Snapshot]
    cost: float = 0.0
    value: float | None = None
    up: tuple[float, ...] | None = None


def reversals(joint: int) -> Sequence[Remedy]:
    flip, effort = _scaled(joint, -1.0), _effort(joint, -1.0)
    return (
        Remedy("effort_reversed", "effort", (joint,), effort),
        Remedy("position_reversed", "position", (joint,), flip),
        Remedy("joint_reversed", "both", (joint,), lambda seen: effort(flip(seen)), 1.0),
    )


def misread_positions(robot: Robot, joint: int) -> Sequence[Remedy]:
    """Degrees, the other side of the gear, another zero."""
    gear = abs(robot.joints[joint].gear_ratio or 1.0)
    factors = (np.pi / 180.0, 180.0 / np.pi, *((gear, 1.0 / gear) if gear > 1.5 else ()))
    return [
        *(Remedy("position_scale", "position", (joint,), _scaled(joint, each), 3.0, 1.0 / each) for each in factors),
        *(Remedy("position_offset", "position", (joint,), shifted(joint, each), 5.0, -each) for each in ZEROS),
    ]


def zeros_in_eighths(joint: int) -> list[Remedy]:
    """Zeros that are off by eighths of a turn, as mountings are."""
    angles = np.radians([45.0, 90.0, 135.0, 180.0, -135.0, -90.0, -45.0]).tolist()
    return [Remedy("position_offset", "position", (joint,), shifted(joint, each), 5.0, -each) for each in angles]


def exchanged(ones: Sequence[int], others: Sequence[int]) -> Sequence[Remedy]:
    """Each of `ones` with that of `others`: two joints, or two limbs."""
    joints = (*ones, *others)
    order = [*others, *ones]

    def swapped(values: Array) -> Array:
        result = values.copy()
        result[..., joints] = values[..., order]
        return result

    def positions(seen: Snapshot) -> Snapshot:
        q, dq, ddq, way, ahead = (swapped(each) for each in (seen.q, seen.dq, seen.ddq, seen.way, seen.ahead))
        return replace(seen, q=q, dq=dq, ddq=ddq, way=way, ahead=ahead)

    def efforts(seen: Snapshot) -> Snapshot:
        return replace(seen, effort=swapped(seen.effort), late=swapped(seen.late))

    return (
        Remedy("efforts_exchanged", "effort", joints, efforts, 3.0),
        Remedy("positions_exchanged", "position", joints, positions, 3.0),
        Remedy("joints_exchanged", "both", joints, lambda seen: efforts(positions(seen)), 3.0),
    )


def alike_limbs(robot: Robot) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Joints of two limbs on one body, of two joints or more, that branch alike: two arms, two legs, two fingers."""
    tree = robot.tree
    children = dict[int, list[int]]()
    for body, parent in enumerate(tree.parent):
        children.setdefault(int(parent), []).append(body)

    def shape(body: int) -> tuple[object, ...]:
        return (tree.dof[body] >= 0, *(shape(each) for each in children.get(body, [])))

    def joints(body: int) -> list[int]:
        own = [int(tree.dof[body])] if tree.dof[body] >= 0 else []
        return own + [joint for each in children.get(body, []) for joint in joints(each)]

    pairs = [pair for siblings in children.values() for pair in combinations(siblings, 2)]
    return [
        (tuple(joints(one)), tuple(joints(other)))
        for one, other in pairs
        if shape(one) == shape(other) and len(joints(one)) > 1
    ]


def other_gravity(robot: Robot) -> list[Remedy]:
    """A fixed base that is mounted otherwise: on a wall, below a ceiling, aslant. No IMU tells it."""
    joints = tuple(range(len(robot.joints)))
    ups = [] if robot.tree.floating else [np.array(each) for each in product((0.0, 1.0, -1.0), repeat=3)]
    ups = [each / np.linalg.norm(each) for each in ups if each.any() and not (each[2] > 0.0 and not each[:2].any())]
    return [
        Remedy("gravity_direction", "position", joints, _upward(up), 3.0, float(np.arccos(up[2])), tuple(up))
        for up in ups
    ]


def without_gravity(robot: Robot) -> Remedy:
    """Efforts that a controller told without its own gravity compensation."""
    joints = tuple(range(len(robot.joints)))
    return Remedy("gravity_left_out", "position", joints, _upward(np.zeros(3)), 3.0, up=(0.0, 0.0, 0.0))


def _upward(up: Array) -> Callable[[Snapshot], Snapshot]:
    return lambda seen: replace(seen, acc=np.linalg.norm(seen.acc, axis=1)[:, None] * up)


def scaled_effort(joint: int, gain: float) -> Remedy:
    """The effort is `gain` times what it should be."""
    return Remedy("effort_scale", "effort", (joint,), _effort(joint, 1.0 / gain), 3.0, gain)


def _effort(joint: int, factor: float) -> Callable[[Snapshot], Snapshot]:
    def undo(seen: Snapshot) -> Snapshot:
        effort, late = seen.effort.copy(), seen.late.copy()
        effort[:, joint] *= factor
        late[:, :, joint] *= factor
        return replace(seen, effort=effort, late=late)

    return undo


def _scaled(joint: int, factor: float) -> Callable[[Snapshot], Snapshot]:
    def undo(seen: Snapshot) -> Snapshot:
        q, dq, ddq = seen.q.copy(), seen.dq.copy(), seen.ddq.copy()
        for each in (q, dq, ddq):
            each[:, joint] *= factor
        way, ahead = seen.way.copy(), seen.ahead.copy()
        for each in (way, ahead):
            each[:, joint] *= abs(factor)
        return replace(seen, q=q, dq=dq, ddq=ddq, way=way, ahead=ahead)

    return undo


def shifted(joint: int, angle: float) -> Callable[[Snapshot], Snapshot]:
    """Its position is `angle` [rad] more than was read."""

    def undo(seen: Snapshot) -> Snapshot:
        q = seen.q.copy()
        q[:, joint] += angle
        return replace(seen, q=q)

    return undo
