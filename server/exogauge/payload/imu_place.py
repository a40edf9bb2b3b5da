"""Where an IMU sits beside the sensor's origin, and how late its stamps are: found by the motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL as MOVING
from exogauge.criteria.payload_dynamic import Moving
from exogauge.criteria.payload_static import USUAL, Standing
from exogauge.payload.dynamics import Prior, coloured
from exogauge.payload.imu import ImuFrame, Open

Array = NDArray[np.float64]

Rows = Callable[[ImuFrame, int], list[Array]]
"""(frame, every) -> [A, J, b] (T, 6, 27) of each log, every so many samples; J (16): by what its covariance is of."""


def find_place(frame: ImuFrame, rows: Rows, body: Prior, stated: float | None, criteria: Standing = USUAL,
               moving: Moving = MOVING) -> ImuFrame:  # fmt: skip
    """Where it sits and how late it is, at which wrenches are explained best by a body that is known so well. stated:
    std [s] of a delay that is known; None where it is sought."""
    covariance = frame.covariance.copy()
    covariance[Open.PLACE, Open.PLACE] = criteria.imu_place_m**2 * np.eye(3)
    frame = replace(frame, covariance=covariance)
    if stated is None:
        latest = criteria.latest_imu_s

        def left(lag: float) -> float:
            return _left(replace(frame, lag_s=lag), rows, body)

        best = scipy.optimize.minimize_scalar(left, bounds=(-latest, latest), method="bounded",
                                              options={"xatol": 1e-4})  # fmt: skip
        frame = replace(frame, lag_s=float(best.x))
    return _closer(frame, rows(frame, 1), body, stated, moving.memories)


def farther_lag(found: ImuFrame, rows: Rows, body: Prior, criteria: Standing = USUAL) -> float | None:
    """[s] a lag beyond those that `find_place` looks at, by tens of milliseconds, that explains wrenches clearly better
    than the one it found at its end; None where it found one inside, or none is better."""
    latest, step, most = criteria.latest_imu_s, 0.02, 0.5
    if abs(found.lag_s) < 0.95 * latest:
        return None
    lags = np.sign(found.lag_s) * np.arange(latest + step, most, step)
    each = [_left(replace(found, lag_s=float(lag)), rows, body) for lag in lags]
    best = int(np.argmin(each))
    return float(lags[best]) if each[best] * criteria.clearly < _left(found, rows, body) else None


def _left(frame: ImuFrame, rows: Rows, body: Prior) -> float:
    """Mean square of what the best body and place leave of wrenches, at the frame's lag."""
    every = 4  # samples: enough to find a lag by
    parts = _centred(rows(frame, every))
    gram, count = _gram(parts)
    v = _solved(gram, body, frame, 1.0, 0.0)[0]
    return float(v @ gram @ v) / max(count, 1)


def _closer(frame: ImuFrame, parts: Sequence[Array], body: Prior, stated: float | None, memories: float) -> ImuFrame:
    """With all samples; what they leave open by residuals that are not white, as those of `dynamic_stage`."""
    gram, count = _gram(centred := _centred(parts))
    lag = np.inf if stated is None else stated
    v = _solved(gram, body, frame, 1.0, lag)[0]
    weight = 1.0 / max(float(v @ gram @ v) / max(count, 1), 1e-300)
    v, inverse = _solved(gram, body, frame, weight, lag)
    covariance = inverse.copy()
    for each in centred:
        left = each @ v
        scores = np.einsum("tip,ti->tp", each[:, :, :-1], left) @ inverse
        white = np.einsum("tip,tiq->pq", each[:, :, :-1], each[:, :, :-1]) * weight  # as `inverse` has it
        covariance += weight**2 * coloured(scores, left, memories) - inverse @ white @ inverse
    return frame.moved(-v[10:-1], covariance[10:, 10:])


def _centred(parts: Sequence[Array]) -> list[Array]:
    """Each log has its own zero."""
    return [part - part.mean(axis=0) for part in parts]


def _gram(parts: Sequence[Array]) -> tuple[Array, int]:
    flat = [part.reshape(-1, part.shape[2]) for part in parts]
    return np.sum([each.T @ each for each in flat], axis=0), sum(len(each) for each in flat)


def _solved(gram: Array, body: Prior, frame: ImuFrame, weight: float, lag_std: float) -> tuple[Array, Array]:
    """v = [-x, -ψ, 1], and (26, 26) of the inverse of what x, ψ are solved with. gram: of [A, J, b]; lag_std: [s] of
    the lag beside it; 0 holds it, infinity frees it."""
    known = np.zeros((10 + Open.SIZE, 10 + Open.SIZE))
    known[:10, :10] = np.linalg.inv(body.covariance[:10, :10])
    held = np.flatnonzero(np.diag(frame.covariance) > 0.0)
    known[np.ix_(10 + held, 10 + held)] = np.linalg.inv(frame.covariance[np.ix_(held, held)])
    free = [*range(10), *(10 + held)]
    if lag_std > 0.0:
        free.append(10 + Open.LAG)
        known[10 + Open.LAG, 10 + Open.LAG] = lag_std**-2.0
    H = weight * gram[np.ix_(free, free)] + known[np.ix_(free, free)]
    right = weight * gram[free, -1] + known[np.ix_(free, range(10))] @ body.value[:10]
    scale = 1.0 / np.sqrt(np.diag(H))
    inverse = np.linalg.inv(scale[:, None] * H * scale) * np.outer(scale, scale)
    v, whole = np.zeros(len(gram)), np.zeros((10 + Open.SIZE, 10 + Open.SIZE))
    v[free], v[-1] = -(inverse @ right), 1.0
    whole[np.ix_(free, free)] = inverse
    return v, whole
