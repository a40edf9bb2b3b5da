"""How far fitted bands can be believed: coloured residuals, the robot's parameters, and what is not modelled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from exogauge.identification.uncertainty import block_length
from exogauge.support.band_model import Fitted, Setting, columns
from exogauge.support.band_rows import WearLogs
from exogauge.support.band_weights import autocovariance

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


def covariance(
    setting: Setting, fitted: Fitted, robot: Array, null: WearLogs | None = None, joint_weight: Array | None = None
) -> Array:
    """(P, P) of theta about the truth: H⁻¹ (S + G C Gᵀ + n nᵀ + beliefs) H⁻¹, with H the curvature.

    S: what errors of this kind make of the score (they last); C: covariance of the robot's parameters, `robot`, G: how
    the score moves with them; n: the score that the approach finds on logs without the device, `null`, where it ought
    to be zero: what the model lacks there it lacks with the device too (A takes off what repeats). joint_weight: (D,)
    what a sample of those counts.
    """
    meat, S = score_covariance(setting, fitted), len(setting.belief.mean)
    meat[:S, :S] += setting.belief.precision
    G = _moved(setting, fitted)
    if G is not None:
        meat += G @ robot @ G.T
    if null is not None and joint_weight is not None:
        n = _null_score(setting, fitted, null, joint_weight)
        meat += np.outer(n, n)
    size = 1.0 / np.sqrt(np.maximum(np.diag(fitted.hessian), 1e-300))
    inverse = np.linalg.pinv(fitted.hessian * np.outer(size, size), rcond=1e-12, hermitian=True) * np.outer(size, size)
    return np.asarray(inverse @ meat @ inverse)


def score_covariance(setting: Setting, fitted: Fitted) -> Array:
    """(P, P) of Σ Aᵀ w e: no less in any direction than either of two estimates.

    Sums over blocks see that errors are larger in places; but few blocks stretch the bands, and those are the ones that
    the fit bends to, so that their spread is too small: by a fifth in trials with one or two logs, where 95 % intervals
    held the truth in 85 draws of 100. The autocovariance of the residuals takes errors to be alike throughout a log,
    and has no such bias where they are.
    """
    number = blocks(setting.logs, fitted.e)
    rows = np.einsum("ndp,nd->np", fitted.A, setting.weight * fitted.e)
    scores = np.zeros((int(number.max()) + 1, rows.shape[1]))
    np.add.at(scores, number, rows)
    by_blocks = scores.T @ scores * (len(scores) / max(len(scores) - 1.0, 1.0))
    return _larger(by_blocks, _by_autocovariance(setting, fitted))


def blocks(logs: WearLogs, e: Array) -> IntArray:
    """(N,) consecutive samples of a log that are long against the residual's memory share a number."""
    numbers, start = np.zeros(len(logs.log), dtype=np.intp), 0
    for place in range(len(logs.logs)):
        own = np.flatnonzero(logs.log == place)
        used, time = logs.used[own], logs.time[own]
        rate = (len(own) - 1) / max(float(time[-1] - time[0]), 1e-9)
        left = np.where(used, e[own], 0.0)[:, used.any(axis=0)]
        numbers[own] = start + np.arange(len(own)) // (block_length(left, rate) if left.shape[1] else len(own))
        start = int(numbers[own[-1]]) + 1
    return numbers


def _moved(setting: Setting, fitted: Fitted) -> Array | None:
    """(P, X) change of the score with the robot's parameters. Between the samples at which slopes are kept they are
    taken as straight."""
    logs, total = setting.logs, None
    for place, log in enumerate(logs.logs):
        if log.slope is None:
            return None
        m, D, _ = log.slope.shape
        own = np.flatnonzero(logs.log == place)
        g = fitted.A[own][:, :D] * setting.weight[own][:, :D, None]
        between = np.interp(np.arange(len(own)), log.sloped, np.arange(m))
        before = np.minimum(between.astype(np.intp), max(m - 2, 0))
        share = (between - before)[:, None, None]
        at_slopes = np.zeros((m, D, g.shape[2]))
        np.add.at(at_slopes, before, (1.0 - share) * g)
        np.add.at(at_slopes, np.minimum(before + 1, m - 1), share * g)
        flat = at_slopes.reshape(-1, g.shape[2]).astype(np.float32)
        moved = (flat.T @ log.slope.reshape(len(flat), -1)).astype(np.float64)
        total = moved if total is None else total + moved
    return total


def _null_score(setting: Setting, fitted: Fitted, null: WearLogs, joint_weight: Array) -> Array:
    """(P,) Σ Aᵀ w τ on the logs without the wear, each counted as often as it stands for one with it."""
    A = columns(null, [null.wire(wire.course) for wire in setting.wires], fitted.wear)
    w = null.share[:, None] * null.used * joint_weight
    return np.asarray(np.einsum("ndp,nd,nd->p", A, w, null.torque))


def _by_autocovariance(setting: Setting, fitted: Fitted) -> Array:
    """Σ gᵀ C g over logs and joints; g: (n, P) weighted slopes of a joint's torque, C: covariance of its errors."""
    logs, P = setting.logs, fitted.A.shape[2]
    total, felt = np.zeros((P, P)), np.flatnonzero(fitted.A.any(axis=(0, 2)))
    for log in range(len(logs.logs)):
        own = logs.log == log
        for joint in felt:
            used = logs.used[own, joint]
            g = fitted.A[own, joint] * setting.weight[own, joint][:, None]
            c = autocovariance(np.where(used, fitted.e[own, joint], 0.0), used)
            total += g.T @ fftconvolve(g, np.concatenate([c[:0:-1], c])[:, None], mode="same", axes=0)
    return 0.5 * (total + total.T)


def _larger(first: Array, second: Array) -> Array:
    """The first, and what the second has more of in any direction."""
    size = np.sqrt(np.maximum(np.diag(first) + np.diag(second), 1e-300))
    more, directions = np.linalg.eigh((second - first) / np.outer(size, size))
    return np.asarray(first + (directions * np.maximum(more, 0.0)) @ directions.T * np.outer(size, size))
