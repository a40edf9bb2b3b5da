"""What a robot's description expects of every axis, for a snapshot as it is or were it read otherwise."""

from __future__ import annotations

from copy import copy
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.identification.prior import inertial_std
from exogauge.identification.turns import way_of_axes
from exogauge.plausibility.axis_fit import ALL_GAINS, AS_DESCRIBED, AxisFit, Likelihood, in_motion
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot
from exogauge.robots.regressor import regressor

Array = NDArray[np.float64]


@final
class Expected:
    """The axes of a robot in one snapshot. Likelihoods are computed where they are asked for, once.

    moving: (N, A) bool, the moments in which an axis slides; given to compare the same moments of another reading.
    """

    def __init__(self, robot: Robot, seen: Snapshot, moving: NDArray[np.bool_] | None = None) -> None:
        self.robot, self.seen = robot, seen
        C, axes = robot.axes_from_joints, robot.rows.axes
        Y = regressor(robot.tree, seen.motion)[:, axes]
        phi, rough = robot.phi_in(seen.recording).ravel(), seen.criteria.rough * inertial_std(robot).ravel()
        load, self._spread = [], list[Array]()
        for weights in np.linalg.inv(C).T:
            joints = np.flatnonzero(weights)
            own = sum((weights[joint] * Y[:, joint] for joint in joints[1:]), weights[joints[0]] * Y[:, joints[0]])
            load.append(own @ phi)
            self._spread.append(_live(own * rough))
        outside = ContactPaths(robot).effect(seen.q, seen.wrenches)[:, axes] if robot.contacts else 0.0
        self.load = np.stack(load, axis=1) - outside
        self._velocity, self._acceleration = seen.dq @ C.T, seen.ddq @ C.T
        self.moving, self._over = sliding(robot, seen) if moving is None else moving, 0.0
        self.effort = on_axes(robot, seen.effort)
        self._fits: dict[int, AxisFit] = {}
        self._known: dict[tuple[int, float, bool], Likelihood] = {}
        self._late: dict[tuple[int, int], Likelihood] = {}
        self._any_motion: Expected | None = None

    def fit(self, axis: int) -> AxisFit:
        if axis not in self._fits:
            velocity, acceleration = self._velocity[:, axis], self._acceleration[:, axis]
            self._fits[axis] = AxisFit(
                self.load[:, axis],
                self._spread[axis],
                velocity,
                self._direction(axis),
                acceleration,
                self.moving[:, axis],
                self.seen.criteria,
            )
        return self._fits[axis]

    def _direction(self, axis: int) -> Array:
        """(N,) of Coulomb friction: from one side to the other while a joint goes on from its last turn."""
        sign = np.sign(self._velocity[:, axis])
        if not self._over:
            return np.asarray(sign)
        way = way_of_axes(self.robot, self.seen.way)[:, axis]
        return np.asarray(sign * (1.0 - 2.0 * np.exp(-way / self._over)))

    def tells(self, axis: int) -> bool:
        """Its effort is logged, and it moves in enough of the moments."""
        return bool(self.seen.alive[axis]) and int(self.moving[:, axis].sum()) >= self.seen.criteria.fewest

    def likelihood(self, axis: int, sign: float = 1.0, near: bool = False) -> Likelihood:
        """sign: of the effort. near: by factors near one alone, where no other is asked for."""
        key = next((each for each in ((axis, sign, False), (axis, sign, near)) if each in self._known), None)
        if key is None:
            key, among = (axis, sign, near), AS_DESCRIBED if near else ALL_GAINS
            self._known[key] = self.fit(axis).likelihood(sign * self.effort[:, axis], among)
        return self._known[key]

    def late_likelihood(self, axis: int, lag: int) -> Likelihood:
        """Of the efforts from so much later, by their place among the snapshot's lags, by factors near one."""
        if (axis, lag) not in self._late:
            effort = on_axes(self.robot, self.seen.late[lag])[:, axis]
            self._late[axis, lag] = self.fit(axis).likelihood(effort, AS_DESCRIBED)
        return self._late[axis, lag]

    def left(self, axis: int) -> tuple[float, float]:
        """Of its effort, whatever factor near one: the share that is left, and how much that is [N·m]."""
        share, moving = self.likelihood(axis, near=True).misfit, self.moving[:, axis]
        return share, share * float(np.sqrt(np.mean(self.effort[moving, axis] ** 2)))

    def in_doubt(self) -> list[int]:
        """Axes of whose effort more is left than recorded robots leave of it."""
        axes = [axis for axis in range(len(self.robot.joints)) if self.tells(axis)]
        return [axis for axis in axes if self.left(axis)[0] > self.seen.criteria.misfit]

    def in_any_motion(self) -> Expected:
        """With moments right after a turn too: there, where friction turns round, a delay shows."""
        if self._any_motion is None:
            self._any_motion = self.at(in_motion(self._velocity, self.seen.criteria))
        return self._any_motion

    def between_turns(self) -> Expected:
        """Without moments right before a turn too: a low-pass has friction turn before the joint does, so that efforts
        would fit as well without the turn, were they later."""
        return self.at(self.moving & _far_enough(self.robot, self.seen, self.seen.ahead))

    def at(self, moving: NDArray[np.bool_]) -> Expected:
        """The same, where these moments count: (N, A)."""
        other = copy(self)
        other.moving, other._fits, other._known, other._late = moving, {}, {}, {}
        other._any_motion = None
        return other

    def with_friction_over(self, way: float) -> Expected:
        """The same, were friction a bristle that turns round over such a way [rad or m] (Dahl, 1968)."""
        other = self.at(self.moving)
        other._over = way
        return other

    def with_other_bodies(self, axis: int, sign: float) -> Likelihood:
        """By how many times further off than stated its bodies are, in place of a factor of the effort."""
        return self.fit(axis).likelihood(sign * self.effort[:, axis], other_bodies=True)

    def with_effort(self, seen: Snapshot) -> Expected:
        """The same motion with the efforts of `seen`."""
        other = copy(self)
        other.seen, other.effort, other._known, other._late = seen, on_axes(self.robot, seen.effort), {}, {}
        other._any_motion = None
        return other


def sliding(robot: Robot, seen: Snapshot) -> NDArray[np.bool_]:
    """(N, A) moments in which an axis moves, and has gone on so far that friction is no spring any more."""
    moves = in_motion(robot.on_axes(seen.dq), seen.criteria)
    return np.asarray(moves & _far_enough(robot, seen, seen.way))


def _far_enough(robot: Robot, seen: Snapshot, way: Array) -> NDArray[np.bool_]:
    """way: (N, J) of joints. (N, A): whether all joints of an axis go so far."""
    return way_of_axes(robot, way) >= seen.criteria.slides


def _live(columns: Array) -> Array:
    """(N, those that are not 0 throughout)"""
    return columns[:, np.any(columns != 0.0, axis=0)]


def on_axes(robot: Robot, effort: Array) -> Array:
    """(N, J) or (L, N, J) as logged -> on axes: motor currents belong there, joint torques are brought by C^{-T}."""
    torque = np.array([joint.actuation == "torque" for joint in robot.joints])
    result = effort.copy()
    if torque.any():
        to_axes = np.linalg.inv(robot.axes_from_joints)[np.ix_(torque, torque)]
        result[..., torque] = effort[..., torque] @ to_axes
    return result
