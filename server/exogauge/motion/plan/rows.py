"""The robot's equations and bounds at every node, made linear about a trajectory."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.sparse import csc_matrix

from exogauge.criteria.motion_plan import HALF_FOOT_M, MotionPlan
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.spline import Spline
from exogauge.robots.moving.robot import MotionRobot, Sole
from exogauge.robots.moving.touching import Near, Pairs

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]
Watched = dict[tuple[str, float], NDArray[np.bool_]]
"""By kind and sign of a bound, (nodes, J) where it was near."""


@final
@dataclass(frozen=True)
class Slopes:
    """At N nodes. torque: (N, n) by rnea with the feet's wrenches. by_q, by_v, by_a: (N, n, n). feet: (N, F, 6, n) of
    the soles' links, in their own axes. error: (N, F, 6) from where they should stand, likewise."""

    torque: Array
    by_q: Array
    by_v: Array
    by_a: Array
    feet: Array
    error: Array


def slopes(robot: MotionRobot, asked: Asked, spline: Spline, wrench: Array) -> Slopes:
    """wrench: (N, F, 6) [N, N·m] of the world on each foot, at and in the axes of its link."""
    model, data = robot.model, robot.data
    q, v, a = spline.at_nodes()
    N, n, F = len(q), model.nq, len(robot.soles)
    torque, by = np.empty((N, n)), np.empty((3, N, n, n))
    feet, error = np.zeros((N, F, 6, n)), np.zeros((N, F, 6))
    frames = [model.frames[robot.frame(sole.link)] for sole in robot.soles]
    outside = pin.StdVec_Force()
    outside.extend([pin.Force.Zero()] * model.njoints)
    for t in range(N):
        for f, frame in enumerate(frames):
            outside[frame.parentJoint] = frame.placement.act(pin.Force(wrench[t, f]))
        pin.computeRNEADerivatives(model, data, q[t], v[t], a[t], outside)
        torque[t], by[0, t], by[1, t], by[2, t] = data.tau, data.dtau_dq, data.dtau_dv, data.M
        pin.computeJointJacobians(model, data, q[t])
        for f, sole in enumerate(robot.soles):
            index = robot.frame(sole.link)
            feet[t, f] = pin.getFrameJacobian(model, data, index, pin.LOCAL)
            error[t, f] = pin.log6(asked.place[t][f].inverse() * pin.updateFramePlacement(model, data, index)).vector
    upper = np.triu(by[2])
    by[2] = upper + np.swapaxes(np.triu(by[2], 1), 1, 2)
    return Slopes(torque, by[0], by[1], by[2], feet, error)


def sole_rows(sole: Sole, friction: float, margin: float) -> Array:
    """(R, 6): rows · wrench of the world on the foot ≤ 0 where it stands: friction, and the centre of pressure inside
    the outline less the margin [m].

    A pyramid inside the cone; a moment about the normal is held by friction within the outline's half width.
    """
    R, at = sole.axes, sole.middle
    to_sole = np.zeros((6, 6))
    to_sole[:3, :3] = to_sole[3:, 3:] = R.T
    to_sole[3:, :3] = -R.T @ pin.skew(at)
    flat = (sole.outline - at) @ R[:, :2]
    rows = []
    mu = friction / np.sqrt(2.0)
    for axis in (0, 1):
        for sign in (1.0, -1.0):
            row = np.zeros(6)
            row[axis], row[2] = sign, -mu
            rows.append(row)
    inward = []
    for a, b in zip(flat, np.roll(flat, -1, axis=0), strict=True):
        along = (b - a) / np.linalg.norm(b - a)
        normal = np.array([-along[1], along[0]])
        normal *= np.sign(normal @ (flat.mean(axis=0) - a))
        inward.append(-float(normal @ a))  # of the middle, from the edge
        row = np.zeros(6)  # normal · cop ≥ normal · a + margin, cop = (-m_y, m_x) / f_z
        row[3], row[4], row[2] = -normal[1], normal[0], normal @ a + margin
        rows.append(row)
    for sign in (1.0, -1.0):
        row = np.zeros(6)
        row[5], row[2] = sign, -friction * min(inward)
        rows.append(row)
    return np.stack(rows) @ to_sole


@final
@dataclass
class Rows:
    """Sparse rows over the unknowns of all stages: control point (n), wrenches (6 F), slack (1) of each, in turn."""

    wide: int
    stages: int
    row: list[IntArray] = field(default_factory=list)
    column: list[IntArray] = field(default_factory=list)
    value: list[Array] = field(default_factory=list)
    bound: list[Array] = field(default_factory=list)
    count: int = 0

    def add(self, parts: list[tuple[IntArray, IntArray, Array]], bound: Array) -> None:
        """bound: (B,). parts: (stage (B,), columns (B, C) or (C,), value (B, C))."""
        rows = self.count + np.arange(len(bound))
        for stage, columns, value in parts:
            at = stage[:, None] * self.wide + columns
            self.row.append(np.broadcast_to(rows[:, None], value.shape).ravel())
            self.column.append(np.broadcast_to(at, value.shape).ravel())
            self.value.append(value.ravel())
        self.bound.append(bound)
        self.count += len(bound)

    def matrix(self) -> tuple[csc_matrix, Array]:
        if not self.count:
            return csc_matrix((0, self.wide * self.stages)), np.zeros(0)
        value, row, column = (np.concatenate(each) for each in (self.value, self.row, self.column))
        kept = value != 0.0
        entries = (value[kept], (row[kept], column[kept]))
        return csc_matrix(entries, shape=(self.count, self.wide * self.stages)), np.concatenate(self.bound)


def spread(node: IntArray, by_q: Array, by_v: Array, by_a: Array, h: float) -> list[tuple[IntArray, Array]]:
    """Rows (B, n) by q, q̇, q̈ at nodes (B,), as (stage, rows) by the three control points of each."""
    return [
        (node, by_q / 6.0 - by_v / (2.0 * h) + by_a / h**2),
        (node + 1, by_q * (4.0 / 6.0) - 2.0 * by_a / h**2),
        (node + 2, by_q / 6.0 + by_v / (2.0 * h) + by_a / h**2),
    ]


def equations(
    robot: MotionRobot, asked: Asked, spline: Spline, wrench: Array, slope: Slopes, first: Array | None = None,
    led: int = 0, last: Array | None = None,
) -> tuple[csc_matrix, Array]:  # fmt: skip
    """A x = b: the base is driven by the feet alone, and every foot is where it shall be.

    first, last: (3, n) control points that are given, None where none are; of three that are the same the feet's rows
    leave out the node that they make. led: node with which those rows begin. After control points of another stretch it
    is the third: from the second on they would make of a slip of round-off 3.7 times as much per node.
    """
    N, n, F = len(slope.torque), robot.model.nq, len(robot.soles)
    rows = Rows(n + 6 * F + 1, N + 2)
    q, v, a = spline.at_nodes()
    every = np.arange(n)
    if robot.floating:
        weight = robot.weight
        node = np.repeat(np.arange(N), 6)
        by = [each[:, :6].reshape(-1, n) / weight for each in (slope.by_q, slope.by_v, slope.by_a)]
        by_wrench = -np.moveaxis(slope.feet[..., :6], 3, 1).reshape(N * 6, 6 * F)
        now = sum(
            np.einsum("bn,bn->b", part, np.repeat(each, 6, axis=0)) for part, each in zip(by, (q, v, a), strict=True)
        )
        now = now + np.einsum("bw,bw->b", by_wrench, np.repeat(wrench.reshape(N, 6 * F) / weight, 6, axis=0))
        parts = [(stage, every, value) for stage, value in spread(node, by[0], by[1], by[2], spline.step)]
        parts.append((node + 1, n + np.arange(6 * F), by_wrench))
        rows.add(parts, now - slope.torque[:, :6].ravel() / weight)
    for f in range(F):
        held = slice(led, N if last is None else N - 1)
        node = np.repeat(np.arange(N)[held], 6)
        by_q = slope.feet[held, f].reshape(-1, n)
        bound = np.einsum("bn,bn->b", by_q, q[node]) - slope.error[held, f].ravel()
        moving = np.concatenate([np.arange(robot.base), robot.leg(f)])
        none = np.zeros_like(by_q)
        parts = [(stage, moving, value[:, moving]) for stage, value in spread(node, by_q, none, none, spline.step)]
        rows.add(parts, bound)
    one = np.ones((n, 1))
    for start, given in ((0, first), (N - 1, last)):
        for k, value in enumerate(() if given is None else given):
            rows.add([(np.full(n, start + k), every[:, None], one)], value)
    return rows.matrix()


@final
@dataclass(frozen=True)
class Shares:
    """Of their bounds, less what is kept for between the nodes, that are used: rate (N + 1, J) from one control point
    to the next, torque and fast (acceleration) (N, J) at the nodes, jerk (N - 1, J) between them; near: pairs of
    shapes, and apart: (B,) [m] by how much they shall be: as at home where that is less than `apart_m`.
    """

    rate: Array
    torque: Array
    fast: Array
    jerk: Array
    near: Near
    apart: Array

    @property
    def beyond(self) -> Array:
        """(N,) by which the worst of them is exceeded."""
        worst = np.maximum(np.abs(self.torque).max(axis=1), np.abs(self.fast).max(axis=1)) - 1.0
        rate, jerk = np.abs(self.rate).max(axis=1) - 1.0, np.abs(self.jerk).max(axis=1) - 1.0
        worst = np.maximum(worst, np.maximum(rate[1:], rate[:-1]))
        worst[1:], worst[:-1] = np.maximum(worst[1:], jerk), np.maximum(worst[:-1], jerk)
        np.maximum.at(worst, self.near.sample, (self.apart - self.near.distance) / HALF_FOOT_M)
        return np.asarray(np.maximum(worst, 0.0))


def shares(robot: MotionRobot, spline: Spline, slope: Slopes, pairs: Pairs, criteria: MotionPlan) -> Shares:
    """Of a trajectory."""
    q, _, a = spline.at_nodes()
    control, h, kept, limits = spline.control[:, robot.base :], spline.step, criteria.kept, robot.limits
    near = pairs.near(q, criteria.look_m)
    return Shares(
        np.diff(control, axis=0) / (h * kept * limits.velocity), slope.torque[:, robot.base :] / (kept * limits.torque),
        a[:, robot.base :] / (kept * limits.acceleration),
        np.diff(control, 3, axis=0) / (h**3 * kept * robot.jerk),
        near, np.minimum(criteria.apart_m, pairs.at_home[near.pair]),
    )  # fmt: skip


def watch(used: Shares, watched: Watched, criteria: MotionPlan) -> None:
    """Rates, accelerations, jerks and torques that are near their bounds are written to `watched`, torques for `beside`
    nodes more to either side. They stay: what is left out of one round is broken by it, and the rounds come to no end;
    a torque that was broken at one node was so at the next in the round after, along the whole motion.
    """
    for what in ("rate", "fast", "jerk", "torque"):
        for sign in (1.0, -1.0):
            near = sign * getattr(used, what) > criteria.near
            if what == "torque":
                near = maximum_filter1d(near, 2 * criteria.beside + 1, axis=0)
            watched[what, sign] = near | watched.get((what, sign), near)


def bounds(
    robot: MotionRobot, asked: Asked, spline: Spline, wrench: Array, slope: Slopes, used: Shares, pairs: Pairs,
    criteria: MotionPlan, watched: Watched,
) -> tuple[csc_matrix, Array]:  # fmt: skip
    """G x ≤ h, each row with its node's slack: what is or was near its bound, friction, pressure, weight.

    watched: as of `watch`.
    """
    N, n, F, h = len(slope.torque), robot.model.nq, len(robot.soles), spline.step
    rows = Rows(n + 6 * F + 1, N + 2)
    every, slack = np.arange(n), np.array([n + 6 * F])
    q, v, a = spline.at_nodes()
    joints = robot.base + np.arange(len(robot.joints))
    limits, kept = robot.limits, criteria.kept

    def chain(what: str, bound: Array, weights: tuple[float, ...], sign: float) -> None:
        """Differences of control points that are or were near their bound (J,)."""
        k, j = (each.astype(np.intp) for each in np.nonzero(watched[what, sign]))
        top = (sign / (kept * bound[j]))[:, None]
        parts = [(k + m, joints[j][:, None], top * w) for m, w in enumerate(weights)]
        spare = np.clip(k + len(weights) // 2, 1, N)
        rows.add([*parts, (spare, slack, -np.ones((len(k), 1)))], np.ones(len(k)))

    for sign in (1.0, -1.0):
        chain("rate", h * limits.velocity, (-1.0, 1.0), sign)
        chain("fast", h**2 * limits.acceleration, (1.0, -2.0, 1.0), sign)
        chain("jerk", h**3 * robot.jerk, (-1.0, 3.0, -3.0, 1.0), sign)
        k, j = (each.astype(np.intp) for each in np.nonzero(watched["torque", sign]))
        top = sign / (kept * limits.torque[j])[:, None]
        by = [each[k, joints[j]] * top for each in (slope.by_q, slope.by_v, slope.by_a)]
        by_wrench = -np.moveaxis(slope.feet, 3, 1)[k, joints[j]].reshape(len(k), 6 * F) * top * robot.weight
        now = sum(np.einsum("bn,bn->b", part, each[k]) for part, each in zip(by, (q, v, a), strict=True))
        now = now + np.einsum("bw,bw->b", by_wrench, wrench[k].reshape(len(k), 6 * F) / (robot.weight))
        parts = [(stage, every, value) for stage, value in spread(k, by[0], by[1], by[2], h)]
        parts += [(k + 1, n + np.arange(6 * F), by_wrench), (k + 1, slack, -np.ones((len(k), 1)))]
        rows.add(parts, 1.0 + now - sign * used.torque[k, j])
    for f, sole in enumerate(robot.soles):
        part = sole_rows(sole, criteria.friction, criteria.margin_m)
        on = np.repeat(np.flatnonzero(asked.stands[:, f]), len(part)) + 1
        value = np.tile(part, (int(asked.stands[:, f].sum()), 1)) / HALF_FOOT_M
        spare = np.full((len(value), 1), -1.0)
        rows.add([(on, n + 6 * f + np.arange(6), value), (on, slack, spare)], np.zeros(len(value)))
    if robot.floating:
        stage = np.arange(1, N + 1)
        carried = np.concatenate([np.concatenate([-sole.axes[:, 2], np.zeros(3)]) for sole in robot.soles])
        parts = [(stage, n + np.arange(6 * F), np.tile(carried, (N, 1))), (stage, slack, -np.ones((N, 1)))]
        rows.add(parts, np.full(N, -criteria.least_weight / criteria.kept))
    near = used.near
    by_q = -pairs.slopes(q, near) / HALF_FOOT_M
    left = np.maximum(near.distance - used.apart, -criteria.out_m) / HALF_FOOT_M
    left += np.einsum("bn,bn->b", by_q, q[near.sample])
    none = np.zeros_like(by_q)
    parts = [(stage, every, value) for stage, value in spread(near.sample, by_q, none, none, h)]
    rows.add([*parts, (near.sample + 1, slack, np.full((len(left), 1), -1.0))], left)
    return rows.matrix()
