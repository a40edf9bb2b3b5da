"""How far what was fitted to a wear can be believed: coloured residuals, the robot's parameters, logs without it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.baseline import Ground
from exogauge.detect.device.model import Fitted, columns
from exogauge.search.block_gains import summed

Array = NDArray[np.float64]


def covariance(ground: Ground, fitted: Fitted) -> Array:
    """(P, P) of theta about the truth: H⁻¹ (S + G C Gᵀ + n nᵀ + beliefs) H⁻¹.

    S: what such residuals make of the score, by sums over blocks or by their memory, whichever is more; C: covariance
    of the robot's parameters, G how the score moves with them; n: the score on logs without the wear, where it ought
    to be zero (approach B; A takes off what repeats).
    """
    setting, w = ground.setting, ground.setting.weight
    P, W2 = fitted.A.shape[2], len(setting.belief.mean)
    rows = np.einsum("ndp,nd->np", fitted.A, w * fitted.e)
    blocks = np.column_stack([summed(rows[:, p], setting.logs.block) for p in range(P)])
    by_blocks = blocks.T @ blocks * len(blocks) / max(len(blocks) - 1, 1)
    by_memory = np.einsum("ndp,nd,ndq->pq", fitted.A, w, fitted.A, optimize=True)
    more = np.zeros((P, P))
    more[:W2, :W2] = setting.belief.precision
    G = _moved(ground, fitted)
    if G is not None:
        more += G @ ground.model.covariance @ G.T
    n = _null_score(ground, fitted)
    more += np.outer(n, n)
    size = 1.0 / np.sqrt(np.maximum(np.diag(fitted.hessian), 1e-300))
    inverse = np.linalg.pinv(fitted.hessian * np.outer(size, size), rcond=1e-12, hermitian=True) * np.outer(size, size)
    first, second = (inverse @ (meat + more) @ inverse for meat in (by_blocks, by_memory))
    return np.asarray(np.where(np.diag(first)[:, None] >= np.diag(second)[:, None], first, second))


def deviations(ground: Ground, fitted: Fitted) -> Array:
    """(P,) standard deviations."""
    return np.sqrt(np.maximum(np.diag(covariance(ground, fitted)), 0.0))


def _moved(ground: Ground, fitted: Fitted) -> Array | None:
    """(P, X) change of the score with the robot's parameters, from the samples at which slopes are kept."""
    logs, total = ground.setting.logs, None
    for place, log in enumerate(logs.logs):
        if log.slope is None:
            return None
        first = int(np.flatnonzero(logs.log == place)[0])
        at = first + log.sloped
        D = log.slope.shape[1]
        g = (fitted.A[at][:, :D] * ground.setting.weight[at][:, :D, None]).reshape(-1, fitted.A.shape[2])
        own = len(log.kept) / len(at) * (g.T.astype(np.float32) @ log.slope.reshape(len(g), -1)).astype(np.float64)
        total = own if total is None else total + own
    return total


def _null_score(ground: Ground, fitted: Fitted) -> Array:
    """(P,) Σ Aᵀ w τ on the logs without the wear, each counted as often as it stands for one with it."""
    if ground.null is None:
        return np.zeros(fitted.A.shape[2])
    wires = [ground.null.wire(wire.course) for wire in ground.setting.wires]
    A = columns(ground.null, wires, fitted.wear)
    w = ground.null.used / (ground.sigma**2 * ground.memory)
    return np.asarray(ground.null.share * np.einsum("ndp,nd,nd->p", A, w, ground.null.torque))
