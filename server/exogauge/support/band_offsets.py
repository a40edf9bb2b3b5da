"""A constant torque that a joint has in one log and not in the next: unknown, near zero, and no band's.

    e = A θ + o + n,    o ~ N(0, s²),    γ = W / (W + s⁻²),    W = Σ w

over the samples of one log and joint, whose weights are w. With o integrated out, the information is
Aᵀ w A - γ W m mᵀ, m the weighted mean of A's rows; the score is Aᵀ w (e - γ mean(e)). With s = 0 nothing is changed.
The same as a column of ones per log and joint, each believed to be 0 ± s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.support.band_rows import WearLogs

Array = NDArray[np.float64]


def shares(logs: WearLogs, weight: Array) -> Array:
    """(L, D) γ: how much of a mean error is taken for an offset. weight: (N, D) [1/(N·m)²]."""
    W = _by_log(logs, weight)
    return np.asarray(W * logs.zero_std**2 / (1.0 + W * logs.zero_std**2))


def offsets(logs: WearLogs, weight: Array, e: Array) -> Array:
    """(L, D) [N·m] γ mean(e) of errors e (N, D): the likeliest offset of each log and joint."""
    return shares(logs, weight) * _means(logs, weight, e)


def without_offsets(logs: WearLogs, weight: Array, X: Array) -> Array:
    """(N, D, …) X - γ mean(X): what of errors or slopes is left beside offsets."""
    if not logs.zero_std.any():
        return X
    gamma = shares(logs, weight).reshape(*logs.zero_std.shape, *(1,) * (X.ndim - 2))
    return _less_in_each(logs, X, gamma * _means(logs, weight, X))


def whitened(logs: WearLogs, weight: Array, X: Array) -> Array:
    """(N, D, …) X - c mean(X), c = 1 - √(1 - γ): its weighted squares are the information that offsets leave."""
    if not logs.zero_std.any():
        return X
    gamma = shares(logs, weight)
    c = (gamma / (1.0 + np.sqrt(1.0 - gamma))).reshape(*gamma.shape, *(1,) * (X.ndim - 2))
    return _less_in_each(logs, X, c * _means(logs, weight, X))


def paid(logs: WearLogs, weight: Array, e: Array) -> float:
    """Σ (o / s)²: what the likeliest offsets of errors e (N, D) cost."""
    if not logs.zero_std.any():
        return 0.0
    std = logs.zero_std
    return float(np.sum(np.divide(offsets(logs, weight, e), std, out=np.zeros_like(std), where=std > 0.0) ** 2))


def score_of_offsets(logs: WearLogs, told: Array) -> Array:
    """(P, P) of the score, from offsets of the declared size. told: (N, D, P) w (A - γ mean(A))."""
    moved = (_by_log(logs, told) * logs.zero_std[:, :, None]).reshape(-1, told.shape[2])
    return np.asarray(moved.T @ moved)


def _means(logs: WearLogs, weight: Array, X: Array) -> Array:
    """(L, D, …)"""
    w = weight.reshape(*weight.shape, *(1,) * (X.ndim - 2))
    W = _by_log(logs, w)
    return np.asarray(_by_log(logs, w * X) / np.where(W > 0.0, W, 1.0))


def _by_log(logs: WearLogs, X: Array) -> Array:
    """(L, D, …) sums."""
    return np.stack([X[span].sum(axis=0) for span in logs.spans])


def _less_in_each(logs: WearLogs, X: Array, values: Array) -> Array:
    """X less what is each log's own, (L, D, …)."""
    out = np.empty_like(X)
    for span, own in zip(logs.spans, values, strict=True):
        np.subtract(X[span], own, out=out[span])
    return out
