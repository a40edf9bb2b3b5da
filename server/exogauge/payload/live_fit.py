"""What motion says of the payload as it goes: the recursion, and covariances with residuals that are not white."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.criteria.payload_live import USUAL as AS_USUAL
from exogauge.criteria.payload_live import Streaming
from exogauge.payload.calibration import Calibration, Seen, live_rows
from exogauge.payload.dynamics import Prior, Rows, of_prior, prior_information
from exogauge.payload.total_least_squares import Recursion

Array = NDArray[np.float64]
State = Literal["static", "converging", "converged", "frozen"]


@final
@dataclass(frozen=True)
class Estimate:
    """value, std: (16,) of x as in `dynamics`; covariance: (16, 16). mu, mu_std: None before a second of motion.
    decided: (16,) whether a number is ten times as sure as it is believed to be of a payload of which nothing is known.
    used: samples that counted. late: [s] by which the wrench comes later than it is taken to, and its std; None before
    a second of motion."""

    value: Array
    covariance: Array
    mu: float | None
    mu_std: float | None
    decided: NDArray[np.bool_]
    state: State
    used: int
    late: tuple[float, float] | None = None

    @property
    def std(self) -> Array:
        return np.sqrt(np.diag(self.covariance))


@final
class LiveFit:
    """[Payload] (34), (35) with prior rows and λ = 1, as in `Recursion`.

    Samples that do not excite the inertia are not used: at rest rows say the same again and again, and what is
    systematic in them (gravity's direction, a drift) would be taken for certain.

    A wrench that is late by δ adds -δ Ȧ x to the rows. What that takes is sought beside x in the sums of [A b Ȧ]: one
    step of Newton, exact where δ is small against the motion. It is told of x where δ is `named`.
    """

    def __init__(
        self, prior: Prior, believed: Array, criteria: Criteria = USUAL, *, named: bool = False,
        calibration: Calibration | None = None,
    ) -> None:  # fmt: skip
        """believed: (16,) std of x before anything was measured. named: whether a wrench is known to be late.
        calibration: of the sensor, by what was read before."""
        self._calibration, self._read = calibration, list[Seen]()
        self.prior, self._believed, self._says = prior, believed, criteria.payload_live
        self.named, self._latest = named, criteria.payload.latest_s
        self._surer = criteria.payload_dynamic.decided
        self._released = np.diag(prior.covariance)[10:16] >= criteria.payload_dynamic.released**2
        self._known = prior_information(prior)
        self.recursion = Recursion(16, prior.rows, start=prior.value, criteria=criteria.payload_dynamic)
        self.used = 0
        self._sums = np.zeros((self._says.blocks, 27, 27))  # of [A b Ȧ] of each block
        self._noise = np.zeros((self._says.blocks, 17, 17))
        self._all = np.zeros((27, 27))
        self._meat, self._blocks, self._filled = np.zeros((17, 17)), 0, 0
        self._across = np.zeros((4, 16, 2))
        self._recent, self._converged = list[Array](), False
        before = np.sqrt(np.diag(prior.covariance)) < self._surer * believed
        self._began = bool(before[4:10].all())  # with an inertia, or since something excited

    def take(self, rows: Rows, rates: Array) -> None:
        """Rows of samples that excite, and that nothing touches. rates: (T, 6, 10) [1/s] of change of their columns of
        the body."""
        if not len(rows.z):
            return
        self.recursion.run(rows.z, rows.noise)
        self.used += len(rows.z)
        self._across += rows.across_tilting()
        if self._calibration is not None:
            more = Seen.of(live_rows(rows, self.prior.value), rows.std**-2.0)
            self._read = [Seen(sum((each.gram for each in self._read), more.gram), more.weight)]
        first = 0
        while first < len(rows.z):
            last = min(first + self._says.block - self._filled, len(rows.z))
            here = self._blocks % self._says.blocks
            z = np.concatenate([rows.z[first:last], rates[first:last]], axis=2).reshape(-1, 27)
            square = z.T @ z
            self._sums[here] += square
            self._all += square
            self._noise[here] += rows.noise[first:last].sum(axis=0)
            self._filled += last - first
            first = last
            if self._filled == self._says.block:
                self._next_block()

    def _next_block(self) -> None:
        self._blocks, self._filled = self._blocks + 1, 0
        here = self._blocks % self._says.blocks
        if self._blocks >= self._says.blocks:
            old = self._scores(slice(here, here + 1))
            self._meat += old.T @ old
        self._sums[here], self._noise[here] = 0.0, 0.0

    def _scores(self, which: slice) -> Array:
        """(n, 17) of blocks, at the estimate: Aᵀe + μ P v, as in the dynamic stage, and cᵀe, c = -Ȧ x."""
        v = np.append(self._value, -1.0)
        toward = -self._sums[which][:, :, :17] @ v  # [A b Ȧ]ᵀ e
        of_x = toward[:, :16] + self.recursion.mu * (self._noise[which] @ v)[:, :16]
        return np.column_stack([of_x, -toward[:, 17:] @ v[:10]])

    @property
    def _value(self) -> Array:
        found = self.recursion.value
        return self.prior.value if found is None else found

    def estimate(self, learning: bool) -> Estimate:
        """learning: whether samples were used lately."""
        x, covariance, late = self._joint()
        std = np.sqrt(np.diag(covariance))
        wanted = self._says.steady
        self._recent = [*self._recent[-wanted + 1 :], x]
        moved = np.abs(self._recent[0] - x)[:10]
        stays = self._says.moves_again if self._converged else self._says.stays
        steady = len(self._recent) == wanted and bool(np.all(moved < stays * std[:10]))
        decided = std < self._surer * self._believed
        self._converged = steady and bool(decided[4:10].all())
        state: State = "converging"
        self._began |= learning
        if not self._began:
            state = "static"
        elif not learning:
            state = "frozen"
        elif self._converged:
            state = "converged"
        mu, mu_std = self._mu(np.append(x, -1.0))
        return Estimate(x, covariance, mu, mu_std, decided, state, self.used, late)

    def doubted(self, estimate: Estimate) -> Estimate:
        """With what the sensor's calibration leaves in doubt, which is none in what the sensor reads."""
        if self._calibration is None:
            return estimate
        share = 1.0 / (max(estimate.mu or 1.0, 1.0) * self._calibration.memory)
        other = np.where(self._released, estimate.value[10:16] - self.prior.value[10:16], 0.0)
        more = [Seen(each.gram, each.weight * share).of_zero(other) for each in self._read]
        of = [*self._calibration.still, *self._calibration.moving, *more]
        doubt = self._calibration.doubt(estimate.value[:10], of, more)[:16, :16]
        covariance = estimate.covariance + doubt
        decided = np.sqrt(np.diag(covariance)) < self._surer * self._believed
        return replace(estimate, covariance=covariance, decided=decided)

    def _joint(self) -> tuple[Array, Array, tuple[float, float] | None]:
        """x, its covariance, and by how much the wrench is late; x beside that where it is named."""
        x = self._value
        if self.used == 0:
            return x, self.prior.covariance, None
        R, P = self.recursion.R, self.recursion.P
        data = np.zeros((17, 17))
        data[:16, :16] = R[:, :16].T @ R[:, :16] - self._known - self.recursion.mu * P[:16, :16]
        data[16, :16] = data[:16, 16] = -self._all[:16, 17:] @ x[:10]
        data[16, 16] = x[:10] @ self._all[17:, 17:] @ x[:10]
        here = min(self._blocks + (self._filled > 0), self._says.blocks)
        scores = self._scores(slice(0, here))
        count = self._blocks + self._filled / self._says.block
        meat = self._meat + scores.T @ scores
        # So few sums leave directions without any: as many blocks as numbers count as if residuals were white.
        meat = (count * meat + 16.0 * data) / (count + 16.0)
        meat[:16, :16] += of_prior(self._across, x, self.prior)
        meat[16, 16] += self._latest**-2
        data[:16, :16] += self._known
        data[16, 16] += self._latest**-2
        inverse = np.linalg.inv(data)
        joint = inverse @ meat @ inverse
        left = float(x[:10] @ (self._all[17:, :17] @ np.append(x, -1.0)))  # cᵀe
        late = (float(inverse[16, 16]) * left, float(np.sqrt(max(joint[16, 16], 0.0))))
        if self.named:
            x, covariance = x + inverse[:16, 16] * left, joint[:16, :16]
        else:
            inverse = np.linalg.inv(data[:16, :16])
            covariance = inverse @ meat[:16, :16] @ inverse
        if not np.all(np.diag(covariance) > 0.0):
            return self._value, self.prior.covariance, None
        return x, covariance, late if self._blocks >= self._says.steady else None

    def _mu(self, v: Array) -> tuple[float | None, float | None]:
        full = [k for k in range(min(self._blocks + 1, self._says.blocks)) if k != self._blocks % self._says.blocks]
        if len(full) < self._says.steady:
            return None, None
        R, P, known = self.recursion.R, self.recursion.P, self.prior.rows
        square = float(np.sum((R @ v) ** 2) - np.sum((known @ v) ** 2))
        mu = square / float(v @ P @ v - len(known))
        squares = np.einsum("i,kij,j->k", v, self._sums[full][:, :17, :17], v)
        return mu, mu * float(squares.std() / squares.mean() / np.sqrt(self._blocks))


def exciting(rows: Rows, criteria: Streaming = AS_USUAL) -> NDArray[np.bool_]:
    """(T,) samples in which the columns of the inertia are more than noise."""
    signal = np.sum(rows.z[:, :, 4:10] ** 2, axis=(1, 2))
    noise = np.trace(rows.noise[:, 4:10, 4:10], axis1=1, axis2=2)
    return np.asarray(signal > criteria.excited * noise)
