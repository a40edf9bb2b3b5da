"""Which of many other readings of positions are worth a full comparison: the same fit, with the bodies as described."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.plausibility.axis_fit import AS_DESCRIBED, GAINS, explained
from exogauge.plausibility.described import asked_of
from exogauge.plausibility.expectation import on_axes, sliding
from exogauge.plausibility.remedies import Remedy
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion

Array = NDArray[np.float64]


@final
class Screen:
    """What a reading gains by `AxisFit`'s model without doubt of the bodies: a hundredth of the work, and no verdict.

    axes: (A,) those that tell.
    """

    def __init__(self, robot: Robot, seen: Sequence[Snapshot], axes: Sequence[int]) -> None:
        self._robot, self._paths = robot, ContactPaths(robot) if robot.contacts else None
        self._criteria, self._seen = seen[0].criteria, seen
        self._tells = np.isin(np.arange(len(robot.joints)), axes)

    def best(self, remedies: Sequence[Remedy], touched: Sequence[Sequence[int]]) -> list[Remedy]:
        """Of `remedies`, each with the axes that it touches, those that gain nearly as much as the best, it first.

        A few moments of one log tell most of them from those that are asked of more.
        """
        criteria, kept = self._criteria, [*zip(remedies, touched, strict=True)]
        for logs, step, most in ((1, 2, 8 * criteria.most_screened), (2, 1, criteria.most_screened)):
            if len(kept) > criteria.most_screened:
                gains = np.sum(
                    [self._gains(each.every(step), *zip(*kept, strict=True)) for each in self._seen[:logs]], 0
                )
                least = max(1e-9, criteria.screened * float(gains.max())) if logs > 1 else 1e-9
                order = np.argsort(-gains, kind="stable")[:most].tolist()
                kept = [kept[k] for k in order if gains[k] >= least]
        return [remedy for remedy, _ in kept]

    def gains(self, remedies: Sequence[Remedy], touched: Sequence[Sequence[int]]) -> Array:
        """(R,) in log likelihood of two logs at the most: no verdict, but a hundredth of the work of one."""
        found = [self._gains(each, remedies, touched) for each in self._seen[:2]]
        return np.asarray(np.sum(found, axis=0))

    def _gains(self, seen: Snapshot, remedies: Sequence[Remedy], touched: Sequence[Sequence[int]]) -> Array:
        """(R,) in log likelihood, over the moments in which an axis moves by both readings."""
        at_once = 64  # readings: their motions in one pass cost less, and some 100 MB at the most
        now = _Terms(self._robot, self._paths, [seen])
        found = [np.zeros(0)]
        for start in range(0, len(remedies), at_once):
            then = _Terms(self._robot, self._paths, [each.undo(seen) for each in remedies[start : start + at_once]])
            counts = np.zeros((len(then.moving), len(self._tells)), dtype=bool)
            for own, axes in zip(counts, touched[start : start + at_once], strict=True):
                own[list(axes)] = True
            both = now.moving & then.moving
            change = then.likelihoods(both) - now.likelihoods(both)
            found.append(np.sum(change * (counts & self._tells), axis=1))
        return np.concatenate(found)


@final
class _Terms:
    """Of R readings of one log with N moments: what the bodies bear, how the axes move, what was measured."""

    def __init__(self, robot: Robot, paths: ContactPaths | None, readings: Sequence[Snapshot]) -> None:
        self._criteria = readings[0].criteria
        q, dq, ddq, acc, gyro, gyro_dot = (
            np.concatenate([getattr(each, name) for each in readings])
            for name in ("q", "dq", "ddq", "acc", "gyro", "gyro_dot")
        )
        C = robot.axes_from_joints
        load = asked_of(robot, Motion(q, dq, ddq, acc, gyro, gyro_dot), readings[0].recording)[:, robot.rows.axes]
        if paths is not None:
            wrenches = np.concatenate([each.wrenches for each in readings])
            load = load - paths.effect(q, wrenches)[:, robot.rows.axes]
        shape = (len(readings), -1, load.shape[1])
        velocity, acceleration = (dq @ C.T).reshape(shape), (ddq @ C.T).reshape(shape)
        effort = np.stack([on_axes(robot, each.effort) for each in readings])
        self.moving = np.stack([sliding(robot, each) for each in readings])
        self._columns = np.stack(
            [effort, load.reshape(shape), velocity, np.sign(velocity), acceleration, np.ones_like(velocity)], axis=-1
        )

    def likelihoods(self, moments: NDArray[np.bool_]) -> Array:
        """(R, A) log likelihood of each axis' effort by the best factor near one. moments: (R, N, A) that count."""
        X = np.moveaxis(self._columns * moments[..., None], 1, 2)  # (R, A, N, 6)
        count = np.maximum(moments.sum(axis=1), 1)
        G = np.swapaxes(X, -1, -2) @ X
        size = np.sqrt(np.maximum(np.einsum("...ii->...i", G), 1e-12))
        size[..., :2] = 1.0
        G = (G / (size[..., :, None] * size[..., None, :]))[:, :, None]
        gains = GAINS[AS_DESCRIBED]
        b = G[..., 0, 2:] - gains[:, None] * G[..., 1, 2:]
        M = np.broadcast_to(G[..., 2:, 2:], (*b.shape, 4))
        most, _ = explained(M.reshape(-1, 4, 4), b.reshape(-1, 4))
        plain = G[..., 0, 0] - 2.0 * gains * G[..., 0, 1] + gains**2 * G[..., 1, 1]
        left = np.maximum(plain - most.reshape(plain.shape), 0.0).min(axis=2) / count
        least = self._criteria.unmodelled[0] ** 2 * G[..., 0, 0, 0] / count
        return np.asarray(-0.5 * self._criteria.independent * count * np.log(left + least + 1e-18))
