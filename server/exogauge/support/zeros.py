"""Zeros of the feet's sensors through a session, as the rows of the floating base tell them.

    r = Z(t) (z(t) + m) + e,    z(t) = Σ_r beta_r (w_r(t) - mean of w_r where fitted)

r: (6,) what the model leaves unexplained of the whole robot's forces and moments. No motor, no friction and no band is
in it, only what the feet read; Z: what a zero of each of their components takes off. So every log tells, with the
device too, of the sum of the feet: how a change is shared between them no base row tells. m: what the model misses in
this motion, the same in all its repetitions with the same device or without, as if it were a zero; so that only what
changes between them tells. beta_r ~ N(0, declared² / R) of each component: what is declared is the change over the
session, of either sign. Repetitions that scatter more than they say count less (Birge). A zero that was taken anew
before each log is no course: how the feet share what it makes no row tells, and so all that is declared stays in doubt.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.disturbances import ZERO, zero_columns, zeros_in_doubt
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import of_x
from exogauge.identification.preparation import Prepared
from exogauge.logs.model import Log
from exogauge.side_by_side import each as side_by_side
from exogauge.support.balance import Balance, prepare_worn
from exogauge.support.coloured import of_one_log
from exogauge.support.drift import session_of
from exogauge.support.settings import PlainLog, WornLog

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

WRENCH = 6  # what several feet do to the base is one wrench


@final
@dataclass(frozen=True)
class Zeros:
    """S sensors, R courses, K inputs. logs: name -> its row of course: (L, R). beta: (R, 6 S) [N, N·m], root:
    (R, 6 S, K) of its covariance."""

    logs: Mapping[str, int]
    course: Array
    beta: Array
    root: Array

    def of(self, log: Log) -> Array:
        """(6 S,) zero of each component in a log, beyond that of the fitted ones."""
        return np.asarray(self.course[self.logs[log.name]] @ self.beta)

    def inputs(self, log: Log) -> Array:
        """(6 S, K) the same per standard deviation of each of K inputs that all logs have in common."""
        return np.asarray(np.einsum("r,rck->ck", self.course[self.logs[log.name]], self.root))

    @property
    def sums(self) -> tuple[Array, Array]:
        """(6,) of each component over all feet, to the last log, and its standard deviation: how the feet share it no
        base row tells."""
        moved = (self.course[-1] @ self.beta).reshape(-1, WRENCH).sum(axis=0)
        root = np.einsum("r,rck->ck", self.course[-1], self.root)
        return moved, np.linalg.norm(root.reshape(-1, WRENCH, root.shape[1]).sum(axis=0), axis=1)

    def without(self, model: RobotModel, balance: Balance) -> Balance:
        """Of sensors whose zeros were taken off."""
        prepared, C = balance.prepared, model.robot.axes_from_joints
        equations, log = model.equations, balance.prepared.log
        S = len(model.robot.contacts)
        one = np.broadcast_to(self.of(log).reshape(S, WRENCH), (log.samples, S, WRENCH))
        taken = -equations.acting(prepared, one, np.arange(log.samples))[:, equations.layout.axes]
        return replace(balance, torque=balance.torque - taken @ C[:, balance.joints])

    def doubt(
        self, model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray
    ) -> dict[str, NDArray[np.float32]]:
        """ft_zero -> (n, D, K) [N·m] that each of the common inputs adds to the torque per standard deviation."""
        C = model.robot.axes_from_joints[:, joints]
        zeros = zero_columns(model.equations, prepared, samples)[:, :, model.equations.layout.axes] @ C
        return {ZERO: np.einsum("ncd,ck->ndk", zeros, self.inputs(prepared.log)).astype(np.float32)}


def find_zeros(
    model: RobotModel, plain: Sequence[PlainLog], worn: Sequence[WornLog], started: Mapping[str, float]
) -> Zeros | None:
    """None where no zero is in doubt, no base row sees them, it is not said that they were taken once, or not of every
    log when it began."""
    if model.robot.declared.zeros_taken != "session":
        return None
    size, known = zeros_in_doubt(model.robot), session_of(plain, [each.log for each in worn], started)
    if not model.robot.floating or not size.any() or known is None:
        return None
    told = [(each.log, (each.motion, "")) for each in plain if each.held_out and each.motion is not None]
    told += [(each.log, (each.motion, each.device.name)) for each in worn]
    bare = {id(each.log) for each in plain}

    def of_log(each: tuple[Log, object]) -> _Seen | None:
        log = each[0]
        return _seen(model, model.prepare(log) if id(log) in bare else prepare_worn(model, log), size)

    seen = list(side_by_side(of_log, told))
    use = [k for k, each in enumerate(seen) if each is not None]
    W = np.array([known.course[known.logs[told[k][0].name]] for k in use]).reshape(len(use), known.course.shape[1])
    groups = [told[k][1] for k in use]
    observed = [each for each in seen if each is not None]
    beta, root = _told(W, len(size), observed, groups, model.criteria.support.zero_missed)
    R, C = W.shape[1], len(size)
    return Zeros(known.logs, known.course, beta.reshape(R, C) * size, root.reshape(R, C, -1) * size[:, None])


@final
@dataclass(frozen=True)
class _Seen:
    """What one log says: six combinations `of` (6, 6 S) of zeros in declared sizes, their value (6,) and covariance."""

    of: Array
    value: Array
    covariance: Array


def _told(W: Array, C: int, seen: Sequence[_Seen], groups: Sequence[object], missed: float) -> tuple[Array, Array]:
    """(R C,) beta and (R C, K) the root of its covariance, both in declared sizes. W: (n, R), C: components."""
    R, names = W.shape[1], list(dict.fromkeys(groups))
    prior = np.concatenate([np.full(R * C, 1.0 / R), np.full(len(names) * C, missed**2)])
    A = np.zeros((WRENCH * len(seen), len(prior)))
    noise = np.zeros((len(A), len(A)))
    for k, (each, group) in enumerate(zip(seen, groups, strict=True)):
        own, first = slice(WRENCH * k, WRENCH * k + WRENCH), R * C + C * names.index(group)
        A[own, : R * C] = np.kron(W[k], each.of)
        A[own, first : first + C] = each.of
        noise[own, own] = each.covariance
    y, scale = np.concatenate([each.value for each in seen]) if seen else np.zeros(0), 1.0
    free = WRENCH * (len(seen) - len(names) - 1)
    beta, covariance = np.zeros(R * C), np.diag(prior[: R * C])
    for _ in range(2 if seen else 0):
        gain = np.linalg.solve((A * prior) @ A.T + scale * noise, A * prior).T
        x = gain @ y
        beta, covariance = x[: R * C], (np.diag(prior) - gain @ (A * prior))[: R * C, : R * C]
        if free > 0:
            e = y - A @ x
            scale = max(1.0, float(e @ np.linalg.solve(noise, e)) / free)
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    kept = values > 1e-9 * values.max(initial=0.0)
    return beta, vectors[:, kept] * np.sqrt(values[kept])


def _seen(model: RobotModel, prepared: Prepared, size: Array) -> _Seen | None:
    equations, rows = model.equations, model.equations.layout.base
    kept = prepared.kept[~prepared.left_out[prepared.kept]]
    if len(kept) < model.criteria.support.drift_samples:
        return None
    every = equations.asked(prepared, (), prepared.added, of_x(equations, [model.identified]), rows)[0].T
    r = (every - equations.outside(prepared)[:, rows])[kept]
    Z = (zero_columns(equations, prepared, kept)[:, :, rows] * size[:, None]).transpose(0, 2, 1)  # (n, 6, 6 S)
    w = 1.0 / np.maximum(np.var(r, axis=0), 1e-300)
    H, g = np.einsum("nrc,r,nrd->cd", Z, w, Z), np.einsum("nrc,r,nr->c", Z, w, r)
    values, vectors = np.linalg.eigh(H)
    V, own = vectors[:, -WRENCH:], values[-WRENCH:]
    if own[0] <= 1e-9 * own[-1]:
        return None
    x = V.T @ g / own
    e = r - np.einsum("nrc,c->nr", Z, V @ x)
    S = of_one_log(np.ones(e.shape, dtype=np.bool_), e, Z * w[None, :, None])
    return _Seen(V.T, x, (V.T @ S @ V) / np.outer(own, own))
