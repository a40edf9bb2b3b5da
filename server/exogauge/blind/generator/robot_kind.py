"""A sort of robot that cases are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.synthetic.robot_facts import Link


@final
@dataclass(frozen=True)
class Mount:
    """A base link that stands on a force/torque sensor and carries an IMU: the links that are their frames."""

    sensor: str
    imu: str


@final
@dataclass(frozen=True)
class RobotKind:
    """links: parents before children, the base first. mount: None where nothing but the joints is measured."""

    name: str
    links: tuple[Link, ...]
    mount: Mount | None
