"""The motion nearest to what is asked that keeps within every bound: sequential quadratic programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
import piqp
from numpy.typing import NDArray
from scipy.interpolate import interp1d
from scipy.sparse import coo_matrix, csc_matrix, diags

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.errors import BadMotion, Fault
from exogauge.motion.plan.asked import Asked, on_its_feet
from exogauge.motion.plan.rows import bounds, equations, slopes
from exogauge.motion.plan.spline import Spline, through
from exogauge.motion.robot import MotionRobot

Array = NDArray[np.float64]

STILLEST = 64.0  # times the pelvis' own weight: steps are then a hundredth of what the equations say


@final
@dataclass(frozen=True)
class Round:
    """step: largest of the round before [rad or m]. strays: of a standing foot [m or rad]. floats: share of the weight
    that no foot carries, or lever [m]. excess: share of a bound."""

    number: int
    step: float
    strays: float
    floats: float
    excess: float


@final
@dataclass(frozen=True)
class Planned:
    """wrench: (N, F, 6) [N, N·m] of the world on each foot at the nodes. excess: (N,) share of a bound by which the
    worst of each node is exceeded. rounds: of the solver. last_step: of its last [rad or m]."""

    spline: Spline
    wrench: Array
    excess: Array
    rounds: int
    last_step: float

    def loads(self, time: Array) -> Array:
        """(T, 6 F) [N, N·m] of the wrenches at times (T,), straight between nodes."""
        nodes = self.spline.step * np.arange(len(self.wrench))
        whole = interp1d(nodes, self.wrench.reshape(len(nodes), -1), axis=0)
        return np.asarray(whole(np.minimum(time, nodes[-1])))


def plan(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, report: Callable[[Round], None] | None = None
) -> Planned:
    """report: told before each round. Raises BadMotion where no posture keeps the feet where they stand."""
    N, n, F = len(asked.q), robot.model.nq, len(robot.soles)
    q = np.stack([on_its_feet(robot, asked.q[t], asked.place[t], asked.stands[t]) for t in range(N)])
    spline = through(q, asked.step)
    weight = robot.weight
    wrench = np.zeros((N, F, 6))
    wide = n + 6 * F + 1
    P, c = _cost(robot, asked, criteria)
    low, high = np.full((N + 2, wide), -np.inf), np.full((N + 2, wide), np.inf)
    low[:, -1] = 0.0
    swings = np.repeat(~asked.stands, 6, axis=1)
    for bound in (low, high):
        bound[[0, -1], n:] = 0.0
        bound[1:-1, n : n + 6 * F][swings] = 0.0
    ours = np.zeros((N + 2, wide))
    ours[:, :n] = 1.0
    ours = ours.ravel()
    excess, size, rounds = np.zeros(N), np.inf, 0
    low[:, robot.base : n], high[:, robot.base : n] = robot.limits.lower, robot.limits.upper
    still, missed = 0.0, np.inf  # weight of staying near the round before; how far that one was off
    while True:
        slope = slopes(robot, asked, spline, wrench)
        strays = float(np.abs(slope.error[asked.stands]).max(initial=0.0))
        floats = float(np.abs(slope.torque[:, : robot.base]).max(initial=0.0)) / weight
        if report is not None:
            report(Round(rounds, size, strays, floats, float(excess.max())))
        held = strays < criteria.held and floats < criteria.floats
        if rounds == criteria.rounds or (held and size < criteria.done_rad):
            return Planned(spline, wrench, excess, rounds, size)
        if missed < np.inf:
            still = min(max(8.0 * still, 1.0), STILLEST) if strays + floats > 0.5 * missed and not held else still / 8.0
        missed = strays + floats
        A, b = equations(robot, asked, spline, wrench, slope)
        G, h = bounds(robot, asked, spline, wrench, slope, criteria)
        stages = np.zeros((N + 2, wide))
        stages[:, :n] = spline.control
        near = still / criteria.pelvis_m**2 * ours
        x = _solve(
            robot, csc_matrix(P + diags(near)), c - near * stages.ravel(), A, b, G, h, low.ravel(), high.ravel()
        ).reshape(N + 2, wide)
        size = float(np.abs(x[:, :n] - spline.control).max())
        spline = Spline(x[:, :n], asked.step)
        wrench = x[1:-1, n : n + 6 * F].reshape(N, F, 6) * weight
        excess = x[1:-1, -1]
        rounds += 1


def _cost(robot: MotionRobot, asked: Asked, criteria: MotionPlan) -> tuple[csc_matrix, Array]:
    """½ xᵀP x + cᵀx over all stages: what is asked, smoothly; wrenches small; slack dear."""
    N, n, F, h = len(asked.q), robot.model.nq, len(robot.soles), asked.step
    wide = n + 6 * F + 1
    node = np.arange(N)
    value, curve = (
        csc_matrix((np.repeat(each, N), (np.tile(node, 3), np.concatenate([node, node + 1, node + 2]))), (N, N + 2))
        for each in (np.array([1.0, 4.0, 1.0]) / 6.0, np.array([1.0, -2.0, 1.0]) / h**2)
    )
    inverse = np.where(np.isfinite(asked.stray), 1.0 / asked.stray, 0.0) ** 2
    smooth = (1.0 / np.minimum(asked.stray, criteria.free_rad)) ** 2 / (2.0 * np.pi * criteria.smooth_hz) ** 4
    close, even = coo_matrix(value.T @ value), coo_matrix(curve.T @ curve)
    columns = np.arange(n)
    rows, cols, values = [], [], []
    for part, each in ((close, inverse), (even, smooth)):
        rows.append((part.row[:, None] * wide + columns).ravel())
        cols.append((part.col[:, None] * wide + columns).ravel())
        values.append((part.data[:, None] * each).ravel())
    stage = np.arange(1, N + 1)
    spare = (stage[:, None] * wide + n + np.arange(6 * F)).ravel()
    shares = np.tile(np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1]) * criteria.wrench, N * F)
    rows.append(spare)
    cols.append(spare)
    values.append(shares**-2.0)
    slack = np.arange(N + 2) * wide + wide - 1
    rows.append(slack)
    cols.append(slack)
    values.append(np.full(N + 2, criteria.slack_cost))
    size = (N + 2) * wide
    P = csc_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), shape=(size, size))
    c = np.zeros((N + 2, wide))
    c[:, :n] = -(value.T @ (asked.q * inverse))
    c[:, -1] = criteria.slack_cost
    return P, c.ravel()


def _solve(
    robot: MotionRobot, P: csc_matrix, c: Array, A: csc_matrix, b: Array, G: csc_matrix, h: Array, low: Array,
    high: Array,
) -> Array:  # fmt: skip
    solver = piqp.SparseSolver()
    solver.settings.kkt_solver = piqp.sparse_multistage  # stage by stage: cost is linear in the length
    solver.settings.eps_abs, solver.settings.eps_rel = 1e-6, 1e-8
    solver.settings.max_iter = (
        40  # a first round, far from any posture that stands, may end here; it goes on from there
    )
    solver.setup(P, c, A, b, G, np.full(len(h), -np.inf), h, low, high)
    status = solver.solve()
    if status not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED):
        raise BadMotion(Fault(f"no motion keeps the feet where they stand ({status})", "no_motion",
                              "Give a home posture with bent knees, or cut the motion", robot.name))  # fmt: skip
    return np.asarray(solver.result.x)
