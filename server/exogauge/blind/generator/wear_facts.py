"""Where the bands of `torso8` run: down the back, round the waist, from the trunk to the upper arms; our estimates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from exogauge.synthetic.robot_facts import BASE, Vector


@final
@dataclass(frozen=True)
class Wire:
    """A band's course: straight from point to point. points: link, and xyz [m] in its frame, at the nominal size."""

    name: str
    group: str
    points: tuple[tuple[str, Vector], ...]


_LEFT = (
    Wire("A_left", "A", (("chest", (-0.02, 0.085, 0.35)), ("chest", (-0.13, 0.075, 0.24)),
                         ("waist", (-0.125, 0.05, 0.03)), (BASE, (-0.12, 0.07, -0.05)))),
    Wire("B_left", "B", ((BASE, (-0.12, 0.08, 0.02)), (BASE, (-0.08, 0.145, 0.05)), ("chest", (0.10, 0.16, 0.05)),
                         ("chest", (0.13, 0.09, 0.09)))),
    Wire("C_left", "C", (("chest", (-0.09, 0.05, 0.30)), ("chest", (-0.10, 0.12, 0.20)),
                         ("l_upper_arm", (-0.06, 0.0, -0.12)))),
    Wire("D_left", "D", (("chest", (0.10, 0.05, 0.20)), ("chest", (0.09, 0.12, 0.27)),
                         ("l_upper_arm", (0.045, 0.0, -0.07)))),
)  # fmt: skip


def _mirrored(wire: Wire) -> Wire:
    points = tuple((f"r_{at[2:]}" if at.startswith("l_") else at, (x, -y, z)) for at, (x, y, z) in wire.points)
    return replace(wire, name=wire.name.replace("left", "right"), points=points)


WIRES = tuple(twin for wire in _LEFT for twin in (wire, _mirrored(wire)))
