"""Slopes of sums of regressor rows are the dense regressor's differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import regressor
from exogauge.robots.row_slopes import MotionSlopes, WeightedRow, row_slopes
from exogauge.robots.tree import RigidTree

STEP = 1e-5


def weighted(tree: RigidTree, motion: Motion, G: np.ndarray) -> MotionSlopes:
    """G: (T, rows, N, 10) weights of every entry of the dense regressor."""
    kinematics, base = Kinematics(tree), 6 if tree.floating else 0
    sweep, every = kinematics.sweep(motion), np.arange(len(tree.bodies))
    rows = []
    for k in range(base):
        axis = np.zeros((motion.samples, 6))
        axis[:, k] = 1.0
        rows.append(WeightedRow(axis, -1, every, np.moveaxis(G[:, k], 0, 1)))
    for joint in range(len(tree.joints)):
        body = int(np.flatnonzero(tree.dof == joint)[0])
        carried = np.flatnonzero(tree.subtree[body])
        rows.append(WeightedRow(sweep.S[body].T, body, carried, np.moveaxis(G[:, base + joint][:, carried], 0, 1)))
    return row_slopes(kinematics, motion, sweep, rows)


@pytest.mark.parametrize("name", ["odd", "odd_fixed"])
def test_slopes_of_rows_are_their_differences(robot, name: str) -> None:
    """A robot with a sliding joint, odd axes and a tree that branches, floating and fixed."""
    tree = robot(name)[0]
    rng, T = np.random.default_rng(3), 2
    q, dq, ddq = (rng.uniform(-0.8, 0.8, (T, len(tree.joints))) * size for size in (1.0, 2.0, 5.0))
    motion = Motion(q, dq, ddq, *(rng.standard_normal((T, 3)) * size for size in (9.0, 1.0, 3.0)))
    G = rng.standard_normal((T, (6 if tree.floating else 0) + len(tree.joints), len(tree.bodies), 10))

    def total(of: Motion) -> float:
        return float(np.sum(regressor(tree, of).reshape(G.shape) * G))

    slopes = weighted(tree, motion, G)
    for kind in ("q", "dq", "ddq", "acc", "gyro", "gyro_dot"):
        values = getattr(motion, kind)
        for at in np.ndindex(values.shape):
            there, back = values.copy(), values.copy()
            there[at] += STEP
            back[at] -= STEP
            by_differences = (total(replace(motion, **{kind: there})) - total(replace(motion, **{kind: back}))) / (
                2 * STEP
            )
            assert getattr(slopes, kind)[at] == pytest.approx(by_differences, rel=1e-6, abs=1e-6), (kind, at)
