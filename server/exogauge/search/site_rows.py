"""The rows that one site touches, log by log: what refining a shape and judging a candidate need beyond sums."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import Effect, RobotModel, Seen, Site
from exogauge.identification.preparation import Prepared
from exogauge.identification.settings import Recording
from exogauge.identification.sites import seen_by
from exogauge.logs.filtering import LowPass, low_passed_at
from exogauge.logs.model import Log
from exogauge.search.sums import KindSums
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class KindRows:
    """Rows of one kind in one log. samples: (n,) of the log. A: (n, k), e: (n,) y - A x."""

    samples: IntArray
    A: Array
    e: Array


@final
@dataclass(frozen=True)
class SiteRows:
    """One log as a site sees it. kinds: of the site, all of them. rows: by kind, those that the log has.

    position of a kind in `kinds` is its place in `Seen.columns`.
    """

    log: str
    held_out: bool
    time: Array
    seen: Seen
    low_pass: LowPass
    kinds: tuple[int, ...]
    rows: Mapping[int, KindRows]

    def columns(self, effect: Effect, shape: tuple[float, ...]) -> Mapping[int, Array]:
        """Kind -> (n, C) the effect's columns as the rows see them."""
        channels = self.seen.channels(effect, [shape])
        by_kind = channels.reshape(-1, len(self.kinds), channels.shape[1])
        return {
            kind: low_passed_at(self.low_pass, np.ascontiguousarray(by_kind[:, self.kinds.index(kind)]), rows.samples)
            for kind, rows in self.rows.items()
        }

    def moved(self, step: Array, own: Sequence[IntArray]) -> Mapping[int, Array]:
        """Kind -> (n,) what is left where the model's parameters have moved by step: (P,); own: those in the rows of
        each kind."""
        return {kind: rows.e - np.dot(rows.A, step[own[kind]]) for kind, rows in self.rows.items()}

    def after(
        self, columns: Mapping[int, Array], coefficients: Array, step: Array, own: Sequence[IntArray]
    ) -> Mapping[int, Array]:
        """Kind -> (n,) what is left with an effect in the model. columns: its own. step, own: as for `moved`."""
        return {kind: left + columns[kind] @ coefficients for kind, left in self.moved(step, own).items()}


def collect_rows(
    model: RobotModel,
    recordings: Sequence[Recording],
    sites: Sequence[Site],
    eyes: RobotModel | None = None,
    prepared: Callable[[Log], Prepared] | None = None,
) -> Mapping[Site, tuple[SiteRows, ...]]:
    """Site -> its rows in every log that has any. Sites share the rows that they have in common. eyes: the model whose
    loads its effects see, if it is not the same. prepared: other signals of a log than the model's own. Rows are those
    whose curvature the model's solution holds."""
    found: dict[Site, list[SiteRows]] = {site: [] for site in sites}
    if not found:
        return {}
    sites = list(found)  # one that is named twice has its rows once
    equations, x, x_before = model.equations, model.solution.unbounded.x, model.solution.x_before
    ready = prepared or model.prepare
    needed = {kind for site in sites for kind in site.kinds(model.equations)}

    def of_log(recording: Recording) -> list[tuple[Site, SiteRows]]:
        prepared = ready(recording.log)
        parts: dict[int, list[tuple[IntArray, Array, Array]]] = {}
        for _, chunks in equations.rows(prepared, x_before):
            for chunk in chunks:
                if chunk.kind in needed:
                    own = (prepared.kept[chunk.samples], chunk.block[:, :-1].copy(), chunk.residual(x))
                    parts.setdefault(chunk.kind, []).append(own)
        rows = {kind: KindRows(*(np.concatenate(each) for each in zip(*part, strict=True)))
                for kind, part in parts.items()}  # fmt: skip
        mine = {site: {kind: rows[kind] for kind in site.kinds(equations) if kind in rows} for site in sites}
        seen = seen_by(eyes or model, prepared, [site for site in sites if mine[site]])
        time = recording.log.time - recording.log.time[0]
        name, held_out, low_pass = recording.log.name, recording.held_out, prepared.low_pass
        return [(site, SiteRows(name, held_out, time, looks, low_pass, site.kinds(equations), mine[site]))
                for site, looks in seen.items()]  # fmt: skip

    for of_sites in side_by_side(of_log, recordings):
        for site, rows in of_sites:
            found[site].append(rows)
    return {site: tuple(each) for site, each in found.items()}


def sums_of(rows: Sequence[SiteRows], effect: Effect, shape: tuple[float, ...]) -> Mapping[int, KindSums]:
    """Over the fitted logs, by kind."""
    total: dict[int, KindSums] = {}
    for each in rows:
        if each.held_out:
            continue
        columns = each.columns(effect, shape)
        for kind, own in each.rows.items():
            width = columns[kind].shape[1]
            total.setdefault(kind, KindSums.empty(width, own.A.shape[1])).add(own.A, columns[kind], own.e)
    return total
