"""A robot that has run its logs: what effects are drawn for, sized on, and put into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.cut import cut_wrench
from exogauge.blind.generator.dynamics import UP, Kinematics, kinematics
from exogauge.blind.generator.excess import Baseline, CutBaseline, baselines, cut_baseline, thinned_kinematics
from exogauge.blind.generator.motion import LogPlan, Motion
from exogauge.blind.generator.robot_kind import RobotKind
from exogauge.blind.generator.stated import Stated, stated
from exogauge.blind.generator.true_robot import TrueRobot
from exogauge.blind.generator.wear import Wear
from exogauge.synthetic.robot_facts import Link

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Scene:
    """runs: of every joint over all L logs. moving: of all L·T samples, log after log. wrench: (L, T, 6) that the
    sensor feels [N, N·m]. baselines, cut_baseline: what is absorbed without a trace; floors: noise of each joint [N·m].
    """

    kind: RobotKind
    links: Sequence[Link]
    robot: TrueRobot
    motion: Motion
    logs: Sequence[LogPlan]
    runs: Sequence[AxisRun]
    wear: Wear | None
    moving: Kinematics
    wrench: Array
    baselines: Sequence[Baseline]
    cut_baseline: CutBaseline
    floors: Sequence[float]
    k_T_std: float

    @property
    def joints(self) -> list[str]:
        return [link.joint.name for link in self.links if link.joint is not None]

    @property
    def shape(self) -> tuple[int, int]:
        """(L, T)"""
        return self.motion.q.shape[0], self.motion.q.shape[1]

    @property
    def plain(self) -> list[int]:
        """Logs without the device."""
        return [n for n, log in enumerate(self.logs) if not log.worn]

    @cached_property
    def stated(self) -> Stated:
        """By the logs of which the robot is identified."""
        return self._stated("identification")

    @cached_property
    def stated_with_wear(self) -> Stated:
        return self._stated("identification", "with_device")

    def _stated(self, *roles: str) -> Stated:
        robot, moving = self.robot, thinned_kinematics(self.robot.tree, self.motion)
        noise = np.array(self.floors), self.cut_baseline.std
        kept = np.stack([each.kept for each in self.baselines], axis=2)
        kept = kept & np.isin([log.role for log in self.logs], roles)[:, None, None]
        frame = self.kind.sensor.frame
        return stated(self.links, robot.tree, frame, moving, self.runs, self.wear, self.k_T_std, noise, kept)


def scene(
    kind: RobotKind,
    links: Sequence[Link],
    robot: TrueRobot,
    motion: Motion,
    logs: Sequence[LogPlan],
    runs: list[AxisRun],
    wear: Wear | None,
    current_std: float,
    k_T_std: float,
) -> Scene:
    std = np.repeat([kind.sensor.force, kind.sensor.moment], 3)
    moving = all_samples(robot, motion)
    return Scene(
        kind,
        links,
        robot,
        motion,
        logs,
        runs,
        wear,
        moving,
        cut_wrench(robot.tree, robot.phi, robot.cut, moving).reshape(*motion.q.shape[:2], 6),
        baselines(robot.tree, motion, runs, wear),
        cut_baseline(robot.tree, robot.cut, motion, std),
        [run.drive.k_T * current_std for run in runs],
        k_T_std,
    )


def all_samples(robot: TrueRobot, motion: Motion, up: Array = UP) -> Kinematics:
    flat = [x.reshape(-1, motion.q.shape[2]) for x in (motion.q, motion.dq, motion.ddq)]
    return kinematics(robot.tree, flat[0], flat[1], flat[2], up)
