"""The a-priori robot of a case: its maker builds no two alike."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from exogauge.blind.generator.robot_kind import RobotKind
from exogauge.synthetic.robot_facts import Drive, Joint, Link, Vector

VARIES = 0.2  # largest relative deviation of lengths, masses and drives from one case to the next


@final
@dataclass(frozen=True)
class Built:
    """links: of one robot as its maker describes it, parents before children. size: relative to `RobotKind.links`."""

    links: tuple[Link, ...]
    size: float

    @property
    def joints(self) -> list[Joint]:
        return [link.joint for link in self.links if link.joint is not None]


def built(rng: np.random.Generator, kind: RobotKind) -> Built:
    size, weight = 1.0 + VARIES * rng.uniform(-1.0, 1.0, 2)
    links = [_varied(link, size, weight, rng) for link in kind.links]
    drawn = {name: _round(rng.uniform(*ends)) for name, ends in kind.drawn.items()}
    return Built(tuple(replace(link, mass=drawn.get(link.name, link.mass)) for link in links), float(size))


def _varied(link: Link, size: float, weight: float, rng: np.random.Generator) -> Link:
    own = 1.0 + 0.5 * VARIES * rng.uniform(-1.0, 1.0)
    joint = link.joint and replace(link.joint, drive=_varied_drive(link.joint.drive, rng))
    return replace(link, origin=_scaled(link.origin, size), size=_scaled(link.size, size), joint=joint,
                   centre=_scaled(link.centre, size), mass=_round(link.mass * weight * own))  # fmt: skip


def _varied_drive(drive: Drive, rng: np.random.Generator) -> Drive:
    k_T, k_d, tau_c, J_r = 1.0 + VARIES * rng.uniform(-1.0, 1.0, 4)
    return replace(
        drive,
        k_T=_round(drive.k_T * k_T),
        k_d=_round(drive.k_d * k_d),
        tau_c=_round(drive.tau_c * tau_c),
        J_r=_round(drive.J_r * J_r),
    )


def _scaled(vector: Vector, by: float) -> Vector:
    x, y, z = (round(float(value * by), 4) for value in vector)
    return x, y, z


def _round(value: float) -> float:
    return float(f"{value:.4g}")
