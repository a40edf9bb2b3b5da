"""Friction that depends on the velocity, but not in proportion.

Friction that depends on the load.

Friction that builds up over a distance after every turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.hidden.effect import Array


@final
@dataclass(frozen=True)
class Stribeck:
    """size [N·m] more friction at creeping speed, gone a few v_s [rad/s] later.

    power: of the exponential, neither 1 nor 2; or, with tail, of 1 / (1 + |v/v_s|^power), which fades more slowly.
    """

    v_s: float
    power: float
    tail: bool

    name: ClassVar[str] = "stribeck"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        tail = bool(rng.uniform() < 0.4)
        power = rng.uniform(1.8, 2.6) if tail else rng.choice([rng.uniform(0.7, 0.9), rng.uniform(1.3, 1.7)])
        return cls(float(rng.uniform(0.04, 0.14)), float(power), tail)

    def largest(self, run: AxisRun) -> float:
        return 1.2 * run.drive.tau_c

    def torque(self, run: AxisRun, size: float) -> Array:
        x = np.abs(run.dq / self.v_s) ** self.power
        return np.asarray(size * (1.0 / (1.0 + x) if self.tail else np.exp(-x)) * run.direction)


@final
@dataclass(frozen=True)
class AsymViscous:
    """size [N·m·s/rad] more viscous friction forwards and as much less backwards, at 1 rad/s; power close to 1."""

    power: float
    sign: float

    name: ClassVar[str] = "asym_viscous"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(0.8, 1.25)), float(rng.choice([-1.0, 1.0])))

    def largest(self, run: AxisRun) -> float:
        return 0.7 * run.drive.k_d

    def torque(self, run: AxisRun, size: float) -> Array:
        return np.asarray(self.sign * size * np.abs(run.dq) ** self.power)


@final
@dataclass(frozen=True)
class NonlinearViscous:
    """size [N·m] of friction: atan(|v|/v_n), levelling off; or progressive, (|v|/v_n)^power with power above 2."""

    v_n: float
    power: float  # 0: levelling off

    name: ClassVar[str] = "nonlinear_viscous"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        if rng.uniform() < 0.6:
            return cls(float(rng.uniform(0.25, 0.6)), 0.0)
        return cls(1.0, float(rng.uniform(2.2, 2.8)))

    def largest(self, run: AxisRun) -> float:
        return max(run.drive.tau_c, run.drive.k_d)

    def torque(self, run: AxisRun, size: float) -> Array:
        x = np.abs(run.dq) / self.v_n
        return np.asarray(size * (x**self.power if self.power else np.arctan(x)) * run.direction)


@final
@dataclass(frozen=True)
class LoadCoulomb:
    """size: friction per load |l|, plus curve · l² / scale; scale [N·m] is the load's own root mean square."""

    curve: float
    scale: float

    name: ClassVar[str] = "load_coulomb"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, run: AxisRun) -> Self:
        return cls(float(rng.uniform(0.1, 0.4)), float(np.sqrt(np.mean(run.load**2))))

    def largest(self, run: AxisRun) -> float:
        return 0.25

    def torque(self, run: AxisRun, size: float) -> Array:
        l = np.abs(run.load)  # noqa: E741
        return np.asarray(size * (l + self.curve * l**2 / self.scale) * run.direction)


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
