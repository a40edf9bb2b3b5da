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
from exogauge.payload.dynamics import Prior, Rows, fell_short, of_prior, prior_information
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
@dataclass(frozen=True)
class _Anchor:
    """What was known at a time: (16,), (16, 16), and (18, 36) as `Calibration.lift`."""

    value: Array
    covariance: Array
    lift: Array


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
        calibration: Calibration | None = None, memory: float = 1.0, filtered: tuple[float, float] | None = None,
        in_motion: bool = True,
    ) -> None:  # fmt: skip
        """believed: (16,) std of x before anything was measured. named: whether a wrench is known to be late.
        calibration: of the sensor, by what was read before. memory: samples that count as one, by that. filtered: [s²]
        variance of the response of the filter that delays, and its std. in_motion: whether logs in motion were looked
        at for a delay: else a wrench may be late by as much as is not known of it, and x is told beside that."""
        self._unseen_delay = not in_motion
        self.memory, self.filtered = memory, filtered
        self._calibration, self._read = calibration, list[Seen]()
        self.prior, self._believed, self._says = prior, believed, criteria.payload_live
        self.named, self._latest = named, criteria.payload.latest_s
        self._surer, self._memories = criteria.payload_dynamic.decided, criteria.payload_dynamic.memories
        self._released = np.diag(prior.covariance)[10:16] >= criteria.payload_dynamic.released**2
        self._known = prior_information(prior)
        self.recursion = Recursion(16, prior.rows, start=prior.value, criteria=criteria.payload_dynamic)
        self.used = 0
        self._sums = np.zeros((self._says.blocks, 27, 27))  # of [A b Ȧ] of each block
        self._noise = np.zeros((self._says.blocks, 17, 17))
        self._all = np.zeros((27, 27))
        self._meat, self._blocks, self._filled = np.zeros((17, 17)), 0, 0
        self._across = np.zeros((4, 16, 2))
        self._barred, self._barred_samples = np.zeros((27, 27)), 0  # as _all, of what seems to be touched
        self._recent, self._converged = list[Array](), False
        self._beside, self._late_by = prior.value, 0.0  # the estimate beside a delay, and that [s]
        self._lags = 0  # of blocks that share their noise
        lift = np.zeros((18, 36))
        if calibration is not None:
            lift = calibration.lift(prior.value[:10], [*calibration.still, *calibration.moving])
        self._anchors = [_Anchor(prior.value, prior.covariance, lift)]  # what was known before, and at times since
        self._estimates, self._off = 0, 0.0
        self._open = np.zeros(16)  # what the filter that delays leaves open
        self._anchored = 0  # blocks at the last of these
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
            after = np.roll(self._scores(slice(0, self._says.blocks)), -here, axis=0)
            self._meat += _summed(after[: self._lags + 1], self._lags, first=True)
        self._sums[here], self._noise[here] = 0.0, 0.0

    def _scores(self, which: slice) -> Array:
        """(n, 17) of blocks, at the estimate: Aᵀe + μ P v, as in the dynamic stage, and cᵀe, c = -Ȧ x; beside what a
        wrench that is late leaves, which is no noise."""
        x = self._beside
        v = np.append(x, -1.0)
        toward = self._sums[which] @ np.concatenate([-v, self._late_by * x[:10]])  # [A b Ȧ]ᵀ e
        of_x = toward[:, :16] + self.recursion.mu * (self._noise[which] @ v)[:, :16]
        return np.column_stack([of_x, -toward[:, 17:] @ x[:10]])

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
        of, more = self._seen(estimate)
        covariance = estimate.covariance + self._calibration.doubt(estimate.value[:10], of, more)[:16, :16]
        decided = np.sqrt(np.diag(covariance)) < self._surer * self._believed
        return replace(estimate, covariance=covariance, decided=decided)

    def _seen(self, estimate: Estimate) -> tuple[list[Seen], list[Seen]]:
        """What was read, of the logs and of the stream, and the latter alone."""
        assert self._calibration is not None
        share = 1.0 / (max(estimate.mu or 1.0, 1.0) * self._calibration.memory)
        other = np.where(self._released, estimate.value[10:16] - self.prior.value[10:16], 0.0)
        more = [Seen(each.gram, each.weight * share).of_zero(other) for each in self._read]
        return [*self._calibration.still, *self._calibration.moving, *more], more

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
        known = data.copy()
        known[:16, :16] += self._known
        known[16, 16] += self._latest**-2
        inverse = np.linalg.inv(known)
        left = float(x[:10] @ (self._all[17:, :17] @ np.append(x, -1.0)))  # cᵀe
        self._beside, self._late_by = x + inverse[:16, 16] * left, float(inverse[16, 16]) * left
        here = min(self._blocks + (self._filled > 0), self._says.blocks)
        begins = (self._blocks % self._says.blocks) + 1 if self._blocks >= self._says.blocks else 0
        scores = np.roll(self._scores(slice(0, here)), -begins, axis=0)
        count = self._blocks + self._filled / self._says.block
        size = np.sqrt(np.abs(np.diag(data)) + 1e-300)
        value, vectors = np.linalg.eigh(data / np.outer(size, size))
        root = size[:, None] * vectors * np.sqrt(np.maximum(value, 0.0))  # less than 0: less than its columns' noise
        white, seen = root @ root.T, value > 1e-9 * value[-1]
        memory, more = self._remembered(scores @ (vectors[:, seen] / size[:, None] * np.sqrt(count / value[seen])))
        self._lags = int(min(np.ceil(self._memories * more), here // 8))
        meat = self._meat + _summed(scores, self._lags)
        # So few sums leave directions without any: as many blocks as numbers count as if all remembered alike.
        meat = fell_short((self._lags + 1.0) / max(here, 1)) * (count * meat + 16.0 * memory * white) / (count + 16.0)
        meat[:16, :16] += of_prior(self._across, x, self.prior)
        meat[16, 16] += self._latest**-2
        joint = inverse @ meat @ inverse
        late = (self._late_by, float(np.sqrt(max(joint[16, 16], 0.0))))
        filtered = self.filtered
        told = self._blocks >= self._says.steady
        self._unseen_delay &= not (told and late[1] <= self._says.straight_s)
        if self.named or self._unseen_delay:
            x, covariance = self._beside, joint[:16, :16]
            if filtered is None:
                filtered = between_delay_and_pole(abs(late[0]) + late[1])
        else:
            inverse = np.linalg.inv(known[:16, :16])
            covariance = inverse @ meat[:16, :16] @ inverse
        if filtered is not None:
            slope = np.zeros(16)
            slope[:10] = 0.5 * self._all[17:, 17:] @ x[:10]  # -Aᵀ Ä x / 2, by parts
            slope = inverse[:16, :16] @ slope
            x, self._open = x + filtered[0] * slope, filtered[1] * slope
            covariance = covariance + np.outer(self._open, self._open)
        if not np.all(np.diag(covariance) > 0.0):
            return self._value, self.prior.covariance, None
        return x, covariance, late if told else None

    def _remembered(self, white: Array) -> tuple[float, float]:
        """By how much the noise of a sum is more than if it were white, and how many blocks count as one. white: (n, k)
        scores of blocks, oldest first, of unit size if it were. All directions alike, as few blocks tell no more."""
        if len(white) < 4 or not white.size:
            return self.memory, 1.0
        rho = np.array([np.sum(white[k:] * white[: len(white) - k]) for k in range(len(white) // 4 + 1)])
        more = 1.0 + 2.0 * float(np.sum((rho / rho[0])[1:] * np.cumprod(rho > 0.0)[1:]))
        return max(self.memory, more * float(rho[0]) / white.size), more

    def contradiction(self, estimate: Estimate) -> float:
        """Standard deviations of all numbers at once by which what is known now is another thing than what was known at
        the beginning, or some time ago: of that alone, as what disturbs makes later ones larger. Looked at once in
        `steady` estimates."""
        self._estimates += 1
        if self._estimates % self._says.steady or self.used < self._says.steady * self._says.block:
            return self._off
        sensor, now, more = self._calibration, np.zeros((18, 36)), list[Seen]()
        if sensor is not None:
            of, more = self._seen(estimate)
            now = sensor.lift(estimate.value[:10], of)
        self._off = 0.0
        for anchor in self._anchors:
            spread = anchor.covariance + np.outer(self._open, self._open)
            if sensor is not None:
                spread = spread + sensor.of_lift(now - anchor.lift, estimate.value[:10], more)[:16, :16]
            scale = 1.0 / np.sqrt(np.diag(spread))
            root = np.linalg.cholesky(scale[:, None] * spread * scale + 1e-12 * np.eye(16))
            off = np.linalg.solve(root, scale * (estimate.value - anchor.value))
            self._off = max(self._off, float(np.linalg.norm(off)))
        if self._blocks - self._anchored >= self._says.blocks // 2:
            self._anchored = self._blocks
            newest = _Anchor(estimate.value, estimate.covariance, now)
            self._anchors = [*self._anchors[:1], *self._anchors[1:][-7:], newest]
        return self._off

    def of_barred(self, rows: Rows, rates: Array) -> None:
        """Rows of samples that excite, and that something seems to touch: forces alone, which no inertia is in."""
        z = np.concatenate([rows.z, rates], axis=2)[:, :3].reshape(-1, 27)
        self._barred += z.T @ z
        self._barred_samples += len(rows.z)

    def late_of_barred(self) -> tuple[float, float] | None:
        """[s] by which the wrench is late, and its std, where that explains the most of what seems to be touched: none
        of a touch goes with the motion's rate."""
        v = np.append(self._value, -1.0)
        square = float(v[:10] @ self._barred[17:, 17:] @ v[:10])
        left = float(v @ self._barred[:17, :17] @ v)
        if self._barred_samples < max(self.used, self._says.steady * self._says.block) or square <= 0.0:
            return None
        along = float(v[:10] @ self._barred[17:, :17] @ -v)  # of b - A x with Ȧ x
        if along**2 < self._says.late_explains * left * square:
            return None
        self._barred, self._barred_samples = np.zeros((27, 27)), 0
        return -along / square, float(np.sqrt((left - along**2 / square) / self._says.block / square))

    def _mu(self, v: Array) -> tuple[float | None, float | None]:
        full = [k for k in range(min(self._blocks + 1, self._says.blocks)) if k != self._blocks % self._says.blocks]
        if len(full) < self._says.steady:
            return None, None
        R, P, known = self.recursion.R, self.recursion.P, self.prior.rows
        square = float(np.sum((R @ v) ** 2) - np.sum((known @ v) ** 2))
        mu = square / float(v @ P @ v - len(known))
        squares = np.einsum("i,kij,j->k", v, self._sums[full][:, :17, :17], v)
        return mu, mu * float(squares.std() / squares.mean() / np.sqrt(self._blocks))


def between_delay_and_pole(late: float) -> tuple[float, float]:
    """[s²] variance of the response of what delays by so much [s], of which nothing else is known, and its std."""
    return 0.5 * late * abs(late), 0.5 * late**2


def _summed(scores: Array, lags: int, *, first: bool = False) -> Array:
    """(n, n) Σ over lags of the products of scores (T, n), oldest first, by Bartlett's weights; of the first alone
    with what follows it."""
    of = scores[:1] if first else scores
    out = of.T @ of
    for k in range(1, lags + 1):
        cross = scores[k : k + len(of)].T @ of[: max(len(scores) - k, 0)]
        out += (1.0 - k / (lags + 1.0)) * (cross + cross.T)
    return np.asarray(out)


def exciting(rows: Rows, criteria: Streaming = AS_USUAL) -> NDArray[np.bool_]:
    """(T,) samples in which the columns of the inertia are more than noise."""
    signal = np.sum(rows.z[:, :, 4:10] ** 2, axis=(1, 2))
    noise = np.trace(rows.noise[:, 4:10, 4:10], axis1=1, axis2=2)
    return np.asarray(signal > criteria.excited * noise)
