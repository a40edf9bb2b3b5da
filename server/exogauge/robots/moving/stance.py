"""From the coordinates that are free to the whole robot, and slopes back: what stands stays exactly where it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.robots.moving.robot import MotionRobot, frame_of
from exogauge.robots.moving.standing import standing

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]
Three = tuple[Array, Array, Array]
NEAR = 0.02  # judgement: [m or rad] of the base: nearer samples begin with the legs of one, which saves steps


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

    Their angles by Newton's steps, their rates and accelerations from the feet's being zero. What the feet do hangs on
    base and legs alone, so that a model of these is moved, of all samples side by side.
    """

    def __init__(self, robot: MotionRobot, criteria: MotionExcite = USUAL) -> None:
        self.criteria = criteria
        self.robot, self.place = robot, standing(robot)
        legs = [robot.leg(k) for k in range(len(robot.soles))]
        every = np.arange(robot.model.nq)
        self.free: IntArray = np.setdiff1d(every, np.concatenate(legs)).astype(np.intp)
        assert robot.home is not None
        self.home = robot.home
        self.moves = np.sort(np.concatenate([every[: robot.base], *legs]))
        beside = [k for k in range(1, robot.model.njoints) if robot.model.joints[k].idx_q not in self.moves]
        self.model = pin.buildReducedModel(robot.model, beside, self.home)
        self.data = self.model.createData()
        self.frames = [frame_of(self.model, sole.link) for sole in robot.soles]
        self.base = slice(robot.base)
        self.legs: list[IntArray] = [np.searchsorted(self.moves, leg).astype(np.intp) for leg in legs]
        self._last: dict[int, tuple[Array, Array]] = {}  # of as many samples, to go on from: q, and slopes by the base

    def whole(self, u: Array, du: Array, ddu: Array) -> Three:
        T, moves, base = len(u), self.moves, self.base
        q, v, a = np.tile(self.home, (T, 1)), np.zeros((T, len(self.home))), np.zeros((T, len(self.home)))
        q[:, self.free], v[:, self.free], a[:, self.free] = u, du, ddu
        own, rates, gains = q[:, moves], v[:, moves], a[:, moves]
        before = self._last.pop(T, None)
        slopes = self._reach(own) if before is None else self._reach_from(own, *before)
        for f, leg in enumerate(self.legs):
            rates[:, leg] = np.einsum("tij,tj->ti", slopes[:, f], rates[:, base])
        left = np.empty((T, len(self.frames), 6))
        J = np.empty((T, len(self.frames), 6, len(moves)))
        model, data = self.model, self.data
        for t in range(T):
            pin.computeJointJacobians(model, data, own[t])
            pin.forwardKinematics(model, data, own[t], rates[t], gains[t])
            for f, frame in enumerate(self.frames):
                left[t, f] = pin.getFrameAcceleration(model, data, frame, pin.LOCAL).vector
                J[t, f] = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
        for f, leg in enumerate(self.legs):
            gains[:, leg] = -np.linalg.solve(J[:, f][:, :, leg], left[:, f, :, None])[..., 0]
        if max(np.abs(gains[:, leg]).max() for leg in self.legs) > self.criteria.wild:
            raise OutOfReachError
        self._last[T] = own, slopes
        q[:, moves], v[:, moves], a[:, moves] = own, rates, gains
        return q, v, a

    def _reach_from(self, q: Array, before: Array, slopes: Array) -> Array:
        """As `_reach`, from the legs of postures near by and what the base has moved since."""
        begun = q.copy()
        moved = q[:, self.base] - before[:, self.base]
        for f, leg in enumerate(self.legs):
            q[:, leg] = before[:, leg] + np.einsum("tij,tj->ti", slopes[:, f], moved)
        found = self._stood(q)
        if found is None:  # so far that slopes mislead
            q[:] = begun
            for leg in self.legs:
                q[:, leg] = before[:, leg]
            found = self._stood(q)
        if found is None:
            raise OutOfReachError
        return found

    def _reach(self, q: Array) -> Array:
        """Turns q's legs so that the feet stand, from one near sample to the next: (T, F, leg, base) by how much the
        base turns them. Raises OutOfReachError."""
        parts, start, at = list[Array](), 0, q[0].copy()
        while start < len(q):
            far = np.abs(q[start:, self.base] - q[start, self.base]).max(axis=1) > NEAR
            stop = start + (int(far.argmax()) if far.any() else len(far))
            part = q[start:stop]
            for f, leg in enumerate(self.legs):
                part[:, leg] = at[leg]
                if parts:
                    part[:, leg] += (part[:, self.base] - at[self.base]) @ parts[-1][-1, f].T
            found = self._stood(part)
            if found is None:
                raise OutOfReachError
            parts.append(found)
            start, at = stop, part[-1]
        return np.concatenate(parts)

    def _stood(self, q: Array) -> Array | None:
        """(T, F, leg, base) once the legs of q (T, n) are turned so that the feet stand; None where one cannot. Joints'
        bounds are not looked at: an excess is to be seen."""
        exact, rounds = 1e-9, 20  # [m or rad] of a standing foot; of steps until it counts as out of reach
        model, data = self.model, self.data
        to_place = [place.inverse() for place in self.place]
        error, J = np.empty((len(q), len(self.frames), 6)), np.empty((len(q), len(self.frames), 6, len(self.moves)))
        going = np.arange(len(q))
        for _ in range(rounds):
            for t in going:
                pin.computeJointJacobians(model, data, q[t])
                for f, frame in enumerate(self.frames):
                    error[t, f] = pin.log6(to_place[f] * pin.updateFramePlacement(model, data, frame)).vector
                    J[t, f] = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
            size = np.abs(error[going]).max(axis=2)
            for f, leg in enumerate(self.legs):
                wrong = size[:, f] > exact
                some = going[wrong]
                A = J[some, f][:, :, leg]
                held = np.minimum(1e-3, size[wrong, f] ** 2)[:, None, None] * np.eye(6)
                step = np.linalg.solve(A @ A.mT + held, error[some, f, :, None])
                q[some[:, None], leg] -= (A.mT @ step)[..., 0]
            going = going[(size > exact).any(axis=1)]
            if not len(going):
                return np.stack([-np.linalg.solve(J[:, f][:, :, leg], J[:, f, :, self.base])
                                 for f, leg in enumerate(self.legs)], axis=1)  # fmt: skip
        return None

    def back(self, whole: Three, slopes: Three) -> Three:
        model, data, base, legs = self.model, self.data, self.base, self.legs
        q, v, a = (each[:, self.moves] for each in whole)
        shape = len(q), len(self.frames), 6, len(self.moves)
        v_q, a_q, a_v, J = (np.empty(shape) for _ in range(4))
        for t in range(len(q)):
            pin.computeForwardKinematicsDerivatives(model, data, q[t], v[t], a[t])
            for f, frame in enumerate(self.frames):
                v_q[t, f], a_q[t, f], a_v[t, f], J[t, f] = pin.getFrameAccelerationDerivatives(
                    model, data, frame, pin.LOCAL
                )
        by_q, by_v, by_a = (each[:, self.moves] for each in slopes)
        for f, leg in enumerate(legs):
            both = np.concatenate([np.arange(base.stop), leg])
            inverse = np.linalg.inv(J[:, f][:, :, leg]).mT

            force = np.einsum("tij,tj->ti", inverse, by_a[:, leg])
            by_q[:, both] -= pulled(a_q[:, f][:, :, both], force)
            by_v[:, both] -= pulled(a_v[:, f][:, :, both], force)
            by_a[:, base] -= pulled(J[:, f, :, base], force)
            force = np.einsum("tij,tj->ti", inverse, by_v[:, leg])
            by_q[:, both] -= pulled(v_q[:, f][:, :, both], force)
            by_v[:, base] -= pulled(J[:, f, :, base], force)
            force = np.einsum("tij,tj->ti", inverse, by_q[:, leg])
            by_q[:, base] -= pulled(J[:, f, :, base], force)
        out = []
        for given, own in zip(slopes, (by_q, by_v, by_a), strict=True):
            found = given.copy()
            found[:, self.moves] = own
            out.append(found[:, self.free])
        return out[0], out[1], out[2]


def pulled(rows: Array, force: Array) -> Array:
    """(T, n) of rows (T, 6, n) by a force (T, 6)."""
    return np.asarray(np.einsum("tij,ti->tj", rows, force))
