"""What a candidate would gain: the baseline fitted again beside it, by one small solve in the sums."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from exogauge.discrepancy.candidates import Candidate
from exogauge.discrepancy.sums import KindSums
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

BLIND = 1e-9  # share of a column left once the baseline is taken out, below which the baseline swallows it
NEARLY_ALL = 0.999  # of the square sum: no candidate is credited with more


@final
@dataclass(frozen=True)
class Score:
    """gain: reduction of the fitted cost [weighted squares]. evidence: twice the log likelihood gained with coloured
    residuals, less a price per value that was chosen (BIC). coefficients: (C,). step: (P,) what the baseline moves by.
    left: share of the candidate that the baseline cannot take its place in, 0…1.
    """

    candidate: Candidate
    gain: float
    evidence: float
    coefficients: Array
    step: Array
    left: float


def score(
    model: RobotModel, candidate: Candidate, sums: Mapping[int, KindSums], memory: Mapping[int, float]
) -> Score | None:
    """sums: of the candidate's columns over the fitted logs, by kind of row. memory: kind -> samples that count as one.

    None where the baseline swallows it, or nothing weighs.
    """
    weights, own = model.solution.weights, model.equations.columns()
    live = {kind: each for kind, each in sums.items() if weights[kind] > 0.0 and each.rows}
    if not live:
        return None
    C = candidate.width
    B, squares, g = np.zeros((model.equations.size, C)), np.zeros((C, C)), np.zeros(C)
    for kind, each in live.items():
        B[own[kind]] += weights[kind] * each.cross.T
        squares += weights[kind] * each.own
        g += weights[kind] * each.with_residual
    V = model.solution.unbounded.divided(B)
    size = np.sqrt(np.maximum(np.diag(squares), 1e-300))
    S = (squares - B.T @ V) / np.outer(size, size)
    left = float(np.min(np.linalg.eigvalsh(S)))
    if left < BLIND:
        return None
    theta = _within_range(S, g / size, candidate, size)
    gain = float(2.0 * (g / size) @ theta - theta @ S @ theta)
    independent = sum(each.rows / memory[kind] for kind, each in live.items())
    square = sum(weights[kind] * each.square for kind, each in live.items())
    share = float(np.clip(gain / max(square, 1e-300), 0.0, NEARLY_ALL))
    chosen = C + len(candidate.shape)
    evidence = -independent * np.log1p(-share) - chosen * np.log(max(independent, 2.0))
    coefficients = theta / size
    return Score(candidate, gain, float(evidence), coefficients, -V @ coefficients, left)


def _within_range(S: Array, g: Array, candidate: Candidate, size: Array) -> Array:
    """(C,) least squares in scaled coefficients, each within its physical range."""
    low = np.array([q.low for q in candidate.effect.coefficients]) * size
    high = np.array([q.high for q in candidate.effect.coefficients]) * size
    theta = np.linalg.solve(S, g)
    if np.all(theta >= low) and np.all(theta <= high):
        return np.asarray(theta)
    L = np.linalg.cholesky(S)
    return np.asarray(lsq_linear(L.T, np.linalg.solve(L, g), bounds=(low, high)).x)


def residual_memory(residuals: Array) -> float:
    """Samples of one kind of row's residuals (n,) that count as one: their integral correlation time. NaN: gaps."""
    e = np.nan_to_num(residuals)
    used = np.isfinite(residuals)
    n = len(e)
    if used.sum() < 20:
        return 1.0
    e = np.where(used, e - e[used].mean(), 0.0)
    products, pairs = (np.fft.irfft(np.abs(np.fft.rfft(x, 2 * n)) ** 2)[: n // 2] for x in (e, used.astype(float)))
    rho = products / np.maximum(pairs, 1.0)
    rho = rho / max(float(rho[0]), 1e-300)
    positive = np.cumprod(rho > 0.0)
    return float(1.0 + 2.0 * np.sum(rho[1:] * positive[1:]))
