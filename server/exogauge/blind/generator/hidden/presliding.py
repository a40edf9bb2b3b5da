"""Friction that builds up over a distance after every turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array


@final
@dataclass(frozen=True)
class Presliding:
    """Two bristles side by side in place of Coulomb friction, together tau_c; size [rad]: the way of the first.

    Each follows Dahl's law dF/dx = F_c / way · (1 - F/F_c sgn dx)^power with a power above 1, solved exactly between
    turns; the second has `longer` times the way and the share `soft` of the friction.
    """

    power: float
    soft: float
    longer: float

    name: ClassVar[str] = "presliding"
    linear: ClassVar[bool] = False
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        power, soft, longer = rng.uniform([1.2, 0.2, 2.0], [1.6, 0.4, 4.0])
        return cls(float(power), float(soft), float(longer))

    def largest(self, run: AxisRun) -> float:
        return 0.02

    def torque(self, run: AxisRun, size: float) -> Array:
        ways = ((1.0 - self.soft, size), (self.soft, size * self.longer))
        return np.array(
            [
                sum(share * run.drive.tau_c * bristle(q, way, self.power) for share, way in ways) - friction
                for q, friction in zip(run.q, run.friction, strict=True)
            ]
        )


def bristle(q: Array, way: float, power: float) -> Array:
    """(T,) force of one bristle relative to its largest, -1…1; q: (T,) [rad], begins unstrained.

    u = 1 - F sgn(dx) obeys du/dx = -u^power / way on every stretch of one direction, so
    u = (u_0^(1-power) + (power - 1) |x| / way)^(-1/(power-1)).
    """
    step = np.diff(q)
    direction = np.sign(step)
    moving = np.flatnonzero(direction)
    turns = moving[1:][np.diff(direction[moving]) != 0.0] if moving.size else moving
    force, start, last = np.zeros_like(q), 0, 0.0
    for stop in [*turns.tolist(), len(q) - 1]:
        sign = float(direction[start:stop][direction[start:stop] != 0.0][0]) if stop > start and moving.size else 1.0
        u = max(1.0 - last * sign, 1e-12)
        way_gone = np.abs(q[start : stop + 1] - q[start])
        u_after = (u ** (1.0 - power) + (power - 1.0) * way_gone / way) ** (-1.0 / (power - 1.0))
        force[start : stop + 1] = sign * (1.0 - u_after)
        start, last = stop, float(force[stop])
    return force
