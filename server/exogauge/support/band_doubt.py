"""How far fitted bands can be believed: coloured residuals, the robot's parameters, and what is not modelled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from exogauge.identification.type_b import ROBOT
from exogauge.identification.uncertainty import block_length
from exogauge.support.band_inputs import inputs_of
from exogauge.support.band_model import Fitted, Setting, columns
from exogauge.support.band_offsets import score_of_offsets, without_offsets
from exogauge.support.band_rows import WearLogs
from exogauge.support.band_weights import autocovariance

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

SCATTER, NULL_TEST, TORQUE_ZERO = "scatter", "null_test", "torque_zero"


def covariance(
    setting: Setting, fitted: Fitted, robot: Array, null: WearLogs | None = None, joint_weight: Array | None = None
) -> Array:
    """(P, P) of theta about the truth: the sum of all `contributions`."""
    found = contributions(setting, fitted, {ROBOT: robot}, null, joint_weight)
    return np.asarray(sum(found.values(), np.zeros_like(fitted.hessian)))


def contributions(
    setting: Setting,
    fitted: Fitted,
    robot: Mapping[str, Array],
    null: WearLogs | None = None,
    joint_weight: Array | None = None,
) -> dict[str, Array]:
    """Name of a source -> (P, P) of theta about the truth: H⁻¹ M H⁻¹, with H the curvature, M of

    scatter: S, what errors of this kind make of the score (they last), and what is believed of the springs;
    robot: G C Gᵀ, C: covariance of the robot's parameters and of what all logs share (`RobotModel.doubt`), or its parts
    by name; G: how the score moves with them;
    kt_drift, ft_zero, via_points, donning: what is declared of each log's motors and sensors, and of how the device
    sits (`band_inputs`);
    null_test: n nᵀ, n: the score that the approach finds on logs without the device, `null`, where it ought to be zero:
    what the model lacks there it lacks with the device too (A takes off what repeats). joint_weight: (D,) what a sample
    of those counts;
    torque_zero: what is left of each log's and joint's own offset. What the others do to the score goes through the
    same slopes, w (A - γ mean(A)): of the feet's zeros what looks like such an offset is taken off as well.
    """
    told, wear = without_offsets(setting.logs, setting.weight, fitted.A), fitted.wear
    fitted = replace(fitted, A=told)
    found, S = {SCATTER: score_covariance(setting, fitted)}, len(setting.belief.mean)
    found[SCATTER][:S, :S] += setting.belief.precision
    G = _moved(setting, fitted)
    if G is not None:
        found |= {name: G @ C @ G.T for name, C in robot.items()}
    inputs = inputs_of(setting.logs, setting.wires, wear.k, wear.l_0)
    weighted = told * setting.weight[:, :, None]
    for name, own in inputs.scores(setting.logs, weighted).items() if inputs else ():
        found[name] = found.get(name, np.zeros_like(own)) + own
    if setting.logs.zero_std.any():
        found[TORQUE_ZERO] = score_of_offsets(setting.logs, weighted)
    if null is not None and joint_weight is not None:
        n = _null_score(setting, fitted, null, joint_weight)
        found[NULL_TEST] = np.outer(n, n)
    size = 1.0 / np.sqrt(np.maximum(np.diag(fitted.hessian), 1e-300))
    inverse = np.linalg.pinv(fitted.hessian * np.outer(size, size), rcond=1e-12, hermitian=True) * np.outer(size, size)
    return {name: np.asarray(inverse @ meat @ inverse) for name, meat in found.items() if meat.any()}


def score_covariance(setting: Setting, fitted: Fitted) -> Array:
    """(P, P) of Σ Aᵀ w e, A without offsets: no less in any direction than either of two estimates.

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
    total = None
    for place, log in enumerate(setting.logs.logs):
        if log.slope is None:
            return None
        moved = _through(setting, fitted, place, log.slope)
        total = moved if total is None else total + moved
    return total


def _through(setting: Setting, fitted: Fitted, place: int, slope: NDArray[np.float32]) -> Array:
    """(P, X) change of the score with X inputs, from the slopes (m, D, X) of one log's torque with them."""
    logs, log = setting.logs, setting.logs.logs[place]
    m, D, _ = slope.shape
    own = np.flatnonzero(logs.log == place)
    g = fitted.A[own][:, :D] * setting.weight[own][:, :D, None]
    between = np.interp(np.arange(len(own)), log.sloped, np.arange(m))
    before = np.minimum(between.astype(np.intp), max(m - 2, 0))
    share = (between - before)[:, None, None]
    at_slopes = np.zeros((m, D, g.shape[2]))
    np.add.at(at_slopes, before, (1.0 - share) * g)
    np.add.at(at_slopes, np.minimum(before + 1, m - 1), share * g)
    flat = at_slopes.reshape(-1, g.shape[2]).astype(np.float32)
    return np.asarray((flat.T @ slope.reshape(len(flat), -1)).astype(np.float64))


def _null_score(setting: Setting, fitted: Fitted, null: WearLogs, joint_weight: Array) -> Array:
    """(P,) Σ Aᵀ w τ on the logs without the wear, each counted as often as it stands for one with it."""
    A = columns(null, [null.wire(wire.course) for wire in setting.wires], fitted.wear)
    own = null.used * joint_weight
    return np.asarray(np.einsum("ndp,nd,nd->p", A, null.share[:, None] * own, without_offsets(null, own, null.torque)))


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
