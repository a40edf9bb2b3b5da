"""What is asked, with arms that slide along what is in their way in place of going through it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import MotionPlan
from exogauge.motion.plan.asked import Asked, on_its_feet
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.touching import Pairs

Array = NDArray[np.float64]


def cleared(robot: MotionRobot, asked: Asked, pairs: Pairs, criteria: MotionPlan) -> Asked:
    """asked, where nothing of it touches; else with the postures of limbs that come nearest to it, one after the other
    from the one before: what is in the way is gone round, and never jumped over. The trunk stays as it is asked."""
    legs = np.concatenate([robot.leg(k) for k in range(len(robot.soles))])
    limbs = np.setdiff1d(np.flatnonzero(asked.stray > criteria.trunk_rad), legs)
    limbs = limbs[limbs >= robot.base]
    standing = np.stack([on_its_feet(robot, *each) for each in zip(asked.q, asked.place, strict=True)])
    near = pairs.near(standing, criteria.apart_m)
    moves = np.abs(pairs.slopes(standing, near)[:, limbs]).max(axis=1, initial=0.0) > 0.0
    if not (near.distance[moves] < np.minimum(criteria.apart_m, pairs.at_home[near.pair[moves]]) - 1e-6).any():
        return asked
    lower, upper = (each[limbs - robot.base] for each in (robot.limits.lower, robot.limits.upper))
    q, before = asked.q.copy(), standing[0, limbs]
    for t, posture in enumerate(standing):
        now = posture.copy()
        now[limbs] = before
        for _ in range(criteria.slides):
            step = _towards(pairs, now, limbs, asked.q[t, limbs] - now[limbs], criteria)
            step *= min(1.0, criteria.slide_rad / max(float(np.abs(step).max()), 1e-12))
            now[limbs] = np.clip(now[limbs] + step, lower, upper)
            if np.abs(step).max() < criteria.slid_rad:
                break
        q[t, limbs] = before = now[limbs]
    return replace(asked, q=q)


def _towards(pairs: Pairs, q: Array, limbs: NDArray[np.intp], wanted: Array, criteria: MotionPlan) -> Array:
    """(L,) the step nearest to the wanted one w that keeps, by slopes J, every pair apart: the least y by which it
    differs with J (w + y) ≥ -gap.

    Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23: least distance by non-negative least squares.
    """
    near = pairs.near(q[None], criteria.look_m)
    J = pairs.slopes(np.broadcast_to(q, (1, len(q))), near)[:, limbs]
    gap = near.distance - np.minimum(criteria.apart_m, pairs.at_home[near.pair])
    moved = np.abs(J).max(axis=1, initial=0.0) > 0.0
    J = J[moved]
    least = np.minimum(-gap[moved], criteria.out_m) - J @ wanted
    if not (least > 0.0).any():
        return wanted
    E = np.vstack([J.T, least])
    f = np.zeros(len(E))
    f[-1] = 1.0
    left = E @ scipy.optimize.nnls(E, f)[0] - f
    return np.asarray(wanted - left[:-1] / left[-1]) if abs(left[-1]) > 1e-9 else np.zeros_like(wanted)
