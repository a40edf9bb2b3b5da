"""The whole of a planned motion: rest at home, the way to where it begins, the motion, the way back, rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.motion.excite.search import Task
from exogauge.robots.moving.stance import Three

Array = NDArray[np.float64]

STEEPEST, SHARPEST = 1.875, 10.0 / np.sqrt(3.0)  # rate and acceleration of an eased way of 1 in 1 s, at most


@final
@dataclass(frozen=True)
class Excited:
    """x: (free, 2N-2) numbers of the series."""

    task: Task
    x: Array

    @cached_property
    def approach_s(self) -> float:
        """[s] that the way from home takes within four fifths of every joint's speed and acceleration."""
        task, robot = self.task, self.task.stance.robot
        own = task.stance.free - robot.base
        way = np.abs(self.x[:, -1] - task.home)[own >= 0]
        speed, fast = robot.limits.velocity[own[own >= 0]], robot.limits.acceleration[own[own >= 0]]
        needed = np.maximum(STEEPEST * way / (0.8 * speed), np.sqrt(SHARPEST * way / (0.8 * fast)))
        return max(task.criteria.approach_s, float(needed.max(initial=0.0)))

    @property
    def edges(self) -> tuple[float, float, float, float]:
        """[s] from where the way begins to where the way back ends."""
        begin, way = self.task.criteria.rest_s, self.approach_s
        end = begin + way + self.task.series.duration
        return begin, begin + way, end, end + way

    @property
    def duration(self) -> float:
        """[s]"""
        return self.edges[3] + self.task.criteria.rest_s

    def free_at(self, time: Array) -> Three:
        """(T, free) each u, u̇, ü."""
        task, (away, begin, end, back) = self.task, self.edges
        u = np.tile(task.home, (len(time), 1))
        du, ddu = np.zeros_like(u), np.zeros_like(u)
        inside = (time >= begin) & (time <= end)
        u[inside], du[inside], ddu[inside] = task.series.motion(self.x, time[inside] - begin)
        way, span = self.approach_s, self.x[:, -1] - task.home
        for on, s, sign in (
            ((time > away) & (time < begin), (time - away) / way, 1.0),
            ((time > end) & (time < back), (back - time) / way, -1.0),
        ):
            s = s[on, None]
            u[on] += s**3 * (10.0 - 15.0 * s + 6.0 * s**2) * span
            du[on] = sign * 30.0 * s**2 * (1.0 - s) ** 2 * span / way
            ddu[on] = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * span / way**2
        return u, du, ddu

    def at(self, time: Array) -> Three:
        """(T, n) each q, q̇, q̈ of the robot's coordinates."""
        return self.task.stance.whole(*self.free_at(time))

    def largest(self) -> tuple[float, str]:
        """Share of the bound that is nearest from rest to rest, at `MotionExcite.check_hz`, and which."""
        rate = self.task.criteria.check_hz
        time = np.arange(int(self.duration * rate + 1e-6) + 1) / rate
        return self.task.largest_of(self.free_at(time))
