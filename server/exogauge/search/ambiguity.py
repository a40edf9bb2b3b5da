"""A finding and its rivals as planning needs them: what the logs so far say of both, beside the whole baseline."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import LOG, SINCE
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel, Seen, Site
from exogauge.logs.filtering import LowPass
from exogauge.search.baseline import FEWEST
from exogauge.search.candidates import Candidate, grid
from exogauge.search.score import Score, residual_memory
from exogauge.search.site_rows import SiteRows

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Contender:
    """An effect at a site. coefficients: (C,) of its own shape, as fitted. shapes: its own first, then all others that
    it could take instead if it were not what there is."""

    candidate: Candidate
    coefficients: Array
    shapes: tuple[tuple[float, ...], ...]

    @staticmethod
    def of(score: Score) -> Contender:
        candidate = score.candidate
        own = candidate.shape
        begins = [k for k, one in enumerate(candidate.effect.shapes) if one.name in (SINCE, LOG)]
        others = [each for each in grid(candidate.effect) if all(each[k] == own[k] for k in begins) and each != own]
        return Contender(candidate, score.coefficients, (own, *others))

    @property
    def name(self) -> str:
        return self.candidate.effect.name

    def place(self, equations: Equations) -> tuple[str, str, str]:
        """Kind, name and part of it."""
        return self.candidate.site.label(equations)

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        """Of the rows that show it."""
        return self.candidate.site.kinds(equations)

    @property
    def own_width(self) -> int:
        """Number of its columns in one shape."""
        return self.candidate.width

    @property
    def width(self) -> int:
        """Number of its columns, all shapes beside each other."""
        return self.candidate.width * len(self.shapes)

    @property
    def limits(self) -> tuple[float, float] | None:
        """Of what multiplies its one column, where it has one."""
        if self.own_width > 1:
            return None
        (range_,) = self.candidate.effect.coefficients
        return range_.low, range_.high

    def columns(self, seen: Seen, low_pass: LowPass) -> Array:
        """(T, width, kinds of its site), low-passed as the rows are."""
        raw = np.concatenate([seen.columns(self.candidate.effect, shape) for shape in self.shapes], axis=1)
        return low_pass.apply(raw.reshape(len(raw), -1)).reshape(raw.shape)


@final
@dataclass(frozen=True)
class Number:
    """A number of the maker that is off, as a contender. at: kind, name and part of its place. coefficients: (k,) as
    found. moves: (P, k) by what one of each moves the model's parameters; None where the torque of axis `logged` is
    logged, and is more than the logs say by a share: then its rows lack what the model calls for there.
    """

    name: str
    at: tuple[str, str, str]
    coefficients: Array
    moves: Array | None
    logged: int = -1

    def place(self, equations: Equations) -> tuple[str, str, str]:
        return self.at

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        """Of the rows that show it."""
        if self.moves is None:
            return equations.layout.axis(self.logged), equations.layout.resting(self.logged)
        moved = np.abs(self.moves).max(axis=1) > 0.0
        return tuple(kind for kind, columns in enumerate(equations.columns()) if moved[columns].any())

    @property
    def own_width(self) -> int:
        return len(self.coefficients)

    @property
    def width(self) -> int:
        return len(self.coefficients)

    limits = None

    def of_rows(self, columns: IntArray, block: Array, x: Array) -> Array:
        """(n, k) what it does to rows. block: (n, c + 1) their regressor over `columns`, and what they are to be."""
        if self.moves is not None:
            return np.asarray(block[:, :-1] @ self.moves[columns])
        return np.asarray((block[:, -1] - block[:, :-1] @ x[columns])[:, None])


@final
@dataclass(frozen=True)
class Undecided:
    """model: without either effect. contenders: the finding, then its rivals; columns: those of all, in order.

    B: (P, C) Σ w A^T c and S: (C, C) Σ w c c^T over the fitted logs. kind: of the rows that show the finding. noise:
    variance that is left of them once it is in the model, over what the weights state. memory: samples that count as
    one.
    """

    model: RobotModel
    contenders: tuple[Contender | Number, ...]
    B: Array
    S: Array
    kind: int
    noise: float
    memory: float

    @property
    def parts(self) -> list[slice]:
        """Of the columns, by contender."""
        edges = np.cumsum([0, *(each.width for each in self.contenders)])
        return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def undecided(
    model: RobotModel,
    scores: Sequence[Score],
    kind: int,
    left: float,
    rows_of: Mapping[Site, Sequence[SiteRows]],
) -> Undecided:
    """scores: of the finding, then of its rivals. left: RMSE of the rows of `kind` with the finding in the model."""
    contenders = tuple(Contender.of(each) for each in scores)
    sites = list(dict.fromkeys(each.candidate.site for each in contenders))
    weights, own = model.solution.weights, model.equations.columns()
    total = sum(each.width for each in contenders)
    B, S = np.zeros((model.equations.size, total)), np.zeros((total, total))
    for name in dict.fromkeys(each.log for site in sites for each in rows_of[site] if not each.held_out):
        logs = {site: next(each for each in rows_of[site] if each.log == name) for site in sites
                if any(each.log == name for each in rows_of[site])}  # fmt: skip
        columns = {
            number: each.columns(logs[each.candidate.site].seen, logs[each.candidate.site].low_pass)
            for number, each in enumerate(contenders)
            if each.candidate.site in logs
        }
        for row_kind, (samples, A) in _rows(logs.values()).items():
            c = _side_by_side(contenders, columns, logs, row_kind, samples)
            B[own[row_kind]] += weights[row_kind] * (A.T @ c)
            S += weights[row_kind] * (c.T @ c)
    noise = float(np.clip(left**2 * weights[kind], 1e-6, 1.0)) if np.isfinite(left) else 1.0
    memory = _memory(model, scores[0], kind, rows_of[contenders[0].candidate.site])
    return Undecided(model, contenders, B, S, kind, noise, memory)


def _rows(logs: Iterable[SiteRows]) -> dict[int, tuple[IntArray, Array]]:
    """Kind -> samples and regressor of one log, which sites share."""
    found: dict[int, tuple[IntArray, Array]] = {}
    for each in logs:
        found |= {kind: (rows.samples, rows.A) for kind, rows in each.rows.items()}
    return found


def _side_by_side(
    contenders: Sequence[Contender],
    columns: Mapping[int, Array],
    logs: Mapping[Site, SiteRows],
    kind: int,
    samples: IntArray,
) -> Array:
    """(n, C) columns of all contenders in the rows of one kind; zero where a contender does not touch them."""
    parts = []
    for number, each in enumerate(contenders):
        log = logs.get(each.candidate.site)
        if log is not None and kind in log.kinds:
            parts.append(columns[number][samples][:, :, log.kinds.index(kind)])
        else:
            parts.append(np.zeros((len(samples), each.width)))
    return np.concatenate(parts, axis=1)


def _memory(model: RobotModel, score: Score, kind: int, rows: Sequence[SiteRows]) -> float:
    """Of what is left with the finding in the model; median of the fitted logs."""
    own, found = model.equations.columns(), []
    for each in rows:
        if each.held_out or kind not in each.rows or len(each.rows[kind].samples) < FEWEST:
            continue
        left = each.after(
            each.columns(score.candidate.effect, score.candidate.shape), score.coefficients, score.step, own
        )[kind]
        samples = each.rows[kind].samples
        every = max(1, int(np.diff(samples).min()))
        place = (samples - samples[0]) // every
        e = np.full(int(place[-1]) + 1, np.nan)
        e[place] = left
        found.append(residual_memory(e))
    return float(np.median(found)) if found else 1.0
