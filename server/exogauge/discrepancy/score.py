"""What a candidate would gain: the baseline fitted again beside it, by one small solve in the sums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from exogauge.discrepancy.candidates import Candidate
from exogauge.discrepancy.sums import AxisSums
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

BLIND = 1e-9  # share of a column left once the baseline is taken out, below which the baseline swallows it
NEARLY_ALL = 0.999  # of an axis' square sum: no candidate is credited with more


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


def score(model: RobotModel, candidate: Candidate, sums: AxisSums, memory: float) -> Score | None:
    """sums: of the candidate's columns over the fitted logs. memory: samples that count as one. None where blind."""
    equations, solution = model.equations, model.solution
    kind = equations.first_axis + candidate.axis
    w, own = solution.weights[kind], equations.columns()[kind]
    if w <= 0.0 or sums.rows == 0:
        return None
    B = np.zeros((equations.size, len(sums.own)))
    B[own] = w * sums.cross.T
    V = model.solution.unbounded.divided(B)
    S = w * sums.own - B.T @ V
    size = np.sqrt(np.maximum(np.diag(sums.own) * w, 1e-300))
    S = S / np.outer(size, size)
    left = float(np.min(np.linalg.eigvalsh(S)))
    if left < BLIND:
        return None
    g = w * sums.with_residual / size
    theta = _within_range(S, g, candidate, size)
    gain = float(2.0 * g @ theta - theta @ S @ theta)
    independent = sums.rows / memory
    share = float(np.clip(gain / (w * sums.square), 0.0, NEARLY_ALL))
    chosen = candidate.width + len(candidate.shape)
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
    """Samples of one axis' residuals (n,) that count as one: their integral correlation time. NaN are gaps."""
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
