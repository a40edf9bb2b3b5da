"""What a sensor's own calibration leaves in doubt: gains, their common part, and crosstalk (GUM 4.3, type B).

The sensor reads (1 + E) w + F_0 of a wrench w, E (6, 6). What is declared of E is its standard deviation. Readings tell
how axes differ, and hardly anything of what they have in common: that is a mass, a centre and an inertia to them. What
they leave of E is known by Bayes' rule; through the equations that gave the payload it is a doubt of the payload.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.payload.dynamics import Rows, correlation_time
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.fit import LOOSE, SIZE, TILT, design
from exogauge.payload.missing.stretch import Stretch

Array = NDArray[np.float64]

WIDTH = SIZE + 1  # [m, m c, I, F_0, turn of gravity, reading]


@final
@dataclass(frozen=True)
class Declared:
    """Standard deviations, as shares: gain, of each axis for itself; common, of all alike; crosstalk, of each axis in
    each other one, between forces and moments by length [m]. defaulted: names of those that nobody stated."""

    gain: float
    common: float
    crosstalk: float
    length: float
    defaulted: frozenset[str] = frozenset()

    @property
    def exact(self) -> bool:
        return not (self.gain or self.common or self.crosstalk)

    def root(self, scale: tuple[float, float]) -> Array:
        """(36, 37) root of the covariance of E, row by row; scale: by which gains and crosstalk are worse."""
        unit = np.array([1.0] * 3 + [self.length] * 3)
        across = self.crosstalk * np.outer(unit, 1.0 / unit)
        np.fill_diagonal(across, 0.0)
        gains = np.eye(6).ravel()
        own = scale[1] * across.ravel() + scale[0] * self.gain * gains
        return np.column_stack([scale[0] * self.common * gains, np.diag(own)])


@final
@dataclass(frozen=True)
class Seen:
    """gram: (6, 19, 6, 19) Σ over samples of z zᵀ, z (6, 19) the rows [A, 1, turn, b] of all channels, in N and N·m.
    weight: (6,) of a channel, over its variance."""

    gram: Array
    weight: Array

    @staticmethod
    def of(z: Array, weight: Array) -> Seen:
        """z: (T, 6, 19)."""
        flat = z.reshape(len(z), 6 * WIDTH)
        return Seen((flat.T @ flat).reshape(6, WIDTH, 6, WIDTH), weight)

    def of_zero(self, more: Array) -> Seen:
        """As if the zero had been less by so much, (6,) [N, N·m]."""
        gram = self.gram.copy()
        for i in range(6):
            gram[i, -1] -= more[i] * gram[i, 10 + i]
        for i in range(6):
            gram[:, :, i, -1] -= more[i] * gram[:, :, i, 10 + i]
        return Seen(gram, self.weight)


def live_rows(rows: Rows, x: Array) -> Array:
    """(T, 6, 19) in N and N·m, of a payload x (16,)."""
    z = np.concatenate([rows.z[:, :, :16], rows.tilting(x), rows.z[:, :, 16:]], axis=2)
    return np.asarray(z * rows.std[:, None])


@final
@dataclass(frozen=True)
class Calibration:
    """What is known of E. root: (36, k) of its covariance before. scale: by which gains and crosstalk are worse than
    declared, as axes differ. still, moving: what was read, with `taken` (6, 6) of E taken out of it, about a zero (6,).
    memory: samples in motion that count as one. evidence: log odds of such an E against none, of all that was read.
    body: (10,) with it. likeliest: by which gains and crosstalk are better or worse than declared, as axes differ:
    what is taken out is shrunk so, and what it may be beyond that is doubt."""

    declared: Declared
    root: Array
    scale: tuple[float, float] = (1.0, 1.0)
    still: tuple[Seen, ...] = ()
    moving: tuple[Seen, ...] = ()
    memory: float = 1.0
    inclined: bool = True
    taken: Array = field(default_factory=lambda: np.zeros((6, 6)))
    zero: Array = field(default_factory=lambda: np.zeros(6))
    evidence: float = 0.0
    body: Array = field(default_factory=lambda: np.zeros(10))
    likeliest: tuple[float, float] = (0.0, 0.0)

    @property
    def exact(self) -> bool:
        return self.declared.exact

    def corrected(self, wrench: Array) -> Array:
        """(T, 6) as a sensor without `taken` would read it."""
        if not self.taken.any():
            return wrench
        return np.asarray((wrench - self.zero) @ np.linalg.inv(np.eye(6) + self.taken).T + self.zero)

    def doubt(self, body: Array, of: Sequence[Seen], more: Sequence[Seen] = ()) -> Array:
        """(18, 18) what it adds to the covariance of [body, zero, turn of gravity] that are the least squares of some
        readings, `of`, with an ideal sensor. more: readings beside those that were looked at. body: (10,)."""
        if self.exact:
            return np.zeros((SIZE, SIZE))
        return self.of_lift(self.lift(body, of), body, more)

    def lift(self, body: Array, of: Sequence[Seen]) -> Array:
        """(18, 36) error of those by E, row by row."""
        return _lift(*_equations(of, body, self.inclined)[:2])

    def of_lift(self, lift: Array, body: Array, more: Sequence[Seen] = ()) -> Array:
        """(18, 18) what E makes of what errs by it as `lift` says: of two estimates, the difference of theirs."""
        E, C = self.known(body, more)
        return np.asarray(lift @ (C + np.outer(E, E)) @ lift.T)

    def left(self, body: Array) -> tuple[Array, float]:
        """(6, 6) std of what E still is beside `taken`, of gains against their mean, and that of their mean.
        body: (10,)."""
        E, C = self.known(body)
        of_mean, gains = np.eye(6).ravel() / 6.0, np.arange(0, 36, 7)
        apart = np.eye(36)
        apart[gains] -= of_mean
        about = C + np.outer(E, E)
        each = np.sqrt(np.einsum("ij,jk,ik->i", apart, about, apart))
        return each.reshape(6, 6), float(np.sqrt(of_mean @ about @ of_mean))

    def known(self, body: Array, more: Sequence[Seen] = ()) -> tuple[Array, Array]:
        """(36,) row by row what is left of E, and (36, 36) its covariance, by all that was read."""
        S, r = _of_sensor(*_equations([*self.still, *self.moving, *more], body, self.inclined))
        R, before = self.root, -self.taken.ravel()
        inner = np.linalg.inv(R.T @ S @ R + np.eye(R.shape[1]))
        return before + R @ (inner @ (R.T @ (r - S @ before))), R @ inner @ R.T


def said_of(found: Calibration) -> str:
    """What is taken of the sensor, in a sentence or two; nothing of one that is exact."""
    if found.exact:
        return ""
    shares = (found.declared.gain, found.declared.common, found.declared.crosstalk)
    kinds = ("of each axis", "that all share", "of crosstalk")
    said = ", ".join(f"{100 * share:.3g} % {kind}" for share, kind in zip(shares, kinds, strict=True))
    said += " (not stated; `uncertainty` of payload.yaml)." if found.declared.defaulted else "."
    if max(found.scale) > 1.0:
        more = (
            f"{of} {times:g} times" for of, times in zip(("gains", "crosstalk"), found.scale, strict=True) if times > 1
        )
        said += f" Axes differ by more, so that all is taken to be as large: {', '.join(more)}."
    return said


def uncalibrated(declared: Declared) -> Calibration:
    """Before anything was read."""
    return Calibration(declared, declared.root((1.0, 1.0)))


def calibrate(
    declared: Declared, stretches: Sequence[Stretch], frame: Frame, inclined: bool, *, take: bool,
    scale: tuple[float, float] | None = None,
) -> Calibration:  # fmt: skip
    """stretches: postures and motion that were fitted. take: whether what is likeliest of E is taken out. scale: where
    it is known by now.

    Floors are what is left with E, where that is more than noise; so are the samples that count as one.
    """
    if declared.exact:
        return uncalibrated(declared)
    rows = [np.concatenate([design(frame, each, []), each.wrench[:, :, None]], axis=2)[each.use] for each in stretches]
    floors, memories, body = [each.floor for each in stretches], [1.0 for _ in stretches], frame.body
    grams = [Seen.of(z, np.ones(6)).gram for z in rows]

    def seen() -> list[Seen]:
        return [Seen(*each) for each in zip(grams, (f**-2.0 / m for f, m in zip(floors, memories, strict=True)),
                                            strict=True)]  # fmt: skip

    def found() -> Calibration:
        now = seen()
        S, r = _of_sensor(*_equations(now, body, inclined))
        likeliest, evidence = _scale(declared, S, r)
        least = (1.0, 1.0) if scale is None else scale
        grown = (max(likeliest[0], least[0]), max(likeliest[1], least[1]))
        still, moving = (
            tuple(each for each, of in zip(now, stretches, strict=True) if of.still == wanted)
            for wanted in (True, False)
        )
        return Calibration(
            declared,
            declared.root(grown),
            grown,
            still,
            moving,
            max(memories),
            inclined,
            evidence=evidence,
            body=body,
            likeliest=likeliest,
        )

    here = found()
    for _ in range(3):  # E times the body: one after the other
        E, _ = here.known(body)
        H, X, _, h, _ = _equations([*here.still, *here.moving], body, inclined)
        x = _solved(H, h - X @ E)
        for k, (z, each) in enumerate(zip(rows, stretches, strict=True)):
            left = z[:, :, -1] - z[:, :, :SIZE] @ x - (z[:, :, :10] @ body) @ E.reshape(6, 6).T
            floors[k] = np.maximum(each.floor, np.sqrt(np.mean(left**2, axis=0)))
            memories[k] = 1.0 if each.still else correlation_time(left / floors[k])
        body = x[:10]
        here = found()
    if not take:
        return here
    if here.likeliest == (0.0, 0.0):
        return here
    E, _ = replace(here, root=declared.root(here.likeliest)).known(body)
    H, X, _, h, _ = _equations([*here.still, *here.moving], body, inclined)
    here = replace(here, taken=E.reshape(6, 6), zero=_solved(H, h - X @ E)[10:16])
    for z in rows:
        z[:, :, -1] = here.corrected(z[:, :, -1])
    grams = [Seen.of(z, np.ones(6)).gram for z in rows]
    corrected = found()
    return replace(here, still=corrected.still, moving=corrected.moving)


def _equations(seen: Sequence[Seen], body: Array, inclined: bool) -> tuple[Array, Array, Array, Array, Array]:
    """H (18, 18), X (18, 36), D (36, 36) and right sides (18,), (36,) of the least squares for [x, E]."""
    level = 1e-9  # rad: of what is not sought
    H = np.diag(np.append(LOOSE, [TILT if inclined else level] * 2) ** -2.0)
    X, D = np.zeros((SIZE, 6, 6)), np.zeros((6, 6, 6, 6))
    h, d = np.zeros(SIZE), np.zeros((6, 6))
    for each in seen:
        by = each.gram[:, :, :, :10] @ body  # (6, 19, 6): rows by what a channel should read
        both = np.einsum("jpk,p->jk", by[:, :10], body)
        H += np.einsum("i,ipiq->pq", each.weight, each.gram[:, :SIZE, :, :SIZE])
        X += np.einsum("i,ipj->pij", each.weight, by[:, :SIZE])
        h += np.einsum("i,ipi->p", each.weight, each.gram[:, :SIZE, :, -1])
        d += each.weight[:, None] * by[:, -1]
        for i in range(6):
            D[i, :, i] += each.weight[i] * both
    return H, X.reshape(SIZE, 36), D.reshape(36, 36), h, d.ravel()


def _lift(H: Array, X: Array) -> Array:
    """(18, 36) error of x by E."""
    return -_solved(H, X)


def _solved(H: Array, right: Array) -> Array:
    scale = 1.0 / np.sqrt(np.diag(H))
    scaled = (right.T * scale).T
    return np.asarray((np.linalg.solve(scale[:, None] * H * scale, scaled).T * scale).T)


def _of_sensor(H: Array, X: Array, D: Array, h: Array, d: Array) -> tuple[Array, Array]:
    """(36, 36) and (36,) of the least squares for E, beside whatever x."""
    lift = _lift(H, X)
    return D + X.T @ lift, d + lift.T @ h


def _scale(declared: Declared, S: Array, r: Array) -> tuple[tuple[float, float], float]:
    """By which gains and crosstalk are better or worse than declared, as readings have it likeliest: how axes differ
    says how well the sensor is calibrated, also in what all have in common. And the log odds of that against no E."""
    tried = (0.0, 0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0)

    def odds(scale: tuple[float, float]) -> float:
        R = declared.root(scale)
        K, q = np.eye(R.shape[1]) + R.T @ S @ R, R.T @ r
        return 0.5 * float(q @ np.linalg.solve(K, q) - np.linalg.slogdet(K)[1])

    best = max(product(tried, tried), key=odds)
    return best, odds(best)
