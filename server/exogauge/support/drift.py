"""What drives gave per ampere in every log, as logs without the device tell that were recorded before and after.

    r = (delta(t) + m) u + o + c sgn(qdot) + d qdot + e,    delta(t) = Σ_r beta_r (w_r(t) - mean of w_r where fitted)

r: torque that the model leaves unexplained without a device; u = k_T i; m: what it misses in this motion as a share of
u, the same in all repetitions, so that only what changes between them tells; o, c, d: a zero and a friction of this
log. A drive warms and cools in first order, w_r(t) = (1 - exp(-t/T_r)) / (1 - exp(-t_end/T_r)), by a time constant
that nobody knows: beta_r ~ N(0, kt_drift² / R) for each of R that span what motors have. Nothing is said of the sign.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.disturbances import ZERO, drift_columns
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.logs.model import Log
from exogauge.support.balance import Balance, of_this_log
from exogauge.support.coloured import by_autocovariance
from exogauge.support.session import session
from exogauge.support.settings import PlainLog

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Drift:
    """A motors, L logs, R courses.

    logs: name -> its row. course: (L, R) of each. beta: (A, R), root: (A, R, R) lower triangle of its covariance.
    told: (A,) the logs without the device tell of this motor; moved, std: (A,) share by which it gives more in the last
    log of the session than in the fitted ones, and its doubt.
    """

    logs: Mapping[str, int]
    course: Array
    beta: Array
    root: Array
    told: BoolArray

    def share(self, log: Log) -> Array:
        """(A,) by which each motor gave more than k_T i in a log."""
        return np.asarray(self.beta @ self.course[self.logs[log.name]])

    def inputs(self, log: Log) -> Array:
        """(A, R) the same per standard deviation of each of A x R inputs that all logs have in common."""
        return np.asarray(np.einsum("r,ars->as", self.course[self.logs[log.name]], self.root))

    @property
    def moved(self) -> Array:
        return np.asarray(self.beta @ self.course[-1])

    @property
    def std(self) -> Array:
        return np.asarray(np.linalg.norm(np.einsum("r,ars->as", self.course[-1], self.root), axis=1))

    def without(self, model: RobotModel, balance: Balance) -> Balance:
        """Of motors that gave what this says."""
        C, prepared = model.robot.axes_from_joints, balance.prepared
        given = drift_columns(model.equations, model.k_T, prepared, np.arange(prepared.log.samples))
        return replace(balance, torque=balance.torque - (given * self.share(prepared.log)) @ C[:, balance.joints])

    def doubt(self, model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray) -> NDArray[np.float32]:
        """(n, D, K) [N·m] that each of the common inputs adds to the torque per standard deviation; K: those of the
        motors that move these joints."""
        C = model.robot.axes_from_joints[:, joints]
        moving = np.flatnonzero(C.any(axis=1))
        given = drift_columns(model.equations, model.k_T, prepared, samples)[:, moving]
        found = np.einsum("na,ad,as->ndas", given, C[moving], self.inputs(prepared.log)[moving])
        return np.asarray(found.reshape(len(samples), len(joints), -1), dtype=np.float32)


def find_drift(
    model: RobotModel,
    plain: Sequence[PlainLog],
    worn: Sequence[Log],
    balances: Mapping[str, Balance],
    started: Mapping[str, float],
) -> Drift | None:
    """None where no drift is declared, or where it is not said of every log when it began. started: recording -> [s].
    balances: of logs without the device, by name."""
    size, known_session = model.robot.declared.kt_drift, session(plain, worn, started)
    driven = np.array([joint.actuation == "current" for joint in model.robot.joints])
    if size <= 0.0 or not driven.any() or known_session is None:
        return None
    logs, course = known_session.logs, known_session.course
    told = _repeated(plain, balances)
    seen = [_Seen.of(model, balances[each.log.name]) for each in told]
    A, R = len(driven), course.shape[1]
    beta, root = np.zeros((A, R)), np.tile(np.eye(R) * size / np.sqrt(R), (A, 1, 1))
    known = np.zeros(A, dtype=np.bool_)
    motions = [each.motion for each in told]
    places = [logs[each.log.name] for each in told]
    for axis in np.flatnonzero(driven):
        z, variance = (np.array([getattr(each, name)[axis] for each in seen]) for name in ("share", "variance"))
        use = np.isfinite(z) & np.isfinite(variance)
        chosen = [k for k in np.flatnonzero(use) if sum(motions[j] == motions[k] for j in np.flatnonzero(use)) > 1]
        if chosen:
            own = [motions[k] for k in chosen]
            W, missed = course[[places[k] for k in chosen]], model.criteria.support.drift_missed
            beta[axis], root[axis] = told_by_runs(W, z[chosen], variance[chosen], own, size / np.sqrt(R), missed)
            known[axis] = True
    return Drift(logs, course, beta, root, known)


def _repeated(plain: Sequence[PlainLog], balances: Mapping[str, Balance]) -> list[PlainLog]:
    """Logs that were not fitted, of motions that were recorded more than once without the device."""
    there = [each for each in plain if each.held_out and each.motion is not None and each.log.name in balances]
    return [each for each in there if sum(other.motion == each.motion for other in there) > 1]


def told_by_runs(
    W: Array, z: Array, variance: Array, motions: Sequence[str | None], size: float, missed: float
) -> tuple[Array, Array]:
    """(R,) beta and (R, R) the root of its covariance. W: (n, R) courses; z: (n,) shares; size: what beta is believed
    to be, missed: the same of m. Repetitions that scatter more than they say count less (Birge)."""
    R, names = W.shape[1], list(dict.fromkeys(motions))
    M = np.array([[motion == name for name in names] for motion in motions], dtype=np.float64)
    A = np.hstack([W, M])
    believed = np.concatenate([np.full(R, size**-2.0), np.full(len(names), missed**-2.0)])
    scale = 1.0
    for _ in range(2):
        H = (A.T / (scale * variance)) @ A + np.diag(believed)
        x = np.linalg.solve(H, (A.T / (scale * variance)) @ z)
        free = len(z) - len(names) - 1
        if free > 0:
            scale = max(1.0, scale * float(np.sum((z - A @ x) ** 2 / (scale * variance))) / free)
    covariance = np.linalg.inv(H)[:R, :R]
    return np.asarray(x[:R]), np.asarray(np.linalg.cholesky(0.5 * (covariance + covariance.T)))


@final
@dataclass(frozen=True)
class _Seen:
    """What one log says of every motor: share by which it gives more, and its variance; NaN where it says nothing."""

    share: Array
    variance: Array

    @staticmethod
    def of(model: RobotModel, own: Balance) -> _Seen:
        prepared, C = own.prepared, model.robot.axes_from_joints[:, own.joints]
        kept = prepared.kept
        used = own.steady[kept] & np.isfinite(own.torque[kept])
        used &= used.sum(axis=0) >= model.criteria.support.drift_samples
        axes = np.flatnonzero(C[:, used.any(axis=0)].any(axis=1))
        moved = C[axes]
        given = drift_columns(model.equations, model.k_T, prepared, kept)[:, axes]
        n, D, K = len(kept), len(own.joints), len(axes)
        columns = np.zeros((n, D, 3 * K + D))
        for place, one in enumerate((given, prepared.direction[kept][:, axes], prepared.axis_velocity[kept][:, axes])):
            columns[:, :, place * K : (place + 1) * K] = one[:, None, :] * moved.T
        columns[:, np.arange(D), 3 * K + np.arange(D)] = 1.0
        columns = np.where(used[:, :, None], columns, 0.0)
        flat, y = columns.reshape(n * D, -1), np.where(used, own.torque[kept], 0.0)
        live = np.flatnonzero(flat.any(axis=0))
        H = flat[:, live].T @ flat[:, live]
        size = 1.0 / np.sqrt(np.diag(H))
        inverse = np.linalg.pinv(H * np.outer(size, size), rcond=1e-9, hermitian=True) * np.outer(size, size)
        x = inverse @ (flat[:, live].T @ y.ravel())
        e = np.where(used, y - columns[:, :, live] @ x, 0.0)
        S = by_autocovariance((slice(0, n),), used, e, columns[:, :, live])
        zeros = of_this_log(model, prepared, kept, own.joints)[ZERO]
        S = S + _outer(np.einsum("ndp,nds->ps", columns[:, :, live], zeros))
        variance = np.diag(inverse @ S @ inverse)
        found, spread = np.full(len(C), np.nan), np.full(len(C), np.nan)
        for place, parameter in enumerate(live):
            if parameter < K and variance[place] > 0.0:
                found[axes[parameter]], spread[axes[parameter]] = x[place], variance[place]
        return _Seen(found, spread)


def _outer(g: Array) -> Array:
    return np.asarray(g @ g.T)
