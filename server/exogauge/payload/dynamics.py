"""The dynamic stage: ten inertial parameters, and the zero, from motion that excites them, with what is known before.

x = [m, m c, I (6, as `RigidTree.phi`), F_0 (6)]; rows of s A Φ + F_0 = F_raw, divided by the sensor's noise.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.errors import NotIdentifiable
from exogauge.estimation.log_cholesky import nearest_possible, pseudo_inertia
from exogauge.estimation.physical import solve_physical
from exogauge.loops.payload_rows import fill
from exogauge.payload.rounding import Rounding
from exogauge.payload.sensor_motion import SensorMotion
from exogauge.payload.statics import StaticSolution, upright
from exogauge.payload.total_least_squares import Recursion, only_output, solve, triangle
from exogauge.robots.regressor import wrench_columns

Array = NDArray[np.float64]
Method = Literal["ls", "tls", "gtls"]

NAMES = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
ZERO_NAMES = ("fx0", "fy0", "fz0", "mx0", "my0", "mz0")


@final
@dataclass(frozen=True)
class Rows:
    """z: (T, 6, n+1) rows [A b] divided by the noise of b. noise: (T, n+1, n+1) covariance of their errors, summed over
    the six. std: (6,) [N, N·m] that they were divided by. sign: s. tipped: (T, 3, 2) [m/s²] change of a - g in {S} by a
    turn of gravity by 1 rad about two axes across it; None where that is not known. common: as `SensorMotion` has it.
    rounding: of the wrench, where its steps are coarse."""

    z: Array
    noise: Array
    std: Array
    sign: int
    tipped: Array | None = None
    common: Array | None = None
    rounding: Rounding | None = None

    @property
    def size(self) -> int:
        return int(self.z.shape[2]) - 1

    def rows(self, which: NDArray[np.bool_]) -> Rows:
        """The same at the chosen samples."""
        tipped, common = (None if each is None else each[which] for each in (self.tipped, self.common))
        return replace(self, z=self.z[which], noise=self.noise[which], tipped=tipped, common=common)

    def tilting(self, x: Array) -> Array:
        """(T, 6, 2) of a turn of gravity by 1 rad, as `z`, for a payload x (16,)."""
        if self.tipped is None:
            return np.zeros((len(self.z), 6, 2))
        moment = np.cross(x[1:4], self.tipped, axisb=1, axisc=1)
        return np.asarray(self.sign * np.hstack([x[0] * self.tipped, moment]) / self.std[:, None])

    def across_tilting(self) -> Array:
        """(4, 16, 2) Σ Aᵀ `tilting` of payloads of unit m, m c: that of x is linear in these."""
        return np.zeros((4, self.size, 2)) if self.tipped is None else self._across(self.tipped)

    def of_common(self, x: Array) -> Array:
        """(16, 16) spread that errors of a - g which all samples share bring into the equations of x (16,)."""
        if self.common is None:
            return np.zeros((self.size, self.size))
        spread = np.tensordot(x[:4], self._across(self.common), 1)
        return np.asarray(spread @ spread.T)

    def of_rounding(self, x: Array) -> Array:
        """(16, 16) spread that a converter's steps bring into the equations of x (16,)."""
        if self.rounding is None:
            return np.zeros((self.size, self.size))
        A = self.z[:, :, :-1]
        return self.rounding.spread(A / self.std[:, None], A @ x * self.std)

    def _across(self, shift: Array) -> Array:
        """(4, 16, K) Σ Aᵀ of what shifts (T, 3, K) [m/s²] of a - g do to payloads of unit m, m c."""
        T, _, K = shift.shape
        across = np.zeros((T, 6, 4, K))
        across[:, :3, 0] = shift
        for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1)), 1):  # e_k x v
            across[:, 3 + i, k], across[:, 3 + j, k] = -shift[:, j], shift[:, i]
        across *= self.sign / self.std[:, None, None]
        A = self.z[:, :, :-1].reshape(-1, self.size)
        return np.asarray((A.T @ across.reshape(len(A), 4 * K)).reshape(self.size, 4, K).swapaxes(0, 1))


@final
@dataclass(frozen=True)
class Prior:
    """What was known of x: (16,) value and (16, 16) covariance. lean: (18, 2) covariance of [x, turn of gravity] with
    that turn, in which the direction of gravity, which the rows take as given, errs."""

    value: Array
    covariance: Array
    lean: Array = field(default_factory=lambda: np.zeros((18, 2)))

    @property
    def rows(self) -> Array:
        """(16, 17) rows [A b] whose b errs by one standard deviation each."""
        root = np.linalg.inv(np.linalg.cholesky(self.covariance))
        return np.column_stack([root, root @ self.value])


@final
@dataclass(frozen=True)
class DynamicSolution:
    """value, std: (16,) of x; covariance: (16, 16), with residuals that are not white. prior_std: (16,).

    mu, mu_std: residual over what the noise model says, 1 where it holds, and its chance. decided: (16,) whether the
    data made a number at least ten times as sure as it was. physical: (16,) the likeliest whose body can exist; cost:
    what that costs, in squared standard deviations; 0 where x is possible. residual: (T, 6) [N, N·m]. method: of
    `value`. excited: whether the motion would decide an entry of the inertia, were the residual but the stated noise.
    lean: as that of `Prior`, of the estimate.
    """

    value: Array
    covariance: Array
    mu: float
    mu_std: float
    decided: NDArray[np.bool_]
    prior_std: Array
    physical: Array
    cost: float
    residual: Array
    method: Method
    excited: bool
    lean: Array

    @property
    def std(self) -> Array:
        return np.sqrt(np.diag(self.covariance))

    def doubted(self, doubt: Array, criteria: Moving = USUAL) -> DynamicSolution:
        """With (16, 16) more doubt."""
        covariance = self.covariance + doubt
        decided = np.sqrt(np.diag(covariance)) < criteria.decided * self.prior_std
        return replace(self, covariance=covariance, decided=decided)


def dynamic_rows(motion: SensorMotion, wrench: Array, gravity: Array, sign: int, std: Array) -> Rows:
    """wrench: (T, 6) as read. gravity: (3,) [m/s²] in {B}, as the static stage left it. std: (6,) of the wrench.

    Row covariance by first order: A is linear in a - g and α and quadratic in ω.
    """
    z, noise = np.empty((len(wrench), 6, 17)), np.empty((len(wrench), 17, 17))
    fill(*motion.arrays(gravity), np.ascontiguousarray(wrench), std, float(sign), z, noise)
    turned = np.cross(upright(gravity)[:2], gravity).T
    return Rows(z, noise, std, sign, -np.swapaxes(motion.rotation, 1, 2) @ turned, motion.common)


def regressor_slopes(omega: Array) -> Array:
    """(9, T, 6, 10) derivative of A of [Payload] (5) by a - g, α and ω. omega: (T, 3)."""
    T, e, still = len(omega), np.eye(3)[:, None], np.zeros((3, 1, 3))
    linear = np.concatenate([wrench_columns(e, still, still), wrench_columns(still, e, still)])
    none = np.zeros((3, T, 3))
    quadratic = 0.5 * (wrench_columns(none, none, omega + e) - wrench_columns(none, none, omega - e))
    return np.concatenate([np.broadcast_to(linear, (6, T, 6, 10)), quadratic])


def static_prior(static: StaticSolution | None, mass_scale: float = 50.0, criteria: Moving = USUAL) -> Prior:
    """From the static stage, else next to nothing: `mass_scale` [kg] and its moments at 1 m, the zero released."""
    value, covariance = np.zeros(16), np.zeros((16, 16))
    m = mass_scale if static is None else static.mass
    inertia, zero = (m * criteria.gyration_m**2) ** 2, criteria.released**2
    covariance[np.arange(4, 10), np.arange(4, 10)] = inertia
    known = np.array([0, 1, 2, 3, *range(10, 16)])
    if static is None:
        covariance[known, known] = np.array([m**2, *[m**2] * 3, *[zero] * 6])
    else:
        value[known], moments = static.moments
        covariance[np.ix_(known, known)], lean = moments[:10, :10], np.zeros((18, 2))
        lean[known], lean[16:] = moments[:10, 10:], moments[10:, 10:]
        return Prior(value, covariance, lean)
    return Prior(value, covariance)


def dynamic_stage(
    rows: Rows, prior: Prior, method: Method = "gtls", *, correlated: bool = True, criteria: Moving = USUAL
) -> DynamicSolution:
    """Implements [Payload] (29)-(33) with prior rows. Raises NotIdentifiable where nothing was excited.

    correlated: residuals are not white (they are not where positions were smoothed or anything was filtered).
    """
    found = batch(rows, prior, method)
    x = found.value
    left = rows.z @ np.append(-x, 1.0)  # (T, 6)
    H = found.information + prior_information(prior)
    scores = _scores(rows, found, left, method)
    meat = coloured(scores, left, criteria.memories) if correlated else scores.T @ scores
    meat = _no_less(meat, _white(rows, left))
    if rows.rounding is not None:
        meat = _no_less(meat, rows.of_rounding(x))
    meat = meat + rows.of_common(x)
    if method == "ls":  # takes its columns for exact: what their noise would bend it by
        bent = noise_of(rows, "gtls")[:-1, :-1] @ x
        meat = meat + np.outer(bent, bent)
    inverse = np.linalg.inv(H)
    across = rows.across_tilting()
    covariance, lean = inverse @ (meat + of_prior(across, x, prior)) @ inverse, prior.lean.copy()
    turned = np.tensordot(x[:4], across, 1) @ prior.lean[16:]
    lean[:16] = inverse @ (prior_information(prior) @ prior.lean[:16] - turned)
    before = np.sqrt(np.diag(prior.covariance))
    decided = np.sqrt(np.diag(covariance)) < criteria.decided * before
    residual = left * rows.std
    physical, cost = _possible(x, covariance, prior)
    variance = np.diag(inverse)  # negative where the rows hold less than the noise of their columns: nothing is known
    by_noise = (variance > 0.0) & (np.sqrt(np.abs(variance)) < criteria.decided * before)
    excited = bool(by_noise[4:10].any()) if method == "gtls" else bool(decided[4:10].any())
    return DynamicSolution(
        x,
        covariance,
        found.mu,
        _mu_std(left, found.mu),
        decided,
        before,
        physical,
        cost,
        residual,
        method,
        excited,
        lean,
    )


@final
@dataclass(frozen=True)
class Fit:
    """value: (16,). mu_of_fit: μ of all rows under the method's own P. mu: of the motion's rows, under propagated
    noise. information: (16, 16) of the motion's rows."""

    value: Array
    mu_of_fit: float
    mu: float
    information: Array


def batch(rows: Rows, prior: Prior, method: Method) -> Fit:
    """LS, plain TLS of rows divided by the wrench's noise, or GTLS with propagated covariances."""
    R = triangle(rows.z)
    P = noise_of(rows, method)
    with_prior = P.copy()
    with_prior[-1, -1] += len(prior.value)
    found = solve(triangle(np.vstack([R, prior.rows])), with_prior)
    v = np.append(found.value, -1.0)
    mu = float(np.sum((R @ v) ** 2) / (v @ noise_of(rows, "gtls") @ v))
    return Fit(found.value, found.mu, mu, R[:, :-1].T @ R[:, :-1] - found.mu * P[:-1, :-1])


def noise_of(rows: Rows, method: Method) -> Array:
    """(17, 17) summed covariance under which GTLS is the method."""
    T = len(rows.z)
    if method == "ls":
        return only_output(rows.size + 1, 6 * T)
    if method == "tls":
        return 6.0 * T * np.eye(rows.size + 1)
    return np.asarray(rows.noise.sum(axis=0))


def recursive(rows: Rows, prior: Prior, method: Method = "gtls", forget: float = 1.0) -> tuple[Array, float]:
    """(T, 16) the estimate after each sample, and mu at the end: RLS, RTLS, RRTLS.

    Implements [Payload] (34), (35); see `Recursion`.
    """
    noise = rows.noise if method == "gtls" else np.broadcast_to(
        noise_of(rows, method) / len(rows.z), rows.noise.shape
    ).copy()  # fmt: skip
    recursion = Recursion(rows.size, prior.rows, start=prior.value, forget=forget)
    return recursion.run(rows.z, noise), recursion.mu


def prior_information(prior: Prior) -> Array:
    root = prior.rows[:, :-1]
    return np.asarray(root.T @ root)


def of_prior(across: Array, x: Array, prior: Prior) -> Array:
    """(16, 16) spread that errors of what was known bring into the estimate's equations: of x, and of the direction of
    gravity, which the rows take as given and which errs together with x. across: `Rows.across_tilting`."""
    joint = np.block([[prior.covariance, prior.lean[:16]], [prior.lean.T]])
    scale = np.sqrt(np.maximum(np.diag(joint), 1e-300))
    value, vectors = np.linalg.eigh(joint / np.outer(scale, scale))
    root = scale[:, None] * vectors * np.sqrt(np.maximum(value, 0.0))
    AT = np.tensordot(x[:4], across, 1)
    spread = np.hstack([prior_information(prior), -AT]) @ root
    return np.asarray(spread @ spread.T)


def _scores(rows: Rows, found: Fit, left: Array, method: Method) -> Array:
    """(T, 16) half the derivative of the cost by x, sample by sample: Aᵀe, and what the errors of A make of it."""
    scores: Array = np.einsum("tip,ti->tp", rows.z[:, :, :-1], left)
    if method == "ls":
        return scores
    v = np.append(found.value, -1.0)
    toward = rows.noise @ v if method == "gtls" else np.broadcast_to(6.0 * v, (len(left), len(v)))
    return np.asarray(scores + found.mu_of_fit * toward[:, :-1])


def coloured(scores: Array, left: Array, memories: float) -> Array:
    """(n, n) of scores (T, n): Σ over lags of their autocovariance, by Bartlett's weights, and as much more as makes
    1.96 of its roots hold 95 %: such a sum errs by chance, and falls short.

    By Kiefer and Vogelsang, Econometric Theory 21 (2005) 1130, table 1: the quantile by the share of the lags.
    """
    lags = int(min(np.ceil(memories * correlation_time(left)), len(left) // 8))
    out = scores.T @ scores
    for k in range(1, lags + 1):
        cross = scores[k:].T @ scores[:-k]
        out += (1.0 - k / (lags + 1.0)) * (cross + cross.T)
    return np.asarray(out * fell_short((lags + 1.0) / len(left)))


def fell_short(share: float) -> float:
    """By how much such a sum over a share of all lags is more, as 1.96 of its roots are to hold 95 %."""
    return (float(np.polyval([-0.5324, 0.4160, 2.9694, 1.9600], share)) / 1.9600) ** 2


def _white(rows: Rows, left: Array) -> Array:
    """(16, 16) as `coloured`, of the white noise alone that the wrench shows from sample to sample: third differences
    of the residuals, which motion and what is smoothed hardly reach."""
    shown = np.diff(left, 3, axis=0).std(axis=0) / np.sqrt(20.0) if len(left) > 3 else np.zeros(6)
    A = (rows.z[:, :, :-1] * shown[:, None]).reshape(-1, rows.size)
    return np.asarray(A.T @ A)


def _no_less(spread: Array, least: Array) -> Array:
    """What is at least either of two (n, n) covariances in every direction: a sum over lags falls short by chance where
    a log is a few memories long."""
    scale = np.sqrt(np.maximum(np.diag(spread) + np.diag(least), 1e-300))
    whole = (spread + least) / np.outer(scale, scale)
    value, vectors = np.linalg.eigh(whole)
    root = vectors * np.sqrt(np.maximum(value, 1e-12 * value[-1]))
    inner = np.linalg.solve(root, np.linalg.solve(root, (spread / np.outer(scale, scale))).T)
    share, turn = np.linalg.eigh(0.5 * (inner + inner.T))
    larger = scale[:, None] * root @ turn
    return np.asarray(larger * np.maximum(share, 1.0 - share) @ larger.T)


def _mu_std(left: Array, mu: float) -> float:
    """Of μ, from the spread of sums of squares that are a few memories apart."""
    squares = np.sum(left**2, axis=1)
    block = int(min(np.ceil(4 * correlation_time(left)), len(left) // 8))
    sums = squares[: len(squares) // block * block].reshape(-1, block).mean(axis=1)
    return float(mu * sums.std() / (np.sqrt(len(sums)) * squares.mean()))


def correlation_time(left: Array) -> float:
    """Longest correlation time of the six residuals, in samples, up to where the correlation first ends; 1 of so few
    that nothing is told."""
    if len(left) < 4:
        return 1.0
    spectrum = np.abs(np.fft.rfft(left, n=2 * len(left), axis=0)) ** 2
    rho = np.fft.irfft(spectrum, axis=0)[: len(left) // 4]
    rho = rho / np.maximum(rho[0], 1e-300)
    positive = np.cumprod(rho > 0.0, axis=0)
    return float(np.max(1.0 + 2.0 * np.sum(rho[1:] * positive[1:], axis=0)))


def _possible(x: Array, covariance: Array, prior: Prior) -> tuple[Array, float]:
    """The likeliest (16,) whose body can exist, and its squared distance."""
    if np.linalg.eigvalsh(pseudo_inertia(x[:10])).min() > 0:
        return x, 0.0
    scale = np.sqrt(np.diag(covariance))
    value, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    # What is not decided at all is known by rounding alone, 1e-12 of the largest.
    root = (vectors / np.sqrt(np.maximum(value, 1e-12 * value[-1]))).T / scale
    reference = x[:10].copy()
    reference[0] = max(reference[0], 1e-6)
    solution = solve_physical(root, root @ x, nearest_possible(reference)[None])
    return solution.x, solution.cost


UNKNOWN_CAUSE = (
    "the kinematics lag behind the wrench (a causal filter, a delayed channel), an effect is missing, or the noise is "
    "stated too small"
)


def reading_of_mu(mu: float, std: float, cause: str = UNKNOWN_CAUSE, criteria: Moving = USUAL) -> str | None:
    """What a μ beside 1 says, or None where chance explains it. cause: of one above."""
    if abs(mu - 1.0) < max(criteria.mu_stds * std, criteria.mu_floor):
        return None
    said = f"The residual is {mu:.3g} times what the stated noise explains: "
    less = "the noise is stated too large, or the wrench is in another unit than is said (kgf and N differ by 9.81)"
    return f"{said}{cause if mu > 1.0 else less}."


def enough(ls: DynamicSolution, gtls: DynamicSolution, criteria: Moving = USUAL) -> bool:
    """Whether LS would have done: nowhere further from GTLS than twice the standard deviation."""
    return bool(np.all(np.abs(ls.value - gtls.value)[:10] < criteria.agree * gtls.std[:10]))


def require_excitation(solution: DynamicSolution) -> None:
    """Raises NotIdentifiable where no entry of the inertia was excited. Where one was, and is not decided, the residual
    is more than noise: that is another fault."""
    if not solution.excited:
        raise NotIdentifiable(
            "nothing in the excitation decides the inertia: turn the wrist about all three axes, faster; postures "
            "alone tell mass and centre without this log",
            NAMES[4:],
        )
