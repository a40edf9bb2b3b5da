"""Postures for the static stage: those of Algorithm 1, and those that leave the smallest standard deviations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.errors import NotIdentifiable
from exogauge.payload.statics import (
    Holds,
    StaticSolution,
    force_columns,
    inclination,
    moment_columns,
    moment_noise,
    static_stage,
)

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

BELIEVED = ("mass", "centre", "inclination")


@final
@dataclass(frozen=True)
class Believed:
    """mass [kg], centre (3,) [m] before anything is identified; gravity (3,) [m/s²] in {B}; s; std (6,) [N, N·m] of the
    mean wrench of one hold."""

    mass: float
    centre: Array
    gravity: Array
    sign: int
    std: Array

    def holds(self, rotation: Array) -> Holds:
        """What a sensor without errors and zero would read in postures R_BS (K, 3, 3)."""
        weight = -self.sign * self.mass * np.einsum("kji,j->ki", rotation, self.gravity)
        wrench = np.concatenate([weight, np.cross(self.centre, weight)], axis=1)
        return Holds(rotation, wrench, self.std)

    def solution(self, rotation: Array) -> StaticSolution:
        """The static stage's answer, whose standard deviations are those of the noise. Raises NotIdentifiable."""
        return static_stage(self.holds(rotation), self.gravity, self.sign)


def algorithm_1(count: int, K: float, feasible: Callable[[Array], BoolArray]) -> Array:
    """(N, 3, 3) R_BS, N >= count. feasible: (M, 3, 3) -> (M,).

    Implements [Payload] Algorithm 1. Differs from print: the list begins anew for each n; i and j stop before what they
    began with; postures in which gravity has one direction in {S} count once; N >= count ends it.
    Raises NotIdentifiable where K = 0, or where the workspace has no room.
    """
    finest = 40  # divisions of a turn at which Algorithm 1 gives up: no feasible posture lies wider than 9° apart
    same = 1e-6  # of a unit vector: two directions of gravity that count as one
    if K == 0.0:
        raise NotIdentifiable(
            "with K = 0 the postures turn about one axis of the sensor alone: gravity never leaves a plane of its "
            "axes, and postures that differ about the vertical are dropped as duplicates. The force part is "
            "singular; take K = -0.2", BELIEVED,
        )  # fmt: skip
    found = np.zeros((0, 3, 3))
    for n in range(1, finest + 1):
        found = np.zeros((0, 3, 3))
        all_of_n = grid(n, K)
        for R in all_of_n[feasible(all_of_n)]:
            if not (np.abs(found[:, 2] - R[2]).max(axis=1, initial=0.0) < same).any():
                found = np.concatenate([found, R[None]])
        if len(found) >= count:
            return found
    raise NotIdentifiable(
        f"only {len(found)} of {count} postures lie in the feasible workspace: widen it, or ask for fewer", BELIEVED
    )


def grid(n: int, K: float) -> Array:
    """(M, 3, 3) R_BS of lines 3-8 of Algorithm 1: γ_z = 2πi/n, γ_y = πj/n."""
    turns = []
    for i in range(n):
        z = 2 * np.pi * i / n
        x = K * z if z < np.pi else -K * (2 * np.pi - z)
        turns += [pin.rpy.rpyToMatrix(x, np.pi * j / n, z) for j in range(n + 1)]
    return np.array(turns)


def choose(candidates: Array, count: int, believed: Believed) -> NDArray[np.intp]:
    """(count,) places in R_BS (M, 3, 3): one by one what leaves the least mean ln of the standard deviations of m, c, U
    and V, then exchanged while that gains. Raises NotIdentifiable where they do not decide everything."""
    sweeps = 5  # rounds of exchanges after the greedy choice, at most
    weak = 1e-9  # information of what nothing was seen of, against that of one posture
    if len(candidates) < count:
        raise NotIdentifiable(
            f"only {len(candidates)} of the postures that were tried are feasible, {count} are wanted: widen the "
            "workspace or the joints' limits, or let more joints move", BELIEVED,
        )  # fmt: skip
    parts = informations(candidates, believed)
    start = weak * np.array([np.trace(part.mean(axis=0)) * np.eye(6) for part in parts])
    chosen: list[int] = []
    held = start.copy()
    for _ in range(count):
        best = _best(held, parts, chosen, believed)
        chosen.append(best)
        held += np.array([part[best] for part in parts])
    for _ in range(sweeps):
        before = list(chosen)
        for k in range(count):
            held -= np.array([part[chosen[k]] for part in parts])
            chosen[k] = _best(held, parts, chosen[:k] + chosen[k + 1 :], believed)
            held += np.array([part[chosen[k]] for part in parts])
        if chosen == before:
            break
    believed.solution(candidates[chosen])
    return np.array(chosen, dtype=np.intp)


def informations(rotation: Array, believed: Believed) -> tuple[Array, Array]:
    """(M, 6, 6) of [κ, f_0] and (M, 6, 6) of [c, ι], that each posture brings."""
    holds, K = believed.holds(rotation), len(rotation)
    A = force_columns(rotation).reshape(K, 3, 6) / holds.std[:3, None]
    B = moment_columns(holds.wrench[:, :3]).reshape(K, 3, 6) / moment_noise(holds.std, believed.centre)[:, None]
    return np.swapaxes(A, 1, 2) @ A, np.swapaxes(B, 1, 2) @ B


def std_of(force: Array, moment: Array, believed: Believed) -> Array:
    """(M, 6) of [m, c, U, V] by informations (M, 6, 6) of the force and of the moment part."""
    kappa = -believed.sign * believed.mass * believed.gravity
    g = float(np.linalg.norm(believed.gravity))
    upright = pin.Quaternion.FromTwoVectors(believed.gravity / g, -np.eye(3)[2]).toRotationMatrix()
    h = 1e-6 * float(np.linalg.norm(kappa))
    tilt = np.stack([
        inclination(upright @ (kappa + h * e), believed.sign) - inclination(upright @ (kappa - h * e), believed.sign)
        for e in np.eye(3)
    ], axis=1) / (2 * h)  # fmt: skip
    J = np.vstack([kappa / (np.linalg.norm(kappa) * g), tilt])
    C = np.linalg.inv(force)[:, :3, :3]
    of_force = np.einsum("ij,mjk,ik->mi", J, C, J)
    of_centre = np.diagonal(np.linalg.inv(moment), axis1=1, axis2=2)[:, :3]
    return np.asarray(np.sqrt(np.hstack([of_force[:, :1], of_centre, of_force[:, 1:]])))


def _best(held: Array, parts: tuple[Array, Array], taken: list[int], believed: Believed) -> int:
    cost = np.log(std_of(held[0] + parts[0], held[1] + parts[1], believed)).sum(axis=1)
    cost[taken] = np.inf
    return int(np.argmin(cost))


def least_travel(angles: Array, start: Array, speed: Array, passable: Callable[[Array, Array], bool]) -> list[int]:
    """Order in which to visit angles (N, n) [rad] from start (n,): the least time at `speed` (n,) [rad/s], every move
    that is not `passable` put off as long as another way exists.

    The nearest next one, then parts of the way turned round while that is shorter.
    """
    stops = np.vstack([start, angles])
    N = len(stops)
    way = np.max(np.abs(stops[:, None] - stops[None]) / speed, axis=2)
    total = 1.0 + float(way.sum())
    for i in range(N):
        for j in range(i):
            if not passable(stops[i], stops[j]):
                way[i, j] = way[j, i] = way[i, j] + total
    order = [0]
    while len(order) < N:
        order.append(min(set(range(N)) - set(order), key=lambda k: float(way[order[-1], k])))
    shorter = True
    while shorter:
        shorter = False
        for i in range(1, N - 1):
            for j in range(i + 1, N):
                after = order[j + 1] if j + 1 < N else None
                gain = way[order[i - 1], order[i]] - way[order[i - 1], order[j]]
                if after is not None:
                    gain += way[order[j], after] - way[order[i], after]
                if gain > 1e-9:
                    order[i : j + 1] = order[i : j + 1][::-1]
                    shorter = True
    return [k - 1 for k in order[1:]]
