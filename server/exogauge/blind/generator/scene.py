"""A robot that has run its logs: what effects are drawn for, sized on, and put into; and
how surely its logs contradict a number that is stated, when all other stated numbers are in doubt as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.cut import Cut, cut_at, cut_wrench
from exogauge.blind.generator.dynamics import UP, Kinematics, Tree, bodies_of, inverse_dynamics, kinematics
from exogauge.blind.generator.excess import (
    BAND_HZ,
    Baseline,
    CutBaseline,
    Mask,
    baselines,
    cut_baseline,
    thinned,
    thinned_kinematics,
)
from exogauge.blind.generator.motion import RATE_HZ, LogPlan, Motion
from exogauge.blind.generator.robot_kind import RobotKind
from exogauge.blind.generator.true_robot import INERTIAL_STD, TrueRobot, a_priori_std
from exogauge.blind.generator.wear import LENGTH_STD, STIFFNESS_STD, Wear
from exogauge.synthetic.inertia import Mass, of_shape
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


_NOISE_LEFT = np.sqrt(2.0 * BAND_HZ / RATE_HZ)  # of white noise, by the low-pass
_FREE = 1e6  # standard deviations: of what nothing is stated


@final
@dataclass(frozen=True)
class Stated:
    """torque: (L, n, J) bool, the thinned samples that count, as in `Baseline`. floors: (J,), std: (6,) noise of one
    sample of the joints' torques and of the sensor. Q: (M, R) orthonormal: all that is in doubt, one standard deviation
    of each number a column, in units of noise, above the unit matrix of the doubts themselves."""

    torque: Mask
    floors: Array
    std: Array
    Q: Array
    numbers: int

    def contradicted(self, torque: Array | None, wrench: Array | None) -> float:
        """[standard deviations] of all noise and all doubts by which the logs speak for a change (L, T, J) of torques
        and (L, T, 6) of the wrench: the misfit that is left when the numbers are fitted within what is stated."""
        felt = None if torque is None else thinned(torque), None if wrench is None else thinned(wrench)
        y = np.append(_rows(self, *felt), np.zeros(self.numbers))
        return float(np.linalg.norm(y - self.Q @ (self.Q.T @ y)))


def stated(
    links: Sequence[Link],
    tree: Tree,
    frame: str,
    moving: Kinematics,
    runs: Sequence[AxisRun],
    wear: Wear | None,
    k_T_std: float,
    noise: tuple[Array, Array],
    kept: Mask,
) -> Stated:
    """frame: the sensor's. moving: of the thinned samples. k_T_std: relative, 0 where torques are logged. noise: floors
    and std of `Stated`. kept: (L, n, J) the thinned samples that count."""
    blank = Stated(kept, *noise, np.zeros((0, 0)), 0)
    columns = [_rows(blank, *pair) for pair in _bodies(links, tree, frame, moving, kept.shape[:2])]
    columns += [_rows(blank, thinned(each), None) for each in (*_drives(links, runs, k_T_std), *_bands(wear))]
    columns += [_FREE * _rows(blank, None, np.tile(unit * blank.std, (*kept.shape[:2], 1))) for unit in np.eye(6)]
    A = np.column_stack(columns)
    Q, _ = np.linalg.qr(np.vstack([A, np.eye(A.shape[1])]))
    return replace(blank, Q=Q, numbers=A.shape[1])


def _rows(of: Stated, torque: Array | None, wrench: Array | None) -> Array:
    """(M,) in units of noise, of thinned samples: joints' where they count, the sensor's in logs in which any does."""
    logs = of.torque.any(axis=(1, 2))
    on_joints = np.zeros(int(of.torque.sum())) if torque is None else (torque / of.floors)[of.torque]
    on_sensor = np.zeros((*of.torque[logs].shape[:2], 6)) if wrench is None else wrench[logs] / of.std
    return np.asarray(np.concatenate([on_joints, on_sensor.ravel()]) / _NOISE_LEFT)


def _bodies(
    links: Sequence[Link], tree: Tree, frame: str, moving: Kinematics, shape: tuple[int, ...]
) -> Iterator[tuple[Array, Array]]:
    """Torque and wrench by every doubt about every link: mass, centre, extents."""
    even = {link.name: of_shape(link) for link in links if link.mass > 0.0}
    phi, cut = bodies_of(links, even), cut_at(links, frame, tree, even)
    for name, mass in even.items():
        for other in _deviated(mass):
            masses = {**even, name: other}
            more = bodies_of(links, masses) - phi
            carried = Cut(cut.body, cut.place, cut.bodies, cut_at(links, frame, tree, masses).rigid - cut.rigid)
            torque = inverse_dynamics(tree, more, moving)[0].reshape(*shape, -1)
            yield torque, cut_wrench(tree, more, carried, moving).reshape(*shape, 6)


def _deviated(mass: Mass) -> Iterator[Mass]:
    yield replace(mass, mass=mass.mass * (1.0 + INERTIAL_STD))
    for unit in np.eye(3):
        yield replace(mass, centre=mass.centre + INERTIAL_STD * mass.gyration * unit)
    for unit in np.eye(3):
        extents = 1.0 + 0.5 * INERTIAL_STD * unit
        yield replace(mass, spread=mass.spread * np.outer(extents, extents))


def _drives(links: Sequence[Link], runs: Sequence[AxisRun], k_T_std: float) -> Iterator[Array]:
    drives = [link.joint.drive for link in links if link.joint is not None]
    for joint, (drive, run) in enumerate(zip(drives, runs, strict=True)):
        std = a_priori_std(drive, k_T_std)
        by_number = (
            std["k_d"] * run.dq,
            std["tau_c"] * run.direction,
            std["tau_o"] * np.ones_like(run.q),
            std["J_r"] * run.ddq,
            k_T_std * run.motor,
        )
        for column in by_number:
            torque = np.zeros((*run.q.shape, len(runs)))
            torque[:, :, joint] = column
            yield torque


def _bands(wear: Wear | None) -> Iterator[Array]:
    if wear is None:
        return
    for group in dict.fromkeys(band.wire.group for band in wear.bands):
        pair = [band for band in wear.bands if band.wire.group == group]
        pulls = [band.pull(STIFFNESS_STD * band.stated[0] * band.stretch) for band in pair]
        yield wear.in_all_logs(np.asarray(sum(pulls)))
    for band in wear.bands:
        taut = (band.stretch > 0.0) * band.stiffness * LENGTH_STD * band.stated[1]
        yield wear.in_all_logs(band.pull(np.asarray(taut)))
