"""What a log would be, were one thing about one joint otherwise: each remedy undoes a slip, and is tried as a whole."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot

Array = NDArray[np.float64]
Kind = Literal["position", "effort", "both"]


@final
@dataclass(frozen=True)
class Remedy:
    """rule: a stable short code. joints: one, or the two that are exchanged. undo: the snapshot as it should have been.

    cost: log of how much rarer such a slip is than a reversed sign. value: factor or angle, for the message.
    """

    rule: str
    kind: Kind
    joints: tuple[int, ...]
    undo: Callable[[Snapshot], Snapshot]
    cost: float = 0.0
    value: float | None = None


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
    angles = (-0.5 * np.pi, 0.5 * np.pi, np.pi)
    return [
        *(Remedy("position_scale", "position", (joint,), _scaled(joint, each), 3.0, 1.0 / each) for each in factors),
        *(Remedy("position_offset", "position", (joint,), _shifted(joint, each), 5.0, -each) for each in angles),
    ]


def exchanged(one: int, other: int) -> Sequence[Remedy]:
    pair = (one, other)

    def positions(seen: Snapshot) -> Snapshot:
        return replace(seen, q=_swap(seen.q, pair), dq=_swap(seen.dq, pair), ddq=_swap(seen.ddq, pair))

    def efforts(seen: Snapshot) -> Snapshot:
        return replace(seen, effort=_swap(seen.effort, pair), late=_swap(seen.late, pair))

    return (
        Remedy("efforts_exchanged", "effort", pair, efforts, 3.0),
        Remedy("positions_exchanged", "position", pair, positions, 3.0),
        Remedy("joints_exchanged", "both", pair, lambda seen: efforts(positions(seen)), 3.0),
    )


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
        return replace(seen, q=q, dq=dq, ddq=ddq)

    return undo


def _shifted(joint: int, angle: float) -> Callable[[Snapshot], Snapshot]:
    def undo(seen: Snapshot) -> Snapshot:
        q = seen.q.copy()
        q[:, joint] += angle
        return replace(seen, q=q)

    return undo


def _swap(values: Array, pair: tuple[int, int]) -> Array:
    swapped = values.copy()
    swapped[..., list(pair)] = values[..., list(pair[::-1])]
    return swapped
