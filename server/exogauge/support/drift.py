"""What drives gave per ampere and how they rubbed in every log, as logs without the device tell that were recorded
before and after.

    r = Σ_k (m_k + (1 + m_k) delta_k(t)) u_k + o + e,    delta_k(t) = Σ_r beta_kr (w_r(t) - mean of w_r where fitted)

r: torque that the model leaves unexplained without a device; u_k: k_T i, viscous and Coulomb friction of the model;
m_k: what it misses in this motion as a share of u_k, the same in all repetitions, so that only what changes between
them tells. What is there, 1 + m_k of what is modelled, is what a drift changes: a joint that creeps has next to nothing
of Coulomb's friction, and says nothing of its drift. o: a zero of this log. A drive warms and cools in first order,
w_r(t) = (1 - exp(-t/T_r)) / (1 - exp(-t_end/T_r)), by a time constant that nobody knows: beta_kr ~ N(0, s_k² / R) for
each of R that span what motors have, s_k: kt_drift, viscous_drift, coulomb_drift. Nothing is said of the sign. A
robot's motors warm in one session: of that variance c is of what all have in common, in units of s_k each, and 1 - c is
each motor's own, so that those that a motion loads tell something of the others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.criteria.supporting import Supporting
from exogauge.identification.disturbances import DRIFTS, ZERO, drift_columns
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.identification.session import Session, session
from exogauge.logs.model import Log
from exogauge.robots.description import drifts_in_doubt
from exogauge.support.balance import Balance, of_this_log
from exogauge.support.coloured import of_one_log
from exogauge.support.settings import PlainLog

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Drift:
    """A motors, L logs, R courses, K drifts that are declared: `names`.

    logs: name -> its row. course: (L, R) of each. beta: (A, K, R), root: (A, K R, K R) lower triangle of the doubt that
    is each motor's own, common: (A, K R, K R) root of the doubt that all motors share.
    told: (A,) the logs without the device tell of this motor; moved, std: (A, K) share by which it gives more in the
    last log of the session than in the fitted ones, and its doubt.
    """

    names: tuple[str, ...]
    logs: Mapping[str, int]
    course: Array
    beta: Array
    root: Array
    common: Array
    told: BoolArray

    def share(self, log: Log) -> Array:
        """(A, K) by which each motor gave more than the model says, in a log."""
        return np.asarray(self.beta @ self.course[self.logs[log.name]])

    def inputs(self, log: Log) -> tuple[Array, Array]:
        """(A, K, K R) the same per standard deviation of each of A x K R inputs that all logs have in common, and of
        each of K R that all motors have in common, too."""
        return self._inputs(self.logs[log.name])

    def _inputs(self, row: int) -> tuple[Array, Array]:
        A, K, R = self.beta.shape
        own, common = (
            np.asarray(np.einsum("r,akrs->aks", self.course[row], each.reshape(A, K, R, K * R)))
            for each in (self.root, self.common)
        )
        return own, common

    @property
    def moved(self) -> Array:
        return np.asarray(self.beta @ self.course[-1])

    @property
    def std(self) -> Array:
        return np.asarray(np.linalg.norm(np.concatenate(self._inputs(-1), axis=2), axis=2))

    def without(self, model: RobotModel, balance: Balance) -> Balance:
        """Of motors that gave what this says."""
        C, prepared = model.robot.axes_from_joints, balance.prepared
        given = drift_columns(model.equations, model.identified.xi, prepared, np.arange(prepared.log.samples))
        more = sum(given[name] * share for name, share in zip(self.names, self.share(prepared.log).T, strict=True))
        return replace(balance, torque=balance.torque - more @ C[:, balance.joints])

    def doubt(
        self, model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray
    ) -> dict[str, NDArray[np.float32]]:
        """Drift -> (n, D, X) [N·m] that each of the common inputs adds to the torque per standard deviation; X: those
        of the motors that move these joints, then those of all motors. What several drifts have in common counts as the
        first one's."""
        C = model.robot.axes_from_joints[:, joints]
        moving = np.flatnonzero(C.any(axis=1))
        columns = drift_columns(model.equations, model.identified.xi, prepared, samples)
        given = np.stack([columns[name][:, moving] for name in self.names])
        own, common = (each[moving] for each in self.inputs(prepared.log))
        each = np.einsum("kna,ad,aks->ndas", given, C[moving], own, optimize=True)
        every = np.concatenate([each, np.einsum("kna,ad,aks->nds", given, C[moving], common)[:, :, None]], axis=2)
        parts = np.split(every.astype(np.float32), len(self.names), axis=3)
        return {name: part.reshape(len(samples), len(joints), -1) for name, part in zip(self.names, parts, strict=True)}


def find_drift(
    model: RobotModel,
    plain: Sequence[PlainLog],
    worn: Sequence[Log],
    balances: Mapping[str, Balance],
    started: Mapping[str, float],
) -> Drift | None:
    """None where no drift is declared, or where it is not said of every log when it began. started: recording -> [s].
    balances: of logs without the device, by name."""
    sizes, known_session = drifts_in_doubt(model.robot), session_of(plain, worn, started)
    if not sizes or known_session is None:
        return None
    logs, course = known_session.logs, known_session.course
    told = _repeated(plain, balances)
    seen = [_Seen.of(model, balances[each.log.name]) for each in told]
    motions, places = [each.motion for each in told], [logs[each.log.name] for each in told]
    declared = np.stack(list(sizes.values()), axis=1)
    R = course.shape[1]
    asked = [list(DRIFTS).index(name) for name in sizes]
    runs = list[Runs | None]()
    for axis in range(len(declared)):
        use = [k for k, each in enumerate(seen) if np.isfinite(each.share[axis, asked]).any()]
        chosen = [k for k in use if sum(motions[j] == motions[k] for j in use) > 1]
        own = Runs(
            course[[places[k] for k in chosen]],
            [motions[k] for k in chosen],
            np.stack([seen[k].share[axis, asked] for k in chosen]),
            np.stack([seen[k].covariance[axis][np.ix_(asked, asked)] for k in chosen]),
        ) if chosen else None  # fmt: skip
        runs.append(own)
    sizes_of_courses = np.repeat(declared[:, :, None], R, axis=2) / np.sqrt(R)
    beta, root, common = told_by(runs, sizes_of_courses, model.criteria.support)
    return Drift(tuple(sizes), logs, course, beta, root, common, np.array([each is not None for each in runs]))


def session_of(plain: Sequence[PlainLog], worn: Sequence[Log], started: Mapping[str, float]) -> Session | None:
    fitted = [*(not each.held_out for each in plain), *(False for _ in worn)]
    return session([*(each.log for each in plain), *worn], fitted, started)


def _repeated(plain: Sequence[PlainLog], balances: Mapping[str, Balance]) -> list[PlainLog]:
    """Logs that were not fitted, of motions that were recorded more than once without the device."""
    there = [each for each in plain if each.held_out and each.motion is not None and each.log.name in balances]
    return [each for each in there if sum(other.motion == each.motion for other in there) > 1]


@final
@dataclass(frozen=True)
class Runs:
    """What n runs without the device say of one motor. course: (n, R). motions: of each. share: (n, K) by which it
    gave more, NaN where nothing is said of it; covariance: (n, K, K)."""

    course: Array
    motions: Sequence[str | None]
    share: Array
    covariance: Array


def told_by(runs: Sequence[Runs | None], sizes: Array, criteria: Supporting) -> tuple[Array, Array, Array]:
    """(A, K, R) beta, (A, K R, K R) the root of the covariance that is each motor's own, (A, K R, K R) of what they
    have in common. runs: of each motor, None where they say nothing. sizes: (A, K, R) what beta is believed to be."""
    A, K, R = sizes.shape
    flat, alike = sizes.reshape(A, K * R), DECLARED.motors_alike
    own = [None if each is None else _Told.of(each, size, criteria) for each, size in zip(runs, flat, strict=True)]
    known = [each for each in own if each is not None]
    about = np.eye(K * R) + sum((each.of_common.T @ np.linalg.solve(each.S, each.of_common) for each in known), 0.0)
    pulled = sum((each.of_common.T @ np.linalg.solve(each.S, each.z) for each in known), np.zeros(K * R))
    doubt = np.asarray(np.linalg.inv(about), dtype=np.float64)
    u, of_u = doubt @ pulled, _root(doubt)
    beta, root, common = np.zeros((A, K * R)), np.zeros((A, K * R, K * R)), np.zeros((A, K * R, K * R))
    for motor, (size, each) in enumerate(zip(flat, own, strict=True)):
        moved, left = np.diag(np.sqrt(alike) * size), np.diag((1.0 - alike) * size**2)
        if each is not None:  # what its own runs say takes back what is believed of it
            beta[motor] = each.gain @ each.z
            moved, left = moved - each.gain @ each.of_common, left - each.gain @ each.own
        beta[motor] += moved @ u
        root[motor], common[motor] = _root(left), moved @ of_u
    return beta.reshape(sizes.shape), root, common


@final
@dataclass(frozen=True)
class _Told:
    """What runs say of one motor, by n values. z: (n,); S: (n, n) their covariance, given what motors have in common.
    of_common, own: (n, K R) their slope with that, and covariance with what beta has of its own. gain: (K R, n)."""

    z: Array
    S: Array
    of_common: Array
    own: Array
    gain: Array

    @staticmethod
    def of(runs: Runs, size: Array, criteria: Supporting) -> _Told:
        """A drift whose repetitions scatter more than they say counts less (Birge), and so does one that is larger than
        what is declared allows: the model misses something that is another in each repetition. size: (K R,)."""
        K, names, alike = runs.share.shape[1], list(dict.fromkeys(runs.motions)), DECLARED.motors_alike
        M = np.array([[motion == name for name in names] for motion in runs.motions], dtype=np.float64)
        there = _there(runs, M)
        told = np.isfinite(runs.share) & (there > 0.0) & (there - 1.0 < criteria.drift_most * criteria.drift_missed)
        of_beta, of_missed = (
            np.concatenate([np.kron(np.eye(K), each)[None] for each in slopes])[told] * scale
            for slopes, scale in ((runs.course, size), (M, criteria.drift_missed))
        )
        of_beta = of_beta * there[told][:, None]
        which, kind = np.nonzero(told)
        noise = np.where(which[:, None] == which, runs.covariance[which[:, None], kind[:, None], kind], 0.0)
        z, believed = runs.share[told], of_missed @ of_missed.T
        scale = np.ones(K)
        for _ in range(2):
            scaled = noise * np.sqrt(np.outer(scale[kind], scale[kind]))
            e = scaled @ np.linalg.solve(of_beta @ of_beta.T + believed + scaled, z)
            for k in range(K):
                one = kind == k
                free = int(one.sum()) - len({runs.motions[each] for each in which[one]}) - 1
                if free > 0:
                    scale[k] = max(1.0, float(np.sum(e[one] ** 2 / np.diag(noise)[one])) / free)
        every = of_beta @ of_beta.T + believed
        for k in range(K):
            one = kind == k
            free = int(one.sum()) - len({runs.motions[each] for each in which[one]})
            scale[k] *= _widened(
                z[one], every[np.ix_(one, one)], scale[k] * noise[np.ix_(one, one)], free * criteria.drift_most**2
            )
        scaled = noise * np.sqrt(np.outer(scale[kind], scale[kind]))
        S = (1.0 - alike) * of_beta @ of_beta.T + believed + scaled
        own = (1.0 - alike) * of_beta * size
        return _Told(z, S, np.sqrt(alike) * of_beta, own, np.linalg.solve(S, own).T)


def _there(runs: Runs, M: Array) -> Array:
    """(n, K) 1 + m of each run's motion, by its repetitions; 0 where nothing is said. M: (n, motions)."""
    told = np.isfinite(runs.share)
    variance = np.diagonal(runs.covariance, axis1=1, axis2=2)
    weight = np.divide(1.0, variance, out=np.zeros_like(variance), where=told & (variance > 0.0))
    total = M.T @ weight
    sums = M.T @ (weight * np.where(told, 1.0 + runs.share, 0.0))
    return np.asarray(M @ np.divide(sums, total, out=np.zeros_like(sums), where=total > 0.0))


def _widened(z: Array, believed: Array, noise: Array, most: float) -> float:
    """By which the variance of noise has to grow for (n,) values to be no more unlikely than that: zᵀ S⁻¹ z."""
    factor = 1.0
    while most > 0.0 and (unlikely := float(z @ np.linalg.solve(believed + factor * noise, z))) > most:
        factor *= max(unlikely / most, 1.1)
    return factor


def _root(covariance: Array) -> Array:
    """Lower triangle, of a covariance some of whose directions may be known exactly."""
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    square = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    return np.asarray(np.linalg.qr(square)[1].T)


@final
@dataclass(frozen=True)
class _Seen:
    """What one log says of every motor. share: (A, 3) by which it gives more of each of `DRIFTS`, NaN where it says
    nothing; covariance: (A, 3, 3)."""

    share: Array
    covariance: Array

    @staticmethod
    def of(model: RobotModel, own: Balance) -> _Seen:
        prepared, C, kept = own.prepared, model.robot.axes_from_joints[:, own.joints], own.prepared.kept
        used = own.steady[kept] & np.isfinite(own.torque[kept])
        used &= used.sum(axis=0) >= model.criteria.support.drift_samples
        (A, D), K, n = C.shape, len(DRIFTS), len(kept)
        xi, per_unit = _of_effects(model, prepared, kept)
        of_motors = (per_unit[:, None] * C.T[None, :, :, None]).reshape(n, D, A * K)
        columns = np.concatenate([of_motors, np.broadcast_to(np.eye(D), (n, D, D))], axis=2)
        columns = np.where(used[:, :, None], columns, 0.0)
        live = np.flatnonzero(columns.any(axis=(0, 1)))
        zeros = of_this_log(model, prepared, kept, own.joints)[ZERO]
        x, spread = _fitted(columns[:, :, live], np.where(used, own.torque[kept], 0.0), used, zeros)
        size = np.concatenate([xi.ravel(), np.zeros(D)])[live]
        told = np.flatnonzero((size != 0.0) & (np.diag(spread) > 0.0))
        motors, size = live[told], size[told]
        share, covariance = np.full(A * K, np.nan), np.zeros((A * K, A * K))
        share[motors] = x[told] / size
        covariance[np.ix_(motors, motors)] = spread[np.ix_(told, told)] / np.outer(size, size)
        return _Seen(share.reshape(A, K), covariance.reshape(A, K, A, K)[range(A), :, range(A)])


def _fitted(columns: Array, y: Array, used: BoolArray, zeros: Array) -> tuple[Array, Array]:
    """(P,) coefficients of columns (n, D, P) by least squares, and (P, P) their covariance by errors that last and by
    what zeros (n, D, S) in one standard deviation each do."""
    H = np.einsum("ndp,ndq->pq", columns, columns, optimize=True)
    size = 1.0 / np.sqrt(np.diag(H))
    inverse = np.linalg.pinv(H * np.outer(size, size), rcond=1e-9, hermitian=True) * np.outer(size, size)
    x = inverse @ np.einsum("ndp,nd->p", columns, y)
    e = np.where(used, y - columns @ x, 0.0)
    by_zeros = np.einsum("ndp,nds->ps", columns, zeros)
    S = of_one_log(used, e, columns) + by_zeros @ by_zeros.T
    return x, inverse @ S @ inverse


def _of_effects(model: RobotModel, prepared: Prepared, samples: IntArray) -> tuple[Array, Array]:
    """(A, 3) coefficients of the effects that `DRIFTS` names, 0 where the model has none, and (n, A, 3) torque per unit
    of each; none per ampere where torque is logged."""
    own, names = model.identified.xi, [effect.name for effect in model.equations.effects]
    xi = np.stack(
        [own[:, names.index(name)] if name in names else np.zeros(len(own)) for name in DRIFTS.values()], axis=1
    )
    columns = np.stack(list(drift_columns(model.equations, np.ones_like(own), prepared, samples).values()), axis=2)
    driven = np.array([joint.actuation == "current" for joint in model.robot.joints])
    columns[:, ~driven, list(DRIFTS).index("kt_drift")] = 0.0
    return xi, columns
