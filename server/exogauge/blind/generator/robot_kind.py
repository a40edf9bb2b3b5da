"""A sort of robot that cases are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from exogauge.blind.generator.wear_facts import Wire
from exogauge.synthetic.robot_facts import Link


@final
@dataclass(frozen=True)
class WristOrBase:
    """A force/torque sensor that carries all links beyond its frame, which is a link of the robot without a mass.

    force [N], moment [N·m]: noise of one sample.
    """

    name: str
    frame: str
    force: float
    moment: float


@final
@dataclass(frozen=True)
class RobotKind:
    """links: parents before children, the base first. hands: links that take a payload.

    drawn: least and most mass [kg] of links that are another in every case. wires: where bands could run, by group;
    none where the robot wears no device.
    """

    name: str
    links: tuple[Link, ...]
    sensor: WristOrBase
    hands: tuple[str, ...]
    drawn: dict[str, tuple[float, float]] = field(default_factory=dict)
    wires: tuple[Wire, ...] = ()
