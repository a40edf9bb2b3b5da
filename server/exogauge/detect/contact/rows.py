"""What a log's rows leave unexplained, weighed by what is usual there, and what a force at each link does to them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.detecting import Touching
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.identification.settings import Recording
from exogauge.robots.cuts import in_sensor
from exogauge.robots.kinematics import Kinematics
from exogauge.robots.rows import RowType
from exogauge.robots.tree import RigidTree
from exogauge.search.score import residual_memory

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LogRows:
    """One log, all of it. kinds K: base axes if floating, actuator axes in steady motion, six for each sensor that
    carries bodies.

    time: (n,) [s] of the log's own clock. e: (n, K) y - A x less its running median, 0 where there is no row.
    weight: (n, K) one over the usual square of e, per independent sample; 0 where there is no row.
    """

    recording: Recording
    prepared: Prepared
    time: Array
    e: Array
    weight: Array

    @property
    def name(self) -> str:
        return self.recording.log.name


def log_rows(model: RobotModel, recordings: Sequence[Recording]) -> list[LogRows]:
    """Spans that were left out are looked at as well."""
    equations, x = model.equations, model.solution.unbounded.x
    layout, level_s = equations.layout, model.criteria.contact.level_s
    shown = layout.numbers(RowType.BASE, RowType.AXIS, RowType.SENSOR)
    found = []
    for recording in recordings:
        whole = replace(recording.log, left_out=()) if recording.log.left_out else recording.log
        prepared = model.prepare(whole)
        e = equations.residuals(prepared, x)[:, shown]
        e[:, layout.told.axes][~prepared.steady[prepared.kept]] = np.nan
        step = float(np.median(np.diff(whole.time[prepared.kept]))) if len(prepared.kept) > 1 else level_s
        found.append((recording, prepared, whole.time[prepared.kept], _without_level(e, round(level_s / step))))
    ratios = _by_speed(model, [(prepared, e) for _, prepared, _, e in found])
    return [
        LogRows(recording, prepared, time, np.nan_to_num(e), _weights(model, prepared, e, ratios))
        for recording, prepared, time, e in found
    ]


def force_columns(model: RobotModel, rows: LogRows) -> Iterator[Array]:
    """(n, K, 6) of one body after the other: what a unit force and a unit moment, in base axes, at its middle take off
    the rows."""
    robot, equations, tree = model.robot, model.equations, model.robot.tree
    motion = rows.prepared.motion.rows(rows.prepared.kept)
    sweep, carried = Kinematics(tree).sweep(motion), tree.subtree
    n, told = len(rows.time), robot.rows.told
    to_axes = np.linalg.inv(robot.axes_from_joints).T
    middle = middles(tree)
    for body in range(len(tree.bodies)):
        out = np.zeros((n, rows.e.shape[1], 6))
        p = sweep.p[body] + np.einsum("ijt,j->it", sweep.R[body], middle[body])
        W = np.zeros((n, 6, 6))  # force and moment about the base's origin
        W[:, :3, :3] = W[:, 3:, 3:] = np.eye(3)
        W[:, 3:, :3] = _skew(p)
        if robot.floating:
            out[:, told.base] = -W
        moving = np.flatnonzero(carried[:, body] & (tree.dof >= 0))
        S = sweep.S[moving]
        joints = np.concatenate([S[:, :3] + np.cross(S[:, 3:], p[None], axis=1), S[:, 3:]], axis=1)  # (k, 6, n)
        out[:, told.axes] = -np.moveaxis(np.tensordot(to_axes[:, tree.dof[moving]], joints, 1), 2, 0)
        for sensor, cut in enumerate(equations.cuts):
            if body in tree.cuts[cut.frame]:
                out[:, told.sensor(sensor)] = -np.moveaxis(
                    in_sensor(tree, cut.frame, sweep, np.moveaxis(W, 0, 2)), 2, 0
                )
        yield out


def middles(tree: RigidTree) -> Array:
    """(N, 3) [m] where each body's mass has its centre, in its frame."""
    mass = tree.phi[:, :1]
    return np.asarray(np.where(mass > 0.0, tree.phi[:, 1:4] / np.where(mass > 0.0, mass, 1.0), 0.0))


def reaches(tree: RigidTree, criteria: Touching) -> Array:
    """(N,) [m] how far from its middle a body is pushed, as a standard deviation."""
    length = 2.0 * np.linalg.norm(middles(tree), axis=1)
    for k, parent in enumerate(tree.parent):
        if parent >= 0:
            length[parent] = max(length[parent], float(np.linalg.norm(tree.T_before[k].translation)))
    return np.asarray(np.maximum(criteria.nearest_m, criteria.of_length * length))


def _without_level(e: Array, window: int) -> Array:
    """(n, K) e less the median over `window` samples around each, NaN left out."""
    if not len(e):
        return e
    half = max(window // 2, 1)
    padded = np.pad(e, ((half, half), (0, 0)), constant_values=np.nan)
    level = np.empty_like(e)
    for kind in range(e.shape[1]):
        near = np.sort(np.lib.stride_tricks.sliding_window_view(padded[:, kind], 2 * half + 1), axis=1)  # NaN last
        count = np.isfinite(near).sum(axis=1)
        at = np.maximum(count - 1, 0)
        rows = np.arange(len(near))
        level[:, kind] = 0.5 * (near[rows, at // 2] + near[rows, (at + 1) // 2])
    return e - level


def _usual(e: Array, criteria: Touching) -> float:
    """A standard deviation that rare large values do not move."""
    size = np.abs(e[np.isfinite(e)])
    if len(size) < criteria.rows:
        return float("nan")
    by_most = float(np.quantile(size, criteria.most)) / criteria.most_std
    return max(criteria.mad_std * float(np.median(size)), by_most)


def _by_speed(model: RobotModel, logs: Sequence[tuple[Prepared, Array]]) -> list[tuple[Array, Array]]:
    """Per axis: edges of its speeds, and (SPEEDS,) how much larger than usual errors are between them, all logs
    together: what friction leaves at one speed it leaves whenever the axis is that fast."""
    found, criteria = [], model.criteria.contact
    for axis in range(len(model.robot.joints)):
        kind = model.equations.layout.told.axis(axis)
        speeds, sizes = [], []
        for prepared, e in logs:
            usual = _usual(e[:, kind], criteria)
            used = np.isfinite(e[:, kind])
            if np.isfinite(usual) and usual > 0.0:
                speeds.append(np.abs(prepared.axis_velocity[prepared.kept, axis])[used])
                sizes.append(e[used, kind] / usual)
        if not speeds:
            found.append((np.zeros(0), np.ones(1)))
            continue
        speed, size = np.concatenate(speeds), np.concatenate(sizes)
        edges = np.unique(np.quantile(speed, np.arange(1, criteria.speeds) / criteria.speeds))
        part = np.searchsorted(edges, speed)
        ratios = np.array([_usual(size[part == k], criteria) for k in range(len(edges) + 1)])
        found.append((edges, np.maximum(np.nan_to_num(ratios, nan=1.0), 1.0)))
    return found


def _weights(model: RobotModel, prepared: Prepared, e: Array, ratios: Sequence[tuple[Array, Array]]) -> Array:
    weight, criteria = np.zeros_like(e), model.criteria.contact
    for kind, row in enumerate(model.equations.layout.told.rows):
        usual = _usual(e[:, kind], criteria)
        if not np.isfinite(usual) or usual <= 0.0:
            continue
        std = np.full(len(e), usual)
        if row.type == RowType.AXIS:
            edges, ratio = ratios[row.place]
            std *= ratio[np.searchsorted(edges, np.abs(prepared.axis_velocity[prepared.kept, row.place]))]
        weight[:, kind] = np.isfinite(e[:, kind]) / (std**2 * residual_memory(e[:, kind]))
    return weight


def _skew(p: Array) -> Array:
    """(n, 3, 3) of p (3, n): skew(p) F = p x F."""
    out = np.zeros((p.shape[1], 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -p[2], p[1], -p[0]
    return out - np.swapaxes(out, 1, 2)
