"""The motion nearest to what is asked that keeps within every bound: sequential quadratic programs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import pinocchio as pin
import piqp
from numpy.typing import NDArray
from scipy.interpolate import interp1d
from scipy.sparse import coo_matrix, csc_matrix, diags

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.errors import BadMotion, Fault
from exogauge.motion.plan.asked import Asked, on_its_feet
from exogauge.motion.plan.clear import cleared
from exogauge.motion.plan.rows import Watched, bounds, equations, shares, slopes, watch
from exogauge.motion.plan.spline import Spline, controls_of, through
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.strain import EVENLY
from exogauge.robots.moving.touching import Pairs

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Round:
    """part: of `parts` stretches, one after the other. step: largest of the round before [rad or m]. strays: of a
    standing foot [m or rad]. floats: share of the weight that no foot carries, or lever [m]. excess: share of a bound.
    off: the worst of them, in times of what the last round may be off.
    """

    part: int
    parts: int
    number: int
    step: float
    strays: float
    floats: float
    excess: float
    off: float


@final
@dataclass(frozen=True)
class Planned:
    """wrench: (N, F, 6) [N, N·m] of the world on each foot at the nodes. excess: (N,) share of a bound by which the
    worst of each node is exceeded. rounds: of the solver, of the stretch that took most. last_step: of the last ones
    [rad or m]. unsettled: [s] stretches whose rounds came to no end: feet, dynamics, bounds may be off.
    stands: (N, F), None where all feet stand."""

    spline: Spline
    wrench: Array
    excess: Array
    rounds: int
    last_step: float
    unsettled: tuple[tuple[float, float], ...] = ()
    stands: BoolArray | None = None

    def standing(self, time: Array) -> BoolArray:
        """(T, F) at times (T,): a foot stands from the node before the one at which it bears to the one after."""
        if self.stands is None:
            return np.ones((len(time), self.wrench.shape[1]), dtype=bool)
        at = np.clip(time / self.spline.step, 0.0, len(self.stands) - 1.0)
        return np.asarray(self.stands[np.floor(at + 1e-9).astype(int)] | self.stands[np.ceil(at - 1e-9).astype(int)])

    def still(self, time: Array) -> BoolArray:
        """(T, F) likewise: it is led to its place by then."""
        return self.standing(time)

    def between(self, begin: int, end: int) -> Planned:
        """From node `begin` to node `end`, both in it, as a guess: nothing is exceeded, no round was made."""
        spline = replace(self.spline, control=self.spline.control[begin : end + 3])
        return Planned(spline, self.wrench[begin : end + 1], np.zeros(end + 1 - begin), 0, np.inf)

    def loads(self, time: Array) -> Array:
        """(T, 6 F) [N, N·m] of the wrenches at times (T,), straight between nodes."""
        nodes = self.spline.step * np.arange(len(self.wrench))
        whole = interp1d(nodes, self.wrench.reshape(len(nodes), -1), axis=0)
        return np.asarray(whole(np.minimum(time, nodes[-1])))


Report = Callable[[Round], None]
Stop = Callable[[Planned], bool]


def plan(
    robot: MotionRobot, asked: Asked, criteria: MotionPlan = USUAL, report: Report | None = None,
    stop: Stop | None = None, start: Planned | None = None,
) -> Planned:  # fmt: skip
    """Stretch by stretch, each with a look ahead that the next one plans anew; at rest at both ends, in the postures
    that are asked there. report: told before each round. stop: asked of what was found of a stretch, on the coarse
    nodes and on all; where it says so the plan ends. start: a plan on the same nodes whose bounds were a little others:
    it is gone on from, on all nodes.

    Raises BadMotion where no posture keeps the feet where they stand, or where it was stopped.
    """
    pairs = Pairs(robot, criteria.clearance_m)
    home = np.tile(asked.q[0], (3, 1)), np.tile(asked.q[-1], (3, 1))
    asked = cleared(robot, asked, pairs, criteria)
    last = len(asked.q) - 1
    long, ahead = (round(each / asked.step) for each in (criteria.stretch_s, criteria.ahead_s))
    parts = max(1, math.ceil((last - ahead) / long))
    begins = [last * k // parts for k in range(parts)] if last > long + ahead else [0]
    control, wrench = np.empty((last + 3, robot.model.nq)), np.empty((last + 1, len(robot.soles), 6))
    excess, rounds, step = np.empty(last + 1), 0, 0.0
    unsettled = list[tuple[float, float]]()
    for k, begin in enumerate(begins):
        end = last if k == len(begins) - 1 else min(begins[k + 1] + ahead, last)
        ends = _Ends(control[begin : begin + 3] if k else home[0], 2 if k else 1, home[1] if end == last else None)
        span = begin * asked.step, end * asked.step

        def tell(now: Round, part: int = k) -> None:
            if report is not None:
                report(replace(now, part=part, parts=len(begins)))

        def check(made: Planned, span: tuple[float, float] = span) -> None:
            if stop is not None and stop(made):
                raise BadMotion(Fault("not every bound can be kept from {:.2f} to {:.2f} s".format(*span), "not_kept",
                                      "Slow it down, or ask for less of the trunk's angle", robot.name))  # fmt: skip

        near = None if start is None else start.between(begin, end)
        made = _stretch(robot, asked.between(begin, end), ends, pairs, criteria, tell, check, near)
        if made.unsettled:
            unsettled.append(span)
        control[begin : end + 3], wrench[begin : end + 1], excess[begin : end + 1] = (
            made.spline.control, made.wrench, made.excess
        )  # fmt: skip
        rounds, step = max(rounds, made.rounds), max(step, made.last_step)
    return Planned(Spline(control, asked.step), wrench, excess, rounds, step, tuple(unsettled), asked.stands)


@final
@dataclass(frozen=True)
class _Ends:
    """first: (3, n) control points that are given; led: node from which on the feet are. last: (3, n) likewise, None
    where the motion goes on. Three that are the same are rest there."""

    first: Array
    led: int
    last: Array | None


def _stretch(
    robot: MotionRobot, asked: Asked, ends: _Ends, pairs: Pairs, criteria: MotionPlan, report: Report,
    check: Callable[[Planned], None], near: Planned | None,
) -> Planned:  # fmt: skip
    """First on every `coarse`-th node, which is cheap and finds the way round what is in the way; then on all, unless
    that was given up. From a plan that is near on all at once."""
    if near is not None:
        found = _settle(robot, asked, near, ends, pairs, criteria, report)
        check(found)
        return found
    rough = asked.every(criteria.coarse)
    begin = rough.q.copy()
    begin[:, robot.base :] = np.clip(begin[:, robot.base :], robot.limits.lower, robot.limits.upper)
    q = np.stack([on_its_feet(robot, *each) for each in zip(begin, rough.place, strict=True)])
    spline = through(q, rough.step)
    q_0, v_0, a_0 = (each[0] for each in Spline(ends.first, asked.step).at_nodes())
    starts = replace(ends, first=controls_of(q_0, v_0, a_0, rough.step))
    first = Planned(spline, np.zeros((len(q), len(robot.soles), 6)), np.zeros(len(q)), 0, np.inf)
    loose = replace(
        criteria, **{key: criteria.loosely * getattr(criteria, key) for key in ("done_rad", "held", "floats")}
    )
    first = _settle(robot, rough, first, starts, pairs, loose, report)
    check(first)
    control, count = first.spline.refined(criteria.coarse).control, len(asked.q)
    time = asked.time
    guess = Planned(
        Spline(control[: count + 2], asked.step), first.loads(time).reshape(count, -1, 6),
        np.interp(time, rough.time, first.excess), first.rounds, first.last_step, first.unsettled,
    )  # fmt: skip
    if first.unsettled and first.rounds < criteria.rounds:  # where they ran out, they were still coming nearer
        return guess
    found = _settle(robot, asked, replace(guess, excess=np.zeros(count)), ends, pairs, criteria, report)
    check(found)
    return found


def _settle(
    robot: MotionRobot, asked: Asked, guess: Planned, ends: _Ends, pairs: Pairs, criteria: MotionPlan, report: Report
) -> Planned:
    """Round after round from a guess, until one is good enough, or for `patience` rounds none came nearer to it."""
    N, n, F = len(asked.q), robot.model.nq, len(robot.soles)
    spline, wrench, excess, rounds = guess.spline, guess.wrench, guess.excess, 0
    weight, size = robot.weight, np.inf
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
    low[:, robot.base : n], high[:, robot.base : n] = robot.limits.lower, robot.limits.upper
    for given in [slice(3)] + ([] if ends.last is None else [slice(-3, None)]):
        low[given, robot.base : n], high[given, robot.base : n] = -np.inf, np.inf
    settled = np.ones_like(asked.stands)  # where the feet can be moved
    settled[: ends.led] = False
    still = 1.0 if wrench.any() else 0.0  # weight of staying near the round before; a plan is near to what is sought
    missed, last = np.inf, np.inf  # how far the round before was astray; its step
    kept, nearest = None, (spline, wrench, excess)  # of the round before, with its slopes; of the one that lacks least
    lacked = np.inf
    least, since = (np.inf, np.inf), 0  # of what is wrong and of the step; the round that last came nearer
    watched = Watched()
    whole = ((0.0, float(asked.time[-1])),)
    while True:
        slope = slopes(robot, asked, spline, wrench)
        used = shares(robot, spline, slope, pairs, criteria)
        watch(used, watched, criteria)  # of a round that is not kept, too
        strays = float(np.abs(slope.error[settled]).max(initial=0.0))
        floats = float(np.abs(slope.torque[:, : robot.base]).max(initial=0.0)) / weight
        over = float((used.beyond - np.maximum(excess, 0.0)).max())  # more than the equations said
        astray = strays + floats  # from what slopes promised; a bound that stood in no equation was not promised
        lacks = max(strays / criteria.held, floats / criteria.floats, over / criteria.over)
        held, off = lacks < 1.0, max(lacks, size / criteria.done_rad)
        report(Round(0, 1, guess.rounds + rounds, size, strays, floats, float(excess.max()), off))
        if off < 1.0:
            return Planned(spline, wrench, excess, guess.rounds + rounds, size)
        if lacks < criteria.nearer * least[0] or size < criteria.nearer * least[1]:
            least, since = (min(lacks, least[0]), min(size, least[1])), rounds
        if max(lacks, float(excess.max()) / criteria.over) < lacked:
            lacked, nearest = max(lacks, float(excess.max()) / criteria.over), (spline, wrench, excess)
        if rounds >= criteria.rounds or rounds - since >= criteria.patience:
            return Planned(*nearest, guess.rounds + rounds, size, whole)
        if kept and astray > max(criteria.far_off * missed, 0.5) and still < criteria.stillest:
            spline, wrench, excess, slope, used = kept  # slopes promised what is not there: again, nearer to what was
            still, rounds = min(max(8.0 * still, 1.0), criteria.stillest), rounds + 1
        else:
            if missed < np.inf:
                stuck = size > 0.5 * last if held else astray > 0.5 * missed
                still = min(max(8.0 * still, 1.0), criteria.stillest) if stuck else still / 2.0
            missed, last = astray, size
        kept = spline, wrench, excess, slope, used
        A, b = equations(robot, asked, spline, wrench, slope, ends.first, ends.led, ends.last)
        G, h = bounds(robot, asked, spline, wrench, slope, used, pairs, criteria, watched)
        stages = np.zeros((N + 2, wide))
        stages[:, :n] = spline.control
        near = still / criteria.pelvis_m**2 * ours
        x, status = _solve(
            csc_matrix(P + diags(near)), c - near * stages.ravel(), A, b, G, h, low.ravel(), high.ravel()
        )
        if x is None and not rounds and still < criteria.stillest:  # by round-off, where all is dear: nearer to it
            still = min(max(8.0 * still, 1.0), criteria.stillest)
            continue
        if x is None and rounds:  # slopes promised more than there is: what was reached is judged
            return Planned(*nearest, guess.rounds + rounds, size)
        if x is None:
            raise BadMotion(Fault(f"no motion keeps the feet where they stand ({status})", "no_motion",
                                  "Give a home posture with bent knees, or cut the motion", robot.name))  # fmt: skip
        x = x.reshape(N + 2, wide)
        size = float(np.abs(x[:, :n] - spline.control).max())
        spline = Spline(x[:, :n], asked.step)
        wrench = x[1:-1, n : n + 6 * F].reshape(N, F, 6) * weight
        excess = x[1:-1, -1]
        rounds += 1


def _cost(robot: MotionRobot, asked: Asked, criteria: MotionPlan) -> tuple[csc_matrix, Array]:
    """½ xᵀP x + cᵀx over all stages: what is asked, smoothly; wrenches small, and as even as may be; slack dear."""
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
    rows.append(spare)
    cols.append(spare)
    values.append(np.tile(np.tile(EVENLY, F) * criteria.wrench**2, N) ** -1.0)
    both = 1 + np.flatnonzero(asked.stands.all(axis=1))
    uneven = _uneven(asked.place[both[0] - 1]) / criteria.uneven**2
    row, column = np.nonzero(np.abs(uneven) > 1e-9 * np.abs(uneven).max())
    rows.append((both[:, None] * wide + n + row).ravel())
    cols.append((both[:, None] * wide + n + column).ravel())
    values.append(np.tile(uneven[row, column], len(both)))
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


def _uneven(place: Sequence[pin.SE3]) -> Array:
    """(6 F, 6 F) what feet at their places press against each other, in squares: all that bears nothing. Wrenches that
    are as even as can be have none of it, wherever the body is."""
    W = np.diag(1.0 / np.tile(EVENLY, len(place)))
    A = np.hstack([at.toDualActionMatrix() for at in place])
    return np.asarray(W - A.T @ np.linalg.inv(A @ np.linalg.inv(W) @ A.T) @ A)


def _solve(
    P: csc_matrix, c: Array, A: csc_matrix, b: Array, G: csc_matrix, h: Array, low: Array, high: Array
) -> tuple[Array | None, str]:
    """Bounds yield to their slack, so that none makes it infeasible: where that is said, round-off says it, and more
    regularisation finds the same."""
    status = None
    for rho, delta, least in ((1e-6, 1e-4, 1e-10), (1e-4, 1e-3, 1e-8)):  # the solver's own, then more
        solver = piqp.SparseSolver()
        settings = solver.settings
        settings.kkt_solver = piqp.sparse_multistage  # stage by stage: cost is linear in the length
        settings.rho_init, settings.delta_init, settings.reg_lower_limit = rho, delta, least
        settings.eps_abs, settings.eps_rel = 1e-2, 1e-8  # of slopes; what is asked for holds to 1e-9 by then
        settings.eps_duality_gap_abs = 0.5  # an angle off by its stray at one node costs as much
        settings.max_iter = 40  # a first round, far from any posture that stands, may end here; it goes on from there
        solver.setup(P, c, A, b, G, None, h, low, high)
        status = solver.solve()
        if status in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED):
            return np.array(solver.result.x), ""  # a view would keep the solver and all that it holds
    return None, str(status)
