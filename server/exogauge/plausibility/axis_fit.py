"""How likely an axis' measured torque is, were it this many times what the robot's description expects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Comparing

Array = NDArray[np.float64]

PLAUSIBLE = 2.5  # a description's masses and k_T together: beyond this factor something else is wrong
DECADES = 3.5  # of factors that are tried, up and down: N·mm read as N·m is 3, a gear seldom 300
PER_DECADE = 8
GAINS = 10.0 ** (np.arange(-DECADES * PER_DECADE, DECADES * PER_DECADE + 1) / PER_DECADE)
ALL_GAINS = np.ones(len(GAINS), dtype=bool)
AS_DESCRIBED = (GAINS >= 1.0 / PLAUSIBLE) & (GAINS <= PLAUSIBLE)


@final
@dataclass(frozen=True)
class Likelihood:
    """logs: (GAINS,) log likelihood by factor, counted in moments that are independent of each other.

    misfit: of the best factor near one, rms of what is left by rms of the effort.
    """

    logs: Array
    misfit: float

    @property
    def described(self) -> float:
        """With a factor near one."""
        return float(self.logs[AS_DESCRIBED].max())

    @property
    def any(self) -> float:
        return float(self.logs.max())

    @property
    def gain(self) -> float:
        return float(GAINS[int(np.argmax(self.logs))])


def in_motion(velocity: Array, criteria: Comparing) -> NDArray[np.bool_]:
    """(N, A) -> (N, A)"""
    usual = np.sqrt(np.mean(velocity**2, axis=0))
    return np.asarray(np.abs(velocity) > np.maximum(criteria.moving * usual, criteria.moving_least))


@final
class AxisFit:
    """Of one axis in one log: y = g (L + δ) + k_d dq + τ_c sgn dq + J_r ddq + τ_o + noise, with δ as far as the
    inertial parameters may be off; friction and rotor inertia are never negative, which tells an effort's sign even
    where no gravity does.

    load: (N,) [N·m] that the description expects. spread: (N, P) what each parameter's std moves of it.
    velocity, acceleration: (N,) of the axis. direction: (N,) of Coulomb friction, sgn dq where a joint slides. moving:
    (N,) bool, the moments that count.
    """

    def __init__(
        self,
        load: Array,
        spread: Array,
        velocity: Array,
        direction: Array,
        acceleration: Array,
        moving: NDArray[np.bool_],
        criteria: Comparing,
    ) -> None:
        self.moving, self._criteria = moving, criteria
        m = moving
        self._lambda, U = np.linalg.eigh(spread[m] @ spread[m].T)
        self._lambda = np.maximum(self._lambda, 0.0)
        Z = np.column_stack([velocity, direction, acceleration, np.ones_like(velocity)])[m]
        size = np.sqrt(np.mean(Z**2, axis=0)) if m.any() else np.ones(4)
        self._Z = np.ascontiguousarray(U.T @ (Z / np.where(size > 1e-9, size, np.inf)))
        self._L, self._U = U.T @ load[m], U

    def likelihood(
        self, effort: Array, among: NDArray[np.bool_] = ALL_GAINS, *, other_bodies: bool = False
    ) -> Likelihood:
        """effort: (N,) [N·m]. among: (GAINS,) the factors that are tried; the others have no likelihood.

        other_bodies: not the effort is so many times what is described, but bodies are so many times further off than
        stated: y = L + g δ + … explains a column that has nothing to do with L as well as y = g (L + δ) + … does.
        """
        from exogauge.loops.axis_fit import scan

        gains = GAINS[among]
        y = effort[self.moving]
        rms = float(np.sqrt(np.mean(y**2))) + 1e-9
        y, shares = self._U.T @ y, rms * np.array(self._criteria.unmodelled)
        logs, which, coefficients = (
            np.empty(len(gains)),
            np.zeros(len(gains), dtype=np.int64),
            np.empty((len(gains), 4)),
        )
        offset = 1.0 / (self._criteria.offset * rms) ** 2
        scan(self._Z, self._L, self._lambda, y, gains, other_bodies, shares, offset, logs, which, coefficients)
        described = AS_DESCRIBED[among]
        near = int(np.flatnonzero(described)[np.argmax(logs[described])])
        gain, share = float(gains[near]), float(shares[which[near]])
        left = y - (1.0 if other_bodies else gain) * self._L - self._Z @ coefficients[near]
        left = left * share / np.sqrt(gain**2 * self._lambda + share**2)  # what a change of the load leaves too
        misfit = float(np.sqrt(np.mean(left**2))) / rms
        all_logs = np.full(len(GAINS), -np.inf)
        all_logs[among] = self._criteria.independent * logs
        return Likelihood(all_logs, misfit)

    def slopes(self, effort: Array, columns: Array) -> tuple[Array, Array]:
        """(K,), (K,) first and, negative, second derivative of the log likelihood by how much of each column there is.

        effort: (N,) [N·m]. columns: (N, K). At none of them, with the likeliest factor near one and the likeliest
        coefficients of friction and inertia.
        """
        gain = self.likelihood(effort, AS_DESCRIBED).gain
        y, Z, D = self._U.T @ effort[self.moving], self._Z, self._U.T @ columns[self.moving]
        rms, r = float(np.sqrt(np.mean(y**2))) + 1e-9, y - gain * self._L
        best, slope, curve = -np.inf, np.zeros(D.shape[1]), np.zeros(D.shape[1])
        for share in self._criteria.unmodelled:
            w = 1.0 / (gain**2 * self._lambda + (share * rms) ** 2)
            M = (Z.T * w) @ Z + 1e-12 * np.eye(4)
            M[3, 3] += 1.0 / (self._criteria.offset * rms) ** 2
            most, x = explained(M[None], ((w * r) @ Z)[None])
            found = 0.5 * (float(most[0]) - float(np.sum(w * r**2)) + float(np.sum(np.log(w))))
            if found > best:
                shared = (D.T * w) @ Z
                best, slope = found, (D.T * w) @ (r - Z @ x[0])
                curve = np.sum(D.T * w * D.T, axis=1) - np.sum(shared * np.linalg.solve(M, shared.T).T, axis=1)
        return self._criteria.independent * slope, self._criteria.independent * np.maximum(curve, 0.0)


def explained(M: Array, b: Array) -> tuple[Array, Array]:
    """(G,) the most that columns with coefficients x explain, x_k >= 0 but for the last; and (G, K) these."""
    from exogauge.loops.axis_fit import explain

    most, best = np.empty(len(b)), np.empty(b.shape)
    explain(np.ascontiguousarray(M), np.ascontiguousarray(b), most, best)
    return most, best
