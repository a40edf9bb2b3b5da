"""The ground that candidates are tried on: one pass over all logs, after which none is needed to rank them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import about, begins_among
from exogauge.effects.shaped import AxisSignals, of_logged_torque
from exogauge.identification.model import Effect, RobotModel, Seen, Site
from exogauge.identification.settings import Recording
from exogauge.identification.sites import AxisSite, seen_by
from exogauge.progress import Doing, Progress
from exogauge.search.candidates import Candidate, columns_of, grid, place_kind, sites
from exogauge.search.score import Baseline, Score, residual_memory, score_all
from exogauge.search.sums import Sums, rows_of
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

FEWEST = 20  # samples of steady motion, below which a log says nothing of how its residual is coloured


@final
@dataclass(frozen=True)
class AxisMotion:
    """Of one axis at the n kept samples of a log: position [rad], velocity [rad/s], load [N·m], (n,) each."""

    position: Array
    velocity: Array
    load: Array


@final
@dataclass(frozen=True)
class LogResiduals:
    """What is left of one log at its n kept samples.

    residual: kind of row -> (n,), NaN where there is no row. time: (n,) [s]. axes: actuator axis -> what it did then.
    """

    log: str
    held_out: bool
    time: Array
    residual: Mapping[int, Array]
    axes: Mapping[int, AxisMotion]


@final
@dataclass(frozen=True)
class Ground:
    """candidates: site -> those that any fitted log holds what they need for. scores: of every candidate that the
    baseline does not swallow, best first."""

    baseline: Baseline
    candidates: Mapping[Site, Sequence[Candidate]]
    residuals: tuple[LogResiduals, ...]
    scores: tuple[Score, ...]

    @property
    def model(self) -> RobotModel:
        return self.baseline.model


def lay_ground(
    model: RobotModel,
    recordings: Sequence[Recording],
    effects: Sequence[Effect],
    tick: Progress,
    only: int | None = None,
    at: Site | None = None,
) -> Ground:
    """Pass over the logs, then score every candidate on the fitted ones. only: number of the log that candidates must
    begin with, or sit in. at: the only place that is tried."""
    tried = candidates_at(model, recordings, effects, only, at)
    order = sorted(recordings, key=lambda each: each.held_out)
    shown: dict[Site, set[str]] = {site: set() for site in tried}  # effects that some fitted log can show
    sums, residuals = Sums(), list[LogResiduals]()
    for number, (applying, own, left) in enumerate(side_by_side(lambda each: pass_over(model, each, tried), order)):
        tick(number / len(order), Doing.TRYING_EFFECTS, left.log)
        sums.join(own)
        residuals.append(left)
        for site, names in applying.items():
            shown[site] |= names
    baseline = Baseline(model, {kind: _memory(residuals, kind) for kind in range(len(model.equations.layout))})
    can_be = {site: [each for each in own if each.effect.name in shown[site]] for site, own in tried.items()}
    scores = [
        each for each in ranked(baseline, tried, sums) if each.candidate.effect.name in shown[each.candidate.site]
    ]
    return Ground(baseline, can_be, tuple(residuals), tuple(scores))


def candidates_at(
    model: RobotModel, recordings: Sequence[Recording], effects: Sequence[Effect], only: int | None, at: Site | None
) -> Mapping[Site, Sequence[Candidate]]:
    """Every place that any of these effects may be added at."""
    numbers = [model.order.get(each.log.name, -1) for each in recordings if not each.held_out]
    every = {site: _all_at(model, site, effects, numbers, only) for site in sites(model) if at in (None, site)}
    return {site: candidates for site, candidates in every.items() if candidates}


def pass_over(
    model: RobotModel, recording: Recording, tried: Mapping[Site, Sequence[Candidate]]
) -> tuple[Mapping[Site, set[str]], Sums, LogResiduals]:
    """Of one log: site -> effects that it can show; sums of the candidates' columns, none of them if it is held out;
    and what is left."""
    prepared, sums = model.prepare(recording.log), Sums()
    axes = [site for site in sites(model) if isinstance(site, AxisSite)]
    needed = axes if recording.held_out else [*axes, *(site for site in tried if site not in axes)]
    seen = seen_by(model, prepared, needed)
    sought = () if recording.held_out else tried
    applying = {site: _applying(tried[site], seen[site]) for site in sought}

    moved = {site.axis: _moved(seen[site].signals, prepared.kept) for site in axes}
    kinds = {site: site.kinds(model.equations) for site in sought}
    left, rows = rows_of(model, prepared, {kind for own in kinds.values() for kind in own})
    for site in sought:  # no two sites' columns are held at once, nor what one has computed to see its own
        sums.take(site, kinds[site], columns_of(tried[site], seen.pop(site), prepared, len(kinds[site])), rows)
    time = recording.log.time[prepared.kept] - recording.log.time[0]
    return applying, sums, LogResiduals(recording.log.name, recording.held_out, time, left, moved)


def ranked(baseline: Baseline, tried: Mapping[Site, Sequence[Candidate]], sums: Sums) -> list[Score]:
    """Those that gain anything, best first. sums: of their columns over all fitted logs."""
    every = (each for site, own in sums.by_site.items() for each in score_all(baseline, tried[site], own))
    return sorted((each for each in every if each.gain > 0.0), key=lambda each: -each.evidence)


def _all_at(
    model: RobotModel, site: Site, effects: Sequence[Effect], numbers: Sequence[int], only: int | None
) -> list[Candidate]:
    """An effect sits at a site once, and begins between the first and the last of the fitted logs, if it begins."""
    there = {each.effect.name for each in model.extension.effects if each.site == site} if model.extension else set()
    fitting = [each for each in effects if each.place == place_kind(site) and each.name not in there]
    if isinstance(site, AxisSite) and model.solution.gains.column_of(site.axis) is not None:
        fitting = [each for each in fitting if not of_logged_torque(each)]
    every = [Candidate(effect, site, shape) for effect in fitting for shape in grid(effect)]
    every = [each for each in every if begins_among(each.effect.shapes, each.shape, numbers)]
    return [each for each in every if only is None or about(each.effect.shapes, each.shape, only)]


def _moved(signals: AxisSignals, at: NDArray[np.intp]) -> AxisMotion:
    return AxisMotion(signals.position[at], signals.velocity[at], signals.load[at])


def _applying(candidates: Sequence[Candidate], seen: Seen) -> set[str]:
    """Names of the effects that the log can show. Two effects may share a name."""
    effects = {id(each.effect): each.effect for each in candidates}
    return {effect.name for effect in effects.values() if effect.applies(seen.signals)}


def _without_trend(log: LogResiduals, kind: int) -> Array:
    """What is left once a slow drift, a polynomial of third order, is taken off: that is what is sought, and no memory
    of the noise."""
    e = log.residual[kind].copy()
    used = np.isfinite(e)
    if used.sum() >= FEWEST:
        slow = np.polynomial.legendre.legvander(2.0 * log.time / max(float(log.time[-1]), 1e-12) - 1.0, 3)
        e[used] -= slow[used] @ np.linalg.lstsq(slow[used], e[used], rcond=None)[0]
    return e


def _memory(residuals: Sequence[LogResiduals], kind: int) -> float:
    """Median of the fitted logs in which there are such rows; a log in which an axis rests knows nothing of it."""
    fitted = [_without_trend(each, kind) for each in residuals if not each.held_out and kind in each.residual]
    known = [residual_memory(e) for e in fitted if np.isfinite(e).sum() >= FEWEST]
    return float(np.median(known)) if known else 1.0
