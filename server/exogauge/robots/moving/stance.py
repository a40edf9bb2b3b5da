"""From the coordinates that are free to the whole robot, and slopes back: what stands stays exactly where it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]
Three = tuple[Array, Array, Array]


class OutOfReachError(ValueError):
    """A foot cannot stay where it stands."""


class Stance(Protocol):
    """free: columns of the robot's coordinates that a motion is made of; all others follow."""

    @property
    def robot(self) -> MotionRobot: ...

    @property
    def free(self) -> IntArray: ...

    def whole(self, u: Array, du: Array, ddu: Array) -> Three:
        """(T, n) each q, q̇, q̈ of the robot, from (T, free). Raises OutOfReachError."""
        ...

    def back(self, whole: Three, slopes: Three) -> Three:
        """Slopes (T, free) by u, u̇, ü from those by q, q̇, q̈ (T, n)."""
        ...


@final
@dataclass(frozen=True)
class Fixed:
    """A robot whose base does not move: nothing follows."""

    robot: MotionRobot

    @property
    def free(self) -> IntArray:
        return np.arange(self.robot.model.nq)

    def whole(self, u: Array, du: Array, ddu: Array) -> Three:
        return u, du, ddu

    def back(self, whole: Three, slopes: Three) -> Three:
        return slopes


@final
class Standing:
    """A robot on two feet that stay where they are at home: base and all other joints are free, the legs follow.

    Their angles by Newton's steps, their rates and accelerations from the feet's being zero.
    """

    def __init__(self, robot: MotionRobot, criteria: MotionExcite = USUAL) -> None:
        self.criteria = criteria
        self.robot, self.place = robot, standing(robot)
        self.legs = [robot.leg(k) for k in range(len(robot.soles))]
        self.free: IntArray = np.setdiff1d(np.arange(robot.model.nq), np.concatenate(self.legs)).astype(np.intp)
        self.frames = [robot.frame(sole.link) for sole in robot.soles]
        self._last: dict[int, Array] = {}  # legs of as many samples, to go on from
        assert robot.home is not None
        self.home = robot.home

    def whole(self, u: Array, du: Array, ddu: Array) -> Three:
        robot, T = self.robot, len(u)
        model, data, base = robot.model, robot.data, np.arange(robot.base)
        q, v, a = np.tile(self.home, (T, 1)), np.zeros((T, model.nq)), np.zeros((T, model.nq))
        legs = np.concatenate(self.legs)
        q[:, self.free], v[:, self.free], a[:, self.free] = u, du, ddu
        before = self._last.get(T)
        for t in range(T):
            q[t, legs] = before[t] if before is not None else q[max(t - 1, 0), legs]
            feet = self._reach(q[t])
            if feet is None:
                self._last.pop(T, None)
                raise OutOfReachError
            for J, leg in zip(feet, self.legs, strict=True):
                v[t, leg] = -np.linalg.solve(J[:, leg], J[:, base] @ v[t, base])
            pin.forwardKinematics(model, data, q[t], v[t], a[t])
            for frame, leg, J in zip(self.frames, self.legs, feet, strict=True):
                left = pin.getFrameAcceleration(model, data, frame, pin.LOCAL).vector
                a[t, leg] = -np.linalg.solve(J[:, leg], left)
        if np.abs(a[:, legs]).max() > self.criteria.wild:
            self._last.pop(T, None)
            raise OutOfReachError
        self._last[T] = q[:, legs]
        return q, v, a

    def _reach(self, q: Array) -> list[Array] | None:
        """The feet's Jacobians once q's legs are turned so that they stand; None where they cannot. Joints' bounds are
        not looked at: an excess is to be seen."""
        exact, rounds = 1e-9, 20  # [m or rad] of a standing foot; of steps until it counts as out of reach
        model, data = self.robot.model, self.robot.data
        for _ in range(rounds):
            pin.computeJointJacobians(model, data, q)
            feet, far = list[Array](), 0.0
            for frame, leg, place in zip(self.frames, self.legs, self.place, strict=True):
                error = pin.log6(place.inverse() * pin.updateFramePlacement(model, data, frame)).vector
                J = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
                size = float(np.abs(error).max())
                far = max(far, size)
                if size > exact:
                    step = J[:, leg].T @ np.linalg.solve(
                        J[:, leg] @ J[:, leg].T + min(1e-3, size**2) * np.eye(6), error
                    )
                    q[leg] -= step
                feet.append(J)
            if far <= exact:
                return feet
        return None

    def back(self, whole: Three, slopes: Three) -> Three:
        model, data, base = self.robot.model, self.robot.data, np.arange(self.robot.base)
        q, v, a = whole
        by_q, by_v, by_a = (each.copy() for each in slopes)
        for t in range(len(q)):
            pin.computeForwardKinematicsDerivatives(model, data, q[t], v[t], a[t])
            for frame, leg in zip(self.frames, self.legs, strict=True):
                v_q, a_q, a_v, J = pin.getFrameAccelerationDerivatives(model, data, frame, pin.LOCAL)
                inverse = np.linalg.inv(J[:, leg]).T
                both = np.concatenate([base, leg])
                force = inverse @ by_a[t, leg]
                by_q[t, both] -= a_q[:, both].T @ force
                by_v[t, both] -= a_v[:, both].T @ force
                by_a[t, base] -= J[:, base].T @ force
                force = inverse @ by_v[t, leg]
                by_q[t, both] -= v_q[:, both].T @ force
                by_v[t, base] -= J[:, base].T @ force
                force = inverse @ by_q[t, leg]
                by_q[t, base] -= J[:, base].T @ force
        return by_q[:, self.free], by_v[:, self.free], by_a[:, self.free]
