"""Lowering, holding, raising: the parts of a motion, found from the joint that moves most."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import MOTIONS
from exogauge.robots.kinematics import joint_motions
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

BENDS = ("standing", "lowering", "holding", "raising")
TURNS = ("standing", "turning out", "holding", "turning back")


def find_phases(time: Array, q: Array, dq: Array, main: int) -> IntArray:
    """(T,) 0 standing, 1 away from the posture at the start, 2 holding, 3 back. main: the column of q that decides."""
    angle, rate = q[:, main], dq[:, main]
    away = angle - float(np.median(angle[: max(1, len(angle) // 40)]))
    top, span = float(np.abs(rate).max()), float(np.abs(away).max())
    moving = np.abs(rate) > MOTIONS.moves * max(top, 1e-12)
    phase = np.where(np.abs(away) > MOTIONS.away * span, 2, 0)
    phase = np.where(moving, np.where(rate * np.sign(away) > 0.0, 1, 3), phase)
    return _without_splinters(
        phase, max(1, round(MOTIONS.shortest_phase_s * (len(time) - 1) / max(time[-1] - time[0], 1e-12)))
    )


def main_joint(q: Array) -> int:
    """The column of q (T, D) with the largest range."""
    return int(np.argmax(np.ptp(q, axis=0)))


def phase_names(tree: RigidTree, joint: str) -> tuple[str, ...]:
    """What the phases are called: a joint with an upright axis (at zero posture, seen from the base) turns."""
    body = int(np.flatnonzero(tree.dof == tree.joints.index(joint))[0])
    axis = joint_motions(tree, np.zeros((1, len(tree.joints))))[0, body, 3:]
    return TURNS if abs(float(axis[2])) > MOTIONS.upright else BENDS


def _without_splinters(phase: IntArray, shortest: int) -> IntArray:
    """Parts shorter than `shortest` samples take the phase before them; at the start, that of the first long one."""
    phase = phase.astype(np.intp)
    edges = np.flatnonzero(np.diff(phase)) + 1
    parts = list(zip([0, *edges], [*edges, len(phase)], strict=True))
    begin = next((start for start, stop in parts if stop - start >= shortest), 0)
    phase[:begin] = phase[begin]
    for start, stop in parts:
        if stop - start < shortest and start > begin:
            phase[start:stop] = phase[start - 1]
    return phase
