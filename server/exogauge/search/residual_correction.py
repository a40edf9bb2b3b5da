"""What the formulas of the named effects do not hold: no real curve is a formula, and the rest of it is no effect.

Once nothing more qualifies for a name, each effect of a joint or of a sensor's axis may be bent (`OwnCurve`: terms
over what its formula gives), by as many terms as the fitted logs pay for. A bend must lower the error of the
held-out logs like anything else.

What is left then at a place where something was named may look like another effect, too small beside it for a name.
That is no reason to leave it in the residual: it goes into the model without a name, if held-out logs ask for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape
from exogauge.findings.result import Finding, What
from exogauge.identification.model import AddedEffect, Site
from exogauge.identification.result import Identification
from exogauge.identification.sites import AxisSite, SensorSite
from exogauge.progress import unwatched
from exogauge.search.baseline import lay_ground
from exogauge.search.best_shapes import as_added, judge_best
from exogauge.search.candidates import Candidate
from exogauge.search.doubt import gone, parameters
from exogauge.search.finding import channel_of
from exogauge.search.judge import judge
from exogauge.search.locate import pooled
from exogauge.search.score import Baseline, Score, score
from exogauge.search.site_rows import SiteRows, collect_rows, sums_of
from exogauge.search.state import Search, Step

Array = NDArray[np.float64]

NAMES = ("quadratic", "cubic")


@final
@dataclass(frozen=True)
class OwnCurve:
    """Beside an effect whose columns are u: u |u|/s and u³/s² of each, with s its usual size, or where the effect says
    `departures` itself, those columns instead; and ∂u/∂ of each shape, because one that fits best without them does not
    with them.

    The former are zero where the effect is, and bend it where it is large: no other cause can hide in them. An effect
    of the same site as the one that it is of, with the same shapes.

    of: the effect. sizes: (C,) s of each of its columns. terms: which of all these columns, in order.
    """

    of: Any
    sizes: tuple[float, ...]
    terms: tuple[int, ...]
    coefficients: tuple[Quantity, ...] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        every = possible_terms(self.of)
        object.__setattr__(self, "coefficients", tuple(every[term] for term in self.terms))

    @property
    def name(self) -> str:
        return f"{self.of.name}_curve"

    @property
    def words(self) -> str:
        return str(self.of.words)

    @property
    def place(self) -> str:
        return str(self.of.place)

    @property
    def sentence(self) -> str:
        return str(self.of.sentence)

    @property
    def shapes(self) -> tuple[Shape, ...]:
        return tuple(self.of.shapes)

    @property
    def confounds(self) -> tuple[str, ...]:
        return tuple(self.of.confounds)

    @property
    def needs(self) -> str:
        return str(self.of.needs)

    @property
    def coordinate(self) -> str:
        return str(self.of.coordinate)

    def columns(self, signals: Any, shape: tuple[float, ...]) -> Array:
        """(T, terms) as those of the effect."""
        if hasattr(self.of, "departures"):
            bent = self.of.departures(signals, shape)
        else:
            own = self.of.columns(signals, shape)
            relative = np.abs(own / np.array(self.sizes))
            bent = np.concatenate([own * relative, own * relative**2], axis=1)
        every, width = [bent], len(self.of.coefficients)
        searched = [place for place, one in enumerate(self.of.shapes) if not one.choice]
        for number, place in enumerate(searched):
            first = bent.shape[1] + number * width
            asked = any(first <= term < first + width for term in self.terms)
            every.append(self._along(signals, shape, place) if asked else np.zeros((len(bent), width)))
        return np.asarray(np.concatenate(every, axis=1)[:, list(self.terms)])

    def _along(self, signals: Any, shape: tuple[float, ...], place: int) -> Array:
        """(T, C) by how much the columns change per share of that shape's range."""
        one = self.of.shapes[place]
        shares = [min(max(one.share(shape[place]) + step, 0.0), 1.0) for step in (-0.01, 0.01)]
        before, after = (
            self.of.columns(signals, (*shape[:place], one.at(share), *shape[place + 1 :])) for share in shares
        )
        return np.asarray((after - before) / (shares[1] - shares[0]))

    def applies(self, signals: Any) -> bool:
        return bool(self.of.applies(signals))


def possible_terms(of: Any) -> tuple[Quantity, ...]:
    """What each term's coefficient is called, in the order of `OwnCurve.terms`. of: the effect."""
    bent = tuple(Quantity(f"{each.name}_{name}", each.unit) for name in NAMES for each in of.coefficients)
    along = [
        Quantity(f"{each.name}_along_{one.name}", each.unit)
        for one in of.shapes
        if not one.choice
        for each in of.coefficients
    ]
    return (*(of.departing if hasattr(of, "departures") else bent), *along)


@final
@dataclass(frozen=True)
class Bend:
    """of: the effect's step. finding: that of the effect, with its bend. found: the robot with all effects and bends so
    far. what: its sort, as the chain of gaps has it."""

    of: Step
    added: AddedEffect
    finding: Finding
    found: Identification
    what: What


def own_curves(search: Search) -> list[Bend]:
    """One after the other, in the order in which the effects were added; none where nothing is gained by it."""
    bends: list[Bend] = []
    criteria = search.problem.settings.criteria.search
    effects = search.added
    for step in search.steps:
        before = bends[-1].found if bends else search.current
        scored, rows = _bent(search, step, before)
        if scored is None or (judged := judge(before.model, scored, rows, criteria.bend_sure)).objection:
            continue
        candidate = scored.candidate
        added = AddedEffect(candidate.effect, candidate.site, candidate.shape)
        after = search.problem.identified(search.eyes, [*effects, *(each.added for each in bends), added])
        finding = _told(step.finding, before, after, scored, rows)
        channel = channel_of(before.model.equations, judged.kind)
        sizes = [held_out_rmse(finding, channel, each) for each in (before, after)]
        if gone(*(rmse for rmse, _ in sizes)) > criteria.bend_least * sizes[1][1]:
            bends.append(Bend(step, added, finding, after, "own_curve"))
    return bends


def _bent(search: Search, step: Step, found: Identification) -> tuple[Score | None, Sequence[SiteRows]]:
    """The best bend, the term that explains most first, or None; and the rows of its site."""
    effect, site, shape = step.added.effect, step.added.site, step.added.shape
    if not _has_curves(site) or not search.last:
        return None, ()
    least = search.problem.settings.criteria.judging.worth_judging
    recordings = search.problem.recordings
    rows = collect_rows(found.model, [each for each in recordings if not each.held_out], [site])[site]
    sizes = _sizes(step.added, rows)
    baseline = Baseline(found.model, search.memory)
    best: Score | None = None
    chosen: tuple[int, ...] = ()
    while True:
        tried = [
            each
            for term in range(len(possible_terms(effect)))
            if term not in chosen
            for curve in (OwnCurve(effect, sizes, (*chosen, term)),)
            if (each := score(baseline, Candidate(curve, site, shape), sums_of(rows, curve, shape))) is not None
        ]
        better = max(tried, key=lambda each: each.evidence, default=None)
        if better is None or better.evidence < (best.evidence if best else least):
            return best, collect_rows(found.model, recordings, [site])[site] if best else ()
        best, chosen = better, tuple(better.candidate.effect.terms)  # type: ignore[attr-defined]


def _has_curves(site: Site) -> bool:
    """An axis, or one component of a sensor."""
    return isinstance(site, AxisSite) or (isinstance(site, SensorSite) and site.component is not None)


def _sizes(added: AddedEffect, rows: Sequence[SiteRows]) -> tuple[float, ...]:
    """(C,) rms of each column over logs, where the effect does anything."""
    effect: Any = added.effect  # of a joint or of a sensor's axis
    every = np.concatenate([effect.columns(each.seen.signals, added.shape) for each in rows])
    acts = np.maximum(np.count_nonzero(every, axis=0), 1)
    return tuple(float(size) or 1.0 for size in np.sqrt(np.sum(every**2, axis=0) / acts))


def _told(
    finding: Finding, before: Identification, after: Identification, scored: Score, rows: Sequence[SiteRows]
) -> Finding:
    rmse, _ = held_out_rmse(finding, finding.held_out.channel, after)
    names = [each.name for each in scored.candidate.effect.coefficients]
    every = parameters(before.model, scored, rows)
    numbers = {**finding.parameters, **{name: every[name] for name in names}}
    return replace(finding.refined_by("own_curve", rmse), parameters=numbers)


def held_out_rmse(finding: Finding, channel: str, found: Identification) -> tuple[float, float]:
    """RMSE of a channel in the logs that the finding is told of, and its noise floor."""
    fits = [fit for fit in found.validation if fit.channel == channel]
    logs = finding.held_out.log.split(", ") if finding.held_out.log else [fit.log for fit in fits if fit.held_out]
    return pooled([fit for fit in fits if fit.log in logs])


def remainders(search: Search, bends: Sequence[Bend]) -> list[Bend]:
    """At most one for each place, after the effects' own curves."""
    every = list(bends)
    last: dict[Site, Step] = {each.added.site: each for each in search.steps}
    for site, step in last.items():
        if _has_curves(site):
            every += _remainder(search, step, every)
    return every[len(bends) :]


def _remainder(search: Search, step: Step, bends: Sequence[Bend]) -> list[Bend]:
    before = bends[-1].found if bends else search.current
    finding = next((each.finding for each in reversed(bends) if each.of is step), step.finding)
    problem = search.problem
    criteria = problem.settings.criteria.search
    rmse, floor = held_out_rmse(finding, finding.held_out.channel, before)
    if rmse < criteria.remainder_above * floor:
        return []
    site = step.added.site
    ground = lay_ground(before.model, problem.recordings, problem.effects, unwatched, at=site)
    judged, _ = judge_best(ground, problem.recordings, problem.effects, site)
    best = next((each for each in judged if not each.objection), None)
    if best is None:
        return []
    added = as_added(best.score.candidate)
    there = [*search.added, *(each.added for each in bends)]
    after = search.problem.identified(search.eyes, [*there, added])
    channel = channel_of(before.model.equations, best.kind)
    sizes = [held_out_rmse(finding, channel, each) for each in (before, after)]
    if gone(*(rmse for rmse, _ in sizes)) < criteria.bend_least * sizes[1][1]:
        return []
    rmse, _ = held_out_rmse(finding, finding.held_out.channel, after)
    return [Bend(step, added, finding.refined_by("remainder", rmse, added.effect.name), after, "remainder")]
