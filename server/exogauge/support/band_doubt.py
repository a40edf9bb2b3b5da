"""How far identified bands can be believed: coloured residuals, the robot's parameters, and what is not modelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from exogauge.devices.band_fit import BandFit, Belief, tension_and_pull
from exogauge.devices.result import Approach
from exogauge.identification.model import RobotModel
from exogauge.support.band_samples import BandSamples, counted
from exogauge.support.evidence import Evidence

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class NullLog:
    """A log without the device, n samples: where the bands would be, and the torque that B and the prior find there.

    length: (n, W). jacobian: (n, W, D). b, a_priori: (n, D) [N·m]. steady: (n, D). share: how many logs with the
    device, each as long as this one, it stands for.
    """

    length: Array
    jacobian: Array
    b: Array
    a_priori: Array
    steady: BoolArray
    share: float


def covariance(
    model: RobotModel,
    approach: Approach,
    fit: BandFit,
    samples: BandSamples,
    sigma: Array,
    evidences: Sequence[Evidence],
    null_logs: Sequence[NullLog],
    beliefs: Sequence[Belief],
) -> Array:
    """(P, P) of the estimate about the truth, inf on the diagonal where the data hold nothing.

    H^-1 (S + G C G^T + n n^T) H^-1 with H the curvature; S what errors of this kind make of the score (they last);
    C the covariance of the robot's parameters and G how the score moves with them; n the score that the approach finds
    on logs without the device, where it ought to be zero: what the model lacks there it lacks with the device too.
    """
    meat = score_covariance(fit, samples, sigma)
    for belief in beliefs:
        meat[belief.index, belief.index] += belief.std**-2
    G = sum(_moved(fit, approach, each, sigma) for each in evidences)
    C = model.a_priori_covariance if approach == "prior" else model.covariance
    meat += G @ C @ np.transpose(G)
    if approach != "A":
        n = sum((_null_score(fit, approach, each, sigma) for each in null_logs), start=np.zeros(len(fit.theta)))
        meat += np.outer(n, n)
    scale = fit.layout.scale
    H = fit.hessian * np.outer(scale, scale)
    inverse = np.linalg.pinv(H, rcond=1e-9, hermitian=True)
    return np.asarray(inverse @ (meat * np.outer(scale, scale)) @ inverse * np.outer(scale, scale))


def _moved(fit: BandFit, approach: Approach, evidence: Evidence, sigma: Array) -> Array:
    """(P, X) change of the score Σ G^T w τ with the robot's X parameters, from the samples at which slopes are kept."""
    at = evidence.sloped
    slope = evidence.slope_a if approach == "A" else evidence.slope_b
    assert slope is not None
    pull = tension_and_pull(fit.layout, evidence.length[at], fit.theta)[1]
    weight = counted(evidence, approach)[at] / sigma**2
    g = -np.einsum("nwp,nwd->ndp", pull, evidence.jacobian[at]) * weight[:, :, None]
    every = len(evidence.kept) / len(at)
    flat = g.reshape(-1, g.shape[2]).astype(np.float32)
    return every * np.asarray(flat.T @ slope.reshape(-1, slope.shape[2]), dtype=np.float64)


def _null_score(fit: BandFit, approach: Approach, log: NullLog, sigma: Array) -> Array:
    """(P,) Σ G^T w τ on a log where τ ought to be zero."""
    pull = tension_and_pull(fit.layout, log.length, fit.theta)[1]
    torque = (log.b if approach == "B" else log.a_priori) * log.steady / sigma**2
    score: Array = np.einsum("nwp,nwd,nd->p", pull, log.jacobian, torque, optimize=True)
    return -log.share * score


def score_covariance(fit: BandFit, samples: BandSamples, sigma: Array) -> Array:
    """(P, P) of Σ G^T w e: no less in any direction than either of two estimates. sigma: (D,) [N·m] of the weights.

    Sums over blocks see that errors are larger in places; but few blocks stretch the bands, and those are the ones that
    the fit bends to, so that their spread is too small: by a fifth in trials with one or two logs, where 95 % intervals
    held the truth in 85 draws of 100. The autocovariance of the residuals takes errors to be alike throughout a log,
    and has no such bias where they are.
    """
    scores = fit.scores(samples.blocks(fit))
    by_blocks = scores.T @ scores * (len(scores) / max(len(scores) - 1.0, 1.0))
    return _larger(by_blocks, _by_autocovariance(fit, samples, sigma))


def _by_autocovariance(fit: BandFit, samples: BandSamples, sigma: Array) -> Array:
    """Σ g^T C g over logs and joints; g: (n, P) weighted slopes of a joint's torque, C: covariance of its errors."""
    total = np.zeros((len(fit.theta),) * 2)
    residual = samples.residual(fit)
    for log in range(len(samples.rate_hz)):
        own = samples.log == log
        pull = tension_and_pull(fit.layout, samples.length[own], fit.theta)[1]
        for joint, (e, used) in enumerate(zip(residual[own].T, samples.used[own].T, strict=True)):
            g = np.einsum("nwp,nw->np", pull, samples.jacobian[own, :, joint]) * (used / sigma[joint] ** 2)[:, None]
            c = autocovariance(e, used)
            total += g.T @ fftconvolve(g, np.concatenate([c[:0:-1], c])[:, None], mode="same", axes=0)
    return 0.5 * (total + total.T)


def autocovariance(errors: Array, used: BoolArray) -> Array:
    """(lags,) about zero, up to half of the log or to where it is first not positive. errors: (n,), 0 where unused."""
    n = len(errors)
    products, pairs = (np.fft.irfft(np.abs(np.fft.rfft(x, 2 * n)) ** 2)[: max(n // 2, 1)] for x in (errors, used))
    c: Array = products / np.maximum(pairs, 1.0)
    positive = np.cumprod(c > 0.0)
    positive[0] = 1
    return c[: int(positive.sum())]


def _larger(first: Array, second: Array) -> Array:
    """The first, and what the second has more of in any direction."""
    size = np.sqrt(np.maximum(np.diag(first) + np.diag(second), 1e-300))
    more, directions = np.linalg.eigh((second - first) / np.outer(size, size))
    return np.asarray(first + (directions * np.maximum(more, 0.0)) @ directions.T * np.outer(size, size))
