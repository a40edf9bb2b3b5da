"""Motion that tells most of a payload: Fourier series that begin and end at rest, within every bound."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL
from exogauge.errors import NotIdentifiable
from exogauge.experiment.series_search import descend, largest_within, part_within
from exogauge.payload.dynamics import Prior, prior_information, regressor_slopes
from exogauge.payload.planning.arm import Arm, Moving
from exogauge.payload.planning.workspace import Cap
from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.regressor import wrench_columns
from exogauge.robots.series import Series

Array = NDArray[np.float64]

PER_PERIOD = 24  # samples per period of the fastest sine while planning: between them it is 1 % higher at most


@final
@dataclass(frozen=True)
class Task:
    """What a motion is judged by.

    sign: s. std: (6,) [N, N·m] of a sample of the wrench at `rate_hz`. prior: what is known before, as the dynamic
    stage takes it. rated: (6,) [N, N·m], inf where unknown.
    """

    arm: Arm
    series: Series
    limits: JointLimits
    caps: Sequence[Cap]
    sign: int
    std: Array
    rate_hz: float
    prior: Prior
    rated: Array

    @cached_property
    def time(self) -> Array:
        count = PER_PERIOD * self.series.harmonics
        return np.arange(count) * self.series.duration / count

    @cached_property
    def columns(self) -> Array:
        return self.series.columns(self.time)

    def covariance(self, state: Array) -> Array:
        """(16, 16) of [Φ, F_0] with the prior, where the states (T, 9) stand for a whole period at `rate_hz`.

        Noise of the wrench alone, white: the information of the dynamic stage's LS.
        """
        A = self._rows(state)
        share = self.rate_hz * self.series.duration / len(state)
        H = share * np.einsum("tip,tiq->pq", A, A, optimize=True) + prior_information(self.prior)
        size = np.sqrt(np.diag(H))  # columns of one length: without gravity the digits of H are few
        return np.asarray(np.linalg.inv(H / np.outer(size, size)) / np.outer(size, size))

    def _rows(self, state: Array) -> Array:
        A = self.sign * wrench_columns(state[:, :3], state[:, 3:6], state[:, 6:])
        return np.concatenate([A, np.broadcast_to(np.eye(6), (len(A), 6, 6))], axis=2) / self.std[:, None]

    def cost(self, moving: Moving, *, gravity: bool = True) -> tuple[float, Array]:
        """Mean of ln of the ten standard deviations of Φ, and its slopes (T, 9) by the state.

        gravity: False leaves it out of the regressor, as (38) and (40) do. Implements [Payload] (37)-(40). Differs from
        print: gravity counts; standard deviations stand for the condition number of CᵀC, which is that of C squared
        and changes with the units of the columns.
        """
        state = moving.state
        if not gravity:
            state = state.copy()
            state[:, :3] += np.einsum("tji,j->ti", moving.rotation, self.arm.gravity)
        C = self.covariance(state)
        share = self.rate_hz * self.series.duration / len(state)
        weight = np.zeros(16)
        weight[:10] = 1.0 / np.diag(C)[:10] / 10.0
        M = (C * weight) @ C
        G = (self._rows(state) @ M)[:, :, :10] * (-share * self.sign / self.std[:, None])
        slopes = np.einsum("tip,ktip->tk", G, regressor_slopes(state[:, 6:]), optimize=True)
        return float(0.05 * np.sum(np.log(np.diag(C)[:10]))), slopes

    def strain(self, q: Array, dq: Array, ddq: Array, moving: Moving) -> Array:
        """(T, m) shares of the bounds: 1 is at a bound, beyond is outside. Workspace: 1 minus the margin.

        Implements [Payload] (42) sample by sample. Differs from print: q_0 ± Σ is what must lie within both limits, and
        |q| ≤ |Σ + q_0| does not hold; torques, the sensor's range and inclined limits are bounds too.
        """
        low, high, speed, acceleration, torque = self._bounds()
        middle, half = (low + high) / 2, (high - low) / 2
        F = self.arm.wrench(moving, self.sign)
        known = np.isfinite(torque)
        both = np.hstack([
            (q - middle) / half, dq / speed, ddq / acceleration, moving.torque[:, known] / torque[known],
            F[:, np.isfinite(self.rated)] / self.rated[np.isfinite(self.rated)],
        ])  # fmt: skip
        room = [1.0 - cap.margins(moving.rotation[:, :, cap.axis])[0] for cap in self.caps]
        return np.hstack([both, -both, *room])

    def strain_slopes(self, moving: Moving) -> Array:
        """(T, m, n, 3) of `strain` by q, q̇, q̈."""
        assert moving.state_slopes is not None
        assert moving.torque_slopes is not None
        assert moving.axis_slopes is not None
        low, high, speed, acceleration, torque = self._bounds()
        T, n = len(moving.state), len(self.arm.moved)
        linear = np.zeros((T, 3 * n, n, 3))
        for k, size in enumerate(((high - low) / 2, speed, acceleration)):
            linear[:, np.arange(k * n, k * n + n), np.arange(n), k] = 1.0 / size
        known, rated = np.isfinite(torque), np.isfinite(self.rated)
        by_state = self.sign * np.einsum(
            "ktip,p->tik", regressor_slopes(moving.state[:, 6:]), self.arm.component.phi
        )  # fmt: skip
        F = np.einsum("tik,tknd->tind", by_state, moving.state_slopes)
        both = np.concatenate([
            linear, moving.torque_slopes[:, known] / torque[known, None, None],
            F[:, rated] / self.rated[rated, None, None],
        ], axis=1)  # fmt: skip
        room = []
        for cap in self.caps:
            by_axis = cap.margins(moving.rotation[:, :, cap.axis])[1]
            slopes = np.zeros((T, by_axis.shape[1], n, 3))
            slopes[..., 0] = -np.einsum("tci,tin->tcn", by_axis, moving.axis_slopes[:, :, cap.axis])
            room.append(slopes)
        return np.concatenate([both, -both, *room], axis=1)

    def largest(self, x: Array, rate_hz: float = USUAL.check_hz) -> float:
        """Share of the bound that is nearest, at any sample of a period. x: (n, 2N-2)."""
        time = np.arange(round(rate_hz * self.series.duration) + 1) / rate_hz
        q, dq, ddq = self.series.motion(x, time)
        return float(self.strain(q, dq, ddq, self.arm.moving(q, dq, ddq)).max())

    def std_of(self, x: Array) -> Array:
        """(16,) of [Φ, F_0] after the motion x, of white noise of the wrench alone."""
        q, dq, ddq = self.series.motion(x, self.time)
        return np.sqrt(np.diag(self.covariance(self.arm.moving(q, dq, ddq).state)))

    def _bounds(self) -> tuple[Array, Array, Array, Array, Array]:
        limits, moved = self.limits, self.arm.moved
        return (limits.lower[moved], limits.upper[moved], limits.velocity[moved], limits.acceleration[moved],
                limits.torque)  # fmt: skip


@final
@dataclass(frozen=True)
class Excitation:
    """x: (n, 2N-2) numbers of the series. cost: mean ln of the standard deviations of Φ. strain: largest share of a
    bound at 1 kHz. smaller: whether it was shrunk towards home until nothing touches."""

    x: Array
    cost: float
    strain: float
    smaller: bool = False


def random_motion(task: Task, rng: np.random.Generator, share: float = 1.0) -> Array:
    """(n, 2N-2) of random numbers about home, with `share` of the largest amplitude that no bound forbids.

    Raises NotIdentifiable where home itself is outside.
    """
    n, size = len(task.arm.moved), task.series.size
    x = rng.standard_normal((n, size))
    x[:, -1] = task.arm.home[task.arm.moved]
    still = np.zeros((n, size))
    still[:, -1] = x[:, -1]
    if task.largest(still, 1.0) > 1.0:
        raise NotIdentifiable(
            "the home posture is outside the bounds while nothing moves: choose another, or see to its limits, "
            "torques, workspace and the sensor's range", ("Ixx", "Iyy", "Izz"),
        )  # fmt: skip
    rate = len(task.time) / task.series.duration
    most = largest_within(lambda part: task.largest(still + part * (x - still), rate) <= 1.0, USUAL.halvings)
    return within(task, still + share * most * (x - still))


def excite(
    task: Task, rng: np.random.Generator, starts: int = 4, *, gravity: bool = True,
    progress: Callable[[float, str], None] = lambda fraction, phrase: None,
) -> list[Excitation]:  # fmt: skip
    """Motions from several starts, best first; those that collide are shrunk towards home until they do not.

    gravity: False plans by the criterion without it. Raises NotIdentifiable.
    """
    found = []
    for k in range(starts):
        progress(k / starts, f"start {k + 1} of {starts}")
        x = improve(task, random_motion(task, rng, 0.8), gravity=gravity)
        smaller = touches(task, x)
        if smaller:
            x = within(task, x, clear=True)
        found.append(Excitation(x, float(np.mean(np.log(task.std_of(x)[:10]))), task.largest(x), smaller))
    progress(1.0, "done")
    return sorted(found, key=lambda each: each.cost)


def improve(task: Task, x: Array, *, gravity: bool = True) -> Array:
    """From a start x (n, 2N-2): the motion of least cost near it, within all bounds at 1 kHz."""
    scale = np.concatenate([np.ones(x.shape[1] - 1) * max(float(np.abs(x[:, :-1]).max()), 1e-3), [0.3]])

    def at(x: Array, dear: float) -> tuple[float, Array]:
        return point(task, x, dear, gravity=gravity)

    return within(task, descend(at, x, scale, USUAL.costs, USUAL.steps))


def touches(task: Task, x: Array) -> bool:
    """Whether anything collides on the way."""
    q, _, _ = task.series.motion(x, task.time)
    return bool(task.arm.collides(q).any())


def within(task: Task, x: Array, *, clear: bool = False) -> Array:
    """As it is, or shrunk towards home and rest, which are within every bound, until it is too, at 1 kHz. clear: and
    until nothing collides."""

    def inside(x: Array) -> bool:
        return task.largest(x) <= 1.0 and not (clear and touches(task, x))

    if inside(x):
        return x
    still = np.zeros_like(x)
    still[:, -1] = task.arm.home[task.arm.moved]
    return still + part_within(lambda part: inside(still + part * (x - still)), USUAL.halvings) * (x - still)


def point(task: Task, x: Array, dear: float, *, gravity: bool = True) -> tuple[float, Array]:
    """Cost, with the squares of excesses at that price, and its exact gradient (n, 2N-2). x: (n, 2N-2)."""
    q, dq, ddq = np.einsum("ktp,np->ktn", task.columns, x)
    moving = task.arm.moving(q, dq, ddq, slopes=True)
    assert moving.state_slopes is not None
    cost, by_state = task.cost(moving, gravity=gravity)
    slopes = moving.state_slopes
    if not gravity:
        slopes = slopes.copy()  # of Rᵀg: g turns against the joints
        assert moving.axis_slopes is not None
        slopes[:, :3, :, 0] += np.einsum("tjin,j->tin", moving.axis_slopes, task.arm.gravity)
    by_motion = np.einsum("ts,tsnk->tnk", by_state, slopes)
    excess = np.maximum(task.strain(q, dq, ddq, moving) - USUAL.kept, 0.0)
    cost += dear * float(np.sum(excess**2)) / len(excess)
    by_motion += 2.0 * dear / len(excess) * np.einsum("tm,tmnk->tnk", excess, task.strain_slopes(moving))
    return cost, np.asarray(np.einsum("tnk,ktp->np", by_motion, task.columns))
