"""What candidates need of the data: sums of products of their columns with the model's and with the residual.

One pass over each log; afterwards a candidate costs a small solve, however long the logs are.

How surely an error falls, from the sums of what is gained in parts of the data that count as independent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel, Site
from exogauge.identification.preparation import Prepared
from exogauge.robots.rows import RowType

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass
class KindSums:
    """Rows of one kind, k parameters, C candidate columns c (taken off the row, so that the row holds -c).

    cross: (C, k) Σ -c a^T. own: (C, C) Σ c c^T. with_residual: (C,) Σ -c e. rows: how many.
    """

    cross: Array
    own: Array
    with_residual: Array
    rows: int = 0

    @staticmethod
    def empty(columns: int, parameters: int) -> KindSums:
        return KindSums(np.zeros((columns, parameters)), np.zeros((columns, columns)), np.zeros(columns))

    def add(self, A: Array, c: Array, e: Array) -> None:
        """A: (n, k). c: (n, C). e: (n,) y - A x."""
        self.rows += len(e)
        if c.any():  # few rows feel what one joint's encoder reads
            self.cross -= np.dot(c.T, A)
            self.own += np.dot(c.T, c)
            self.with_residual -= np.dot(c.T, e)

    def join(self, other: KindSums) -> None:
        """Take in the rows of another log."""
        self.cross += other.cross
        self.own += other.own
        self.with_residual += other.with_residual
        self.rows += other.rows

    def chosen(self, which: IntArray) -> KindSums:
        """Of the columns `which`, each as often as it is named; one beyond the last is nothing."""
        if np.array_equal(which, np.arange(len(self.own))):
            return self
        cross, own, with_residual = (np.pad(each, (0, 1)) for each in (self.cross, self.own, self.with_residual))
        return KindSums(cross[which, :-1], own[np.ix_(which, which)], with_residual[which], self.rows)

    def at(self, step: Array) -> KindSums:
        """Where the model's parameters have moved by step: (k,)."""
        return replace(self, with_residual=self.with_residual - self.cross @ step)

    def of(self, columns: IntArray) -> tuple[Array, Array, Array]:
        """`cross`, `with_residual` and `own` of some of the columns."""
        return self.cross[columns], self.with_residual[columns], self.own[np.ix_(columns, columns)]


SiteSums = dict[int, KindSums]  # row kind -> sums


@final
@dataclass(frozen=True)
class Columns:
    """Of a site's candidates in one log. Those that differ in nothing but the log that they begin with are the same.

    different: (n_kept, U, kinds of the site). which: (C,) the place of each in it; U: it is nothing in this log.
    """

    different: Array
    which: IntArray

    @property
    def every(self) -> Array:
        """(n_kept, C, kinds)"""
        return np.pad(self.different, ((0, 0), (0, 1), (0, 0)))[:, self.which]


@final
@dataclass
class Sums:
    """by_site: site -> sums of its candidates' columns, by kind of row, over all logs taken in."""

    by_site: dict[Site, SiteSums] = field(default_factory=dict)

    def join(self, other: Sums) -> None:
        """Take in another log, whose sums are from then on part of these."""
        for site, by_kind in other.by_site.items():
            _join(self.by_site.setdefault(site, {}), by_kind)

    def take(self, site: Site, kinds: Sequence[int], own: Columns, rows: Rows) -> None:
        """Add a site's columns in one log. kinds: of the site; rows: of that log, all that it has among them."""
        found = SiteSums()
        for place, kind in enumerate(kinds if len(own.which) else ()):
            for samples, A, e in rows.get(kind, ()):
                c = own.different[samples, :, place]
                found.setdefault(kind, KindSums.empty(c.shape[1], A.shape[1])).add(A, c, e)
        if found:
            _join(self.by_site.setdefault(site, {}), {kind: sums.chosen(own.which) for kind, sums in found.items()})


def _join(mine: SiteSums, more: Mapping[int, KindSums]) -> None:
    for kind, sums in more.items():
        if kind in mine:
            mine[kind].join(sums)
        else:
            mine[kind] = sums


Rows = Mapping[int, Sequence[tuple[IntArray, Array, Array]]]  # kind -> parts: samples (n,), A (n, k), e (n,) y - A x


def rows_of(model: RobotModel, prepared: Prepared, needed: Set[int]) -> tuple[Mapping[int, Array], Rows]:
    """Residuals of one log by kind, (n_kept,), NaN where there is no row; and the rows of the kinds that are needed:
    those whose curvature the model's solution holds."""
    equations, x = model.equations, model.solution.unbounded.x
    at_rest = equations.layout.numbers(RowType.AT_REST)
    residuals: dict[int, Array] = {}
    rows: dict[int, list[tuple[IntArray, Array, Array]]] = {}
    for _, chunks in equations.rows(prepared, model.solution.x_before):
        for chunk in chunks:
            if chunk.kind in at_rest:
                continue
            e = chunk.residual(x)
            residuals.setdefault(chunk.kind, np.full(len(prepared.kept), np.nan))[chunk.samples] = e
            if chunk.kind in needed:
                A = chunk.block[:, :-1].copy(order="F")  # the next chunk overwrites it
                rows.setdefault(chunk.kind, []).append((chunk.samples, A, e))
    return residuals, rows


def sureness(gains: Array) -> float:
    """Standard errors by which parts gain: of their mean, or of their signed ranks where those say more in the same
    direction. A few parts that gain much make the mean's own error large, although nearly all parts gain. NaN: a part
    of which nothing is known."""
    gains = gains[np.isfinite(gains)]
    if len(gains) < 2:
        return 0.0
    error = float(gains.std(ddof=1)) / np.sqrt(len(gains))
    by_mean = float(gains.mean()) / error if error > 0.0 else 0.0
    told = gains[gains != 0.0]
    n = len(told)
    if n < 5:  # from five on ranks tell anything: P = 1/32 that all are positive by chance
        return by_mean
    positive = float(ranks(np.abs(told))[told > 0.0].sum())
    by_rank = (positive - n * (n + 1) / 4.0) / float(np.sqrt(n * (n + 1) * (2 * n + 1) / 24.0))
    return max(by_mean, by_rank) if by_mean > 0.0 else min(by_mean, by_rank)


def ranks(values: Array) -> Array:
    """(N,) 1 for the smallest; equal ones share the mean of theirs. values: (N,) finite."""
    _, which, alike = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(alike) - 0.5 * (alike - 1))[which])


def summed(values: Array, part: NDArray[np.intp]) -> Array:
    """(parts,) sums over those that hold anything. values, part: (N,)."""
    places, number = np.unique(part, return_inverse=True)
    return np.asarray(np.bincount(number, values, minlength=len(places)), dtype=np.float64)
