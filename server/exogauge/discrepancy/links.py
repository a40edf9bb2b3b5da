"""Links that weigh other than their maker says, by more than he doubts: a payload, a part that was changed.

A free inertia absorbs a payload, so no residual shows it. What shows it is the distance of the data from the prior: how
much more likely the data become when one link's inertia is let go, over all that the stated doubts allow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from exogauge.discrepancy.score import residual_memory
from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.identification.model import RobotModel
from exogauge.logs.model import Log
from exogauge.robots.kinematics import forward

Array = NDArray[np.float64]

MASS_KG, REACH_M = 1.0, 0.1  # of what might hang on a link, and how far from its frame: std of a broad belief
BROAD = np.array([MASS_KG, *([MASS_KG * REACH_M] * 3)])
MEMORY = 4.0  # samples that count as one, at least: residuals are coloured, and more so where more is missing
SURE = 20.0  # twice the log likelihood ratio: odds of e^10, before some forty links are counted
SIGNIFICANT = 4.0  # standard deviations of the mass
TELL_APART = 6.0  # by which the best link must stand above another one
MOST = 2
BASE_TURNS = 0.02  # rms angular velocity of a floating base [rad/s], below which nothing is claimed of any link
TILTS, THINNED = (
    0.15,
    500,
)  # rms turn of gravity in a body's frame [rad] that shows its weight; samples of a log looked at


@final
@dataclass(frozen=True)
class LinkScore:
    """evidence: twice the log likelihood ratio for this link being let go. change: (4,) of mass [kg] and first moments
    [kg·m], std: (4,) their doubt."""

    body: int
    evidence: float
    change: Array
    std: Array


@final
@dataclass(frozen=True)
class OddLink:
    """The link that explains best why the data lie far from the prior, and those that would do as well."""

    best: LinkScore
    alike: tuple[LinkScore, ...]
    others: tuple[LinkScore, ...]


def odd_links(model: RobotModel, logs: Sequence[Log]) -> list[OddLink]:
    """One after the other: what the first explains is taken out before the next is sought. logs: the fitted ones.

    A link that hardly tilts in them, such as a foot on the ground, is never claimed: its columns hold the noise of the
    measured acceleration, which the residual holds too.
    """
    bodies = _tilting(model, logs)
    solution, prior = model.solution, model.solution.prior
    memory = _memory(model, logs)
    data = PriorLeastSquares(solution.statistics.square_root(solution.weights / memory), prior, solution.strength)
    R, z = data.information, data.target - data.information @ prior.seen_mean[prior.free]
    covariance = np.eye(len(z)) + R @ prior.seen_covariance[np.ix_(prior.free, prior.free)] @ R.T
    pulls = {body: R @ prior.seen[prior.free][:, 10 * body : 10 * body + 4] * BROAD for body in bodies}
    found: list[OddLink] = []
    while len(found) < min(MOST, len(bodies)):
        half = np.linalg.cholesky(covariance)
        white = sl.solve_triangular(half, z, lower=True)
        scores = [_score(body, sl.solve_triangular(half, pulls[body], lower=True), white) for body in bodies]
        scores = [each for each in scores if each.body not in {one.best.body for one in found}]
        ordered = sorted(scores, key=lambda each: -each.evidence)
        best = ordered[0]
        if best.evidence < SURE or abs(best.change[0]) < SIGNIFICANT * best.std[0]:
            break
        alike = tuple(each for each in ordered[1:] if best.evidence - each.evidence < TELL_APART)
        found.append(OddLink(best, alike, tuple(each for each in ordered[1:4] if each not in alike)))
        covariance = covariance + pulls[best.body] @ pulls[best.body].T
    return found


def _memory(model: RobotModel, logs: Sequence[Log]) -> Array:
    """(rows,) samples of each kind of row that count as one: as many as its residual remembers, in the median log."""
    equations, x = model.equations, model.solution.unbounded.x
    of_logs = []
    for log in logs:
        prepared = model.prepare(log)
        residual = equations.residuals(prepared, x)
        steady = slice(equations.first_axis, equations.first_axis + len(model.robot.joints))
        residual[:, steady][~prepared.steady[prepared.kept]] = np.nan
        of_logs.append([residual_memory(each) for each in residual.T])
    return np.maximum(np.median(of_logs, axis=0), MEMORY)


def _tilting(model: RobotModel, logs: Sequence[Log]) -> list[int]:
    """Bodies across which gravity turns enough to show what they weigh."""
    up, turning = [], []
    for log in logs:
        prepared = model.prepare(log)
        turning.append(prepared.motion.gyro[prepared.kept])
        states = forward(
            model.robot.tree, prepared.motion.rows(prepared.kept[:: max(1, len(prepared.kept) // THINNED)])
        )
        pulled = states.proper_acceleration
        up.append(pulled / np.maximum(np.linalg.norm(pulled, axis=2, keepdims=True), 1e-12))
    if model.robot.floating and np.sqrt(np.mean(np.concatenate(turning) ** 2)) < BASE_TURNS:
        return []  # all that its accelerometer says beside gravity is noise
    spread = np.sqrt(np.sum(np.var(np.concatenate(up), axis=0), axis=1))
    return [body for body, each in enumerate(spread) if each > TILTS]


def _score(body: int, U: Array, white: Array) -> LinkScore:
    """U: (m, 4) the link's broad belief in whitened rows."""
    inner = np.eye(4) + U.T @ U
    projected = U.T @ white
    solved = np.linalg.solve(inner, projected)
    evidence = float(projected @ solved - np.linalg.slogdet(inner)[1])
    std = BROAD * np.sqrt(np.maximum(np.diag(np.linalg.inv(inner)), 0.0))
    return LinkScore(body, evidence, BROAD * solved, std)


def carries_nothing(model: RobotModel, body: int) -> bool:
    """Whether no other moving body hangs on this one, or only fingers' worth of mass: where a payload is carried."""
    tree = model.robot.tree
    carried: Sequence[int] = [k for k in range(len(tree.bodies)) if tree.parent[k] == body]
    return float(sum(tree.phi[k, 0] for k in carried)) < 0.05 * tree.mass and not any(
        tree.parent[k] in carried for k in range(len(tree.bodies))
    )
