"""How near a motion comes to every bound, as shares of it, and how that changes with the motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from exogauge.criteria.motion_excite import MotionExcite
from exogauge.criteria.motion_plan import HALF_FOOT_M
from exogauge.robots.moving.base import BaseTurn
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing
from exogauge.robots.moving.touching import Pairs

Array = NDArray[np.float64]
EVENLY = np.array(
    [1.0, 1.0, 1.0, 0.01, 0.01, 0.01]
)  # of a foot's forces [N] and moments [N·m] where feet share a load:
# squares of 1 N and of .1 N·m cost the same


@final
@dataclass
class Pull:
    """What a weighted sum of shares pulls at. q, v, a: (T, n) of the robot's coordinates. loads: (T, rows) of what the
    a-priori robot asks for."""

    q: Array
    v: Array
    a: Array
    loads: Array

    @classmethod
    def none(cls, samples: int, coordinates: int, rows: int) -> Pull:
        q, v, a = (np.zeros((samples, coordinates)) for _ in range(3))
        return cls(q, v, a, np.zeros((samples, rows)))


Back = Callable[[Array, Pull], None]


@final
@dataclass(frozen=True)
class Part:
    """share: (T, m) 1 is at a bound, beyond is outside. names: (m,). pull: (T, m) weights are added to a `Pull`."""

    share: Array
    names: Sequence[str]
    pull: Callable[[Array, Pull], None]


@final
@dataclass(frozen=True)
class Bounds:
    """Of a robot; loads come as the identification's rows: six of a floating base, then the joints in `order`.

    order: (J,) place among the robot's joints of every joint of these rows. corners: (K, 3) [m] of the soles in the
    world, none of a fixed base. pairs: what must not touch.
    """

    robot: MotionRobot
    order: NDArray[np.intp]
    criteria: MotionExcite
    pairs: Pairs
    corners: Array = field(default_factory=lambda: np.zeros((0, 3)))

    def parts(self, q: Array, v: Array, a: Array, loads: Array) -> list[Part]:
        """q, v, a: (T, n); loads: (T, rows)."""
        limits, base, names = self.robot.limits, self.robot.base, self.robot.joints
        joints = base + np.arange(len(names))
        low, high = limits.lower, limits.upper
        known = np.isfinite(low) & np.isfinite(high)
        found = []
        for what, values, middle, half in (
            ("position", q, np.where(known, 0.5 * (low + high), 0.0), np.where(known, 0.5 * (high - low), np.inf)),
            ("velocity", v, np.zeros(len(names)), limits.velocity),
            ("acceleration", a, np.zeros(len(names)), limits.acceleration),
        ):
            on = np.flatnonzero(np.isfinite(half))
            labels = [f"{what} of {names[k]}" for k in on]
            share = (values[:, joints[on]] - middle[on]) / half[on]
            found.append(self._both(share, labels, what[0], joints[on], half[on]))
        torque = limits.torque[self.order]
        on = np.flatnonzero(np.isfinite(torque) & ~self._carrying)
        rows = base + on
        labels = [f"torque of {names[self.order[k]]}" for k in on]
        found.append(self._both(loads[:, rows] / torque[on], labels, "l", rows, torque[on]))
        if len(self.corners):
            wrench, back = self._borne(q, loads)
            found += [self._balance(wrench, back), self._legs(q, wrench, loads, back)]
        if self.pairs.names:
            found.append(self._apart(q))
        return found

    def _apart(self, q: Array) -> Part:
        """Of the pairs that come near at all."""
        pairs, criteria = self.pairs, self.criteria
        near = pairs.near(q, criteria.look_m)
        some, column = np.unique(near.pair, return_inverse=True)
        share = np.zeros((len(q), len(some)))
        share[near.sample, column] = 1.0 + (criteria.clearance_m - near.distance) / HALF_FOOT_M

        def pull(weights: Array, on: Pull) -> None:
            by = weights[near.sample, column]
            felt = by != 0.0
            few = replace(near, **{name: values[felt] for name, values in vars(near).items()})
            np.add.at(on.q, few.sample, -by[felt, None] / HALF_FOOT_M * pairs.slopes(q, few))

        return Part(share, [f"distance of {' and '.join(pairs.names[k])}" for k in some], pull)

    @property
    def _carrying(self) -> NDArray[np.bool_]:
        """(J,) in `order`: legs, whose torques hang on how two feet share the load."""
        legs = [self.robot.leg(k) - self.robot.base for k in range(len(self.robot.soles))]
        return np.isin(self.order, np.concatenate(legs)) if legs else np.zeros(len(self.order), dtype=bool)

    def _both(self, share: Array, names: Sequence[str], what: str, columns: NDArray[np.intp], size: Array) -> Part:
        """A share and its negative."""
        m = share.shape[1]

        def pull(weights: Array, on: Pull) -> None:
            at = {"p": on.q, "v": on.v, "a": on.a, "l": on.loads}[what]
            at[:, columns] += (weights[:, :m] - weights[:, m:]) / size

        return Part(np.hstack([share, -share]), [*names, *names], pull)

    def _balance(self, wrench: Array, back: Back) -> Part:
        """Centre of pressure of all feet inside what they stand on, weight on them, friction. wrench: (T, 6)."""
        criteria, heavy = self.criteria, self.robot.weight
        edges = ConvexHull(self.corners[:, :2]).equations
        edges = edges[np.unique(np.round(edges, 9), axis=0, return_index=True)[1]]
        height = float(self.corners[:, 2].mean())
        mu = criteria.friction / np.sqrt(2.0)
        rows = [  # of force and moment about the world's origin, ≤ 0 where allowed
            np.array([height * e[0], height * e[1], e[2] + criteria.margin_m, e[1], -e[0], 0.0]) / HALF_FOOT_M
            for e in edges
        ]
        names = ["centre of pressure"] * len(edges)
        for axis in (0, 1):
            for sign in (1.0, -1.0):
                row = np.zeros(6)
                row[axis], row[2] = sign, -mu
                rows.append(row)
                names.append("friction")
        Q = np.stack(rows) / heavy
        down = np.zeros(6)
        down[2] = -1.0 / heavy
        Q = np.vstack([Q, down])
        offset = np.concatenate([np.ones(len(rows)), [1.0 + criteria.least_weight]])
        return Part(wrench @ Q.T + offset, [*names, "weight on the feet"], lambda weights, on: back(weights @ Q, on))

    def _legs(self, q: Array, wrench: Array, loads: Array, back: Back) -> Part:
        """Torques of joints that carry, where the feet share the wrench (T, 6) as evenly as they can."""
        robot, S = self.robot, self._shared
        rows = np.flatnonzero(self._carrying & np.isfinite(robot.limits.torque[self.order]))
        columns, size = robot.base + self.order[rows], robot.limits.torque[self.order[rows]]
        model, data = self._weightless, self._weightless.createData()
        frames = [model.frames[robot.frame(sole.link)] for sole in robot.soles]
        feet, none = wrench @ S.T, np.zeros(model.nv)
        borne, by_q = np.empty((len(q), len(rows))), np.empty((len(q), len(rows), model.nv))
        J = np.empty((len(q), len(S), len(rows)))
        outside = pin.StdVec_Force()
        outside.extend([pin.Force.Zero()] * model.njoints)
        for t in range(len(q)):
            for f, frame in enumerate(frames):
                outside[frame.parentJoint] = frame.placement.act(pin.Force(feet[t, 6 * f : 6 * f + 6]))
            pin.computeRNEADerivatives(model, data, q[t], none, none, outside)
            borne[t], by_q[t] = data.tau[columns], data.dtau_dq[columns]
            pin.computeJointJacobians(model, data, q[t])
            for f, sole in enumerate(robot.soles):
                foot = pin.getFrameJacobian(model, data, robot.frame(sole.link), pin.LOCAL)
                J[t, 6 * f : 6 * f + 6] = foot[:, columns]
        share, m = (loads[:, robot.base + rows] + borne) / size, len(rows)
        labels = [f"torque of {robot.joints[self.order[k]]}" for k in rows]

        def pull(weights: Array, on: Pull) -> None:
            by = (weights[:, :m] - weights[:, m:]) / size
            on.loads[:, robot.base + rows] += by
            on.q += np.einsum("tm,tmn->tn", by, by_q)
            back(-np.einsum("tkm,tm->tk", J, by) @ S, on)

        return Part(np.hstack([share, -share]), [*labels, *labels], pull)

    @cached_property
    def _shared(self) -> Array:
        """(6 F, 6) what every foot bears, in its own axes, of a wrench on the robot about the world's origin."""
        A = np.hstack([at.toDualActionMatrix() for at in standing(self.robot)])
        D = np.tile(EVENLY, len(self.robot.soles))[:, None]
        return np.asarray(D * A.T @ np.linalg.inv(A @ (D * A.T)))

    @cached_property
    def _weightless(self) -> pin.Model:
        model = self.robot.model.copy()
        model.gravity = pin.Motion.Zero()
        return model

    @staticmethod
    def _borne(q: Array, loads: Array) -> tuple[Array, Back]:
        """(T, 6) wrench of the ground about the world's origin, and how slopes by it pull."""
        turn = BaseTurn.of(q[:, 3:6], np.zeros((len(q), 3)), np.zeros((len(q), 3)))
        R, p = turn.rotation, q[:, :3]
        force = (R @ loads[:, :3, None])[..., 0]
        moment = (R @ loads[:, 3:6, None])[..., 0] + np.cross(p, force)

        def back(by: Array, on: Pull) -> None:
            by_force = by[:, :3] + np.cross(by[:, 3:], p)
            by_moment = by[:, 3:]
            on.loads[:, :3] += np.einsum("tji,tj->ti", R, by_force)
            on.loads[:, 3:6] += np.einsum("tji,tj->ti", R, by_moment)
            on.q[:, :3] += np.cross(force, by_moment)
            # R (δθ × f) · g = δθ · (f × Rᵀ g)
            turned = np.cross(loads[:, :3], np.einsum("tji,tj->ti", R, by_force))
            turned += np.cross(loads[:, 3:6], np.einsum("tji,tj->ti", R, by_moment))
            on.q[:, 3:6] += turn.by_turn(turned)

        return np.concatenate([force, moment], axis=1), back
