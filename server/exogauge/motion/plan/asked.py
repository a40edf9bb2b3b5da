"""What is asked of a robot over time, node by node."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Asked:
    """N nodes, `step` [s] apart; n coordinates of `MotionRobot.model`; F feet in the order of its soles.

    q: (N, n) [rad or m]. stray: (n,) by how much each may stray from it at equal cost, inf where nothing is asked.
    stands: (N, F). place: (N, F) poses of the soles' links in the world, where they stand and on their way.
    """

    q: Array
    stray: Array
    step: float
    stands: BoolArray
    place: tuple[tuple[pin.SE3, ...], ...]

    @property
    def time(self) -> Array:
        """(N,) [s]"""
        return np.asarray(self.step * np.arange(len(self.q)), dtype=np.float64)

    def between(self, begin: int, end: int) -> Asked:
        """From node `begin` to node `end`, both in it."""
        part = slice(begin, end + 1)
        return replace(self, q=self.q[part], stands=self.stands[part], place=self.place[part])

    def finer(self, rate: float) -> Asked | None:
        """The same on about half as many rows of a table of `rate` [Hz] a node, a foot standing from and until the same
        moments; ended at rest where its last node lies beyond. None where a row has a node already."""
        step = -(-rows_of(self.step, rate) // 2) / rate
        if step >= self.step:
            return None
        last = self.time[-1]
        time = np.minimum(step * np.arange(int(np.ceil(last / step - 1e-9)) + 1), last)
        before = np.minimum(np.floor(time / self.step + 1e-9).astype(int), len(self.q) - 1)
        after = np.minimum(np.ceil(time / self.step - 1e-9).astype(int), len(self.q) - 1)
        stands = self.stands[before] | self.stands[after]
        share = time / self.step - before
        ways = CubicSpline(self.time, [[foot.translation for foot in feet] for feet in self.place])(time)
        place = list[tuple[pin.SE3, ...]]()
        for k, (a, b) in enumerate(zip(before, after, strict=True)):
            feet = list[pin.SE3]()
            for f, (one, other) in enumerate(zip(self.place[a], self.place[b], strict=True)):
                between = pin.SE3.Interpolate(one, other, float(share[k]))
                feet.append(between if stands[k, f] else pin.SE3(between.rotation, ways[k, f]))
            place.append(tuple(feet))
        return replace(self, q=CubicSpline(self.time, self.q)(time), step=step, stands=stands, place=tuple(place))

    def every(self, count: int) -> Asked:
        """Every `count`-th node, and one at the end or beyond it."""
        kept = np.minimum(np.arange(-(-(len(self.q) - 1) // count) + 1) * count, len(self.q) - 1)
        place = tuple(self.place[k] for k in kept)
        return replace(self, q=self.q[kept], step=count * self.step, stands=self.stands[kept], place=place)


def rows_of(step: float, rate: float) -> int:
    """How many rows of a table of `rate` [Hz] a node takes that comes at least every `step` [s]; one, where rows are
    fewer."""
    rounding = 1e-9  # of a number of rows
    return max(1, int(step * rate + rounding))


def on_its_feet(robot: MotionRobot, q: Array, place: tuple[pin.SE3, ...], rounds: int = 30) -> Array:
    """(n,) posture with the joints of the legs turned so that their feet are at `place`, as far as they reach.

    Newton's steps with damping, within the joints' bounds; the base stays.
    """
    model, data = robot.model, robot.data
    q = q.copy()
    for k, sole in enumerate(robot.soles):
        frame = robot.frame(sole.link)
        columns = robot.leg(k)
        lower, upper = robot.limits.lower[columns - robot.base], robot.limits.upper[columns - robot.base]
        for _ in range(rounds):
            pin.computeJointJacobians(model, data, q)
            error = pin.log6(place[k].inverse() * pin.updateFramePlacement(model, data, frame)).vector
            if np.abs(error).max() < 1e-10:
                break
            J = pin.getFrameJacobian(model, data, frame, pin.LOCAL)[:, columns]
            damping = min(1e-3, float(error @ error))
            step = J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error)
            q[columns] = np.clip(q[columns] - step, lower, upper)
    return q
