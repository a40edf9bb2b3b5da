"""Whether a candidate may be claimed: on logs that were not fitted, block by block, regime by regime.

What every finding has to hold before it is told, whoever made it; what does not is at most also possible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.judging import Judging
from exogauge.criteria.searching import Searching
from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import missing_effects
from exogauge.effects.order import LOG, SINCE, bounded
from exogauge.effects.shaped import AxisSignals
from exogauge.findings.result import Alternative, Finding
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.model import RobotModel
from exogauge.search.score import Score
from exogauge.search.site_rows import SiteRows
from exogauge.search.sums import sureness

Array = NDArray[np.float64]
Blocks = Mapping[tuple[str, int], float]  # (log, block of time) -> sum


@final
@dataclass(frozen=True)
class Judgement:
    """z: standard errors by which the held-out square error falls; z_fitted: the same in the fitted logs.

    kind: of the rows that gain most, which is what is shown. before, after: RMSE of these on held-out logs, low-passed
    [N·m or N]; of_kinds: the same of all that it acts on. blocks: by how much the weighted square error falls in each
    held-out block, for comparing candidates with each other. logs: that all of this is about, the held-out ones.
    objection: why it may not be claimed.
    once: what sits in fitted logs alone cannot be held out: then it is about these, and more is asked.
    """

    score: Score
    kind: int
    z: float
    z_fitted: float
    before: float
    after: float
    of_kinds: Mapping[int, tuple[float, float]]
    blocks: Blocks
    logs: tuple[str, ...]
    once: bool
    objection: Objection | None

    @property
    def explained(self) -> float:
        """Share of the held-out square error that goes."""
        return 1.0 - (self.after / max(self.before, 1e-300)) ** 2

    def shown_by(self, kind: int) -> Judgement:
        before, after = self.of_kinds[kind]
        return replace(self, kind=kind, before=before, after=after)


@final
@dataclass(frozen=True)
class _Change:
    """One kind of row in one log. before, after: (n,) residuals. gain: (n,) by which their squares fall. acts: whether
    the effect does anything in the log."""

    rows: SiteRows
    kind: int
    before: Array
    after: Array
    gain: Array
    acts: bool
    block_s: float

    def blocks(self, weight: float, inside: NDArray[np.bool_] | None = None) -> Iterator[tuple[tuple[str, int], float]]:
        """Sums of the weighted gain over blocks of `block_s` of the log's time."""
        chosen = np.ones(len(self.before), dtype=bool) if inside is None else inside
        block = np.floor(self.rows.time[self.rows.rows[self.kind].samples[chosen]] / self.block_s).astype(np.intp)
        places, number = np.unique(block, return_inverse=True)
        total = np.bincount(number, self.gain[chosen], minlength=len(places))
        for place, value in zip(places, total, strict=True):
            yield (self.rows.log, int(place)), weight * float(value)


def judge(model: RobotModel, score: Score, rows: Sequence[SiteRows], sure: float | None = None) -> Judgement:
    """rows: of the candidate's site, in all logs. sure: standard errors by which held-out error
    must fall, where fewer than usual will do."""
    criteria, judging = model.criteria.search, model.criteria.judging
    sure = judging.sure if sure is None else sure
    candidate, weights = score.candidate, model.solution.weights
    own = model.equations.columns()
    changes = []
    for each in rows:
        columns = each.columns(candidate.effect, candidate.shape)
        left = each.after(columns, score.coefficients, score.step, own)
        without = each.moved(score.without, own)
        acts = any(bool(c.any()) for c in columns.values())
        changes += [
            _Change(each, kind, e, after, np.asarray(e**2 - after**2), acts, judging.block_s)
            for kind, after in left.items()
            for e in (without[kind],)
            if weights[kind] > 0
        ]
    out, fitted = ([each for each in changes if each.rows.held_out is held_out] for held_out in (True, False))
    there, elsewhere = ({each.rows.log for each in changes if each.acts is acts} for acts in (True, False))
    once = bounded(candidate.effect.shapes) and not any(each.acts for each in out) and bool(there and elsewhere - there)
    if once:
        out = [each for each in fitted if each.rows.log in there]
    blocks, blocks_fitted = _summed(out, weights), _summed(fitted, weights)
    z, z_fitted = (sureness(np.array(list(each.values()))) for each in (blocks, blocks_fitted))
    by_kind = {kind: weights[kind] * sum(float(each.gain.sum()) for each in out or fitted if each.kind == kind)
               for kind in {each.kind for each in out or fitted}}  # fmt: skip
    kind = max(by_kind, key=lambda one: by_kind[one])
    of_kinds = {each: _errors([change for change in out if change.kind == each]) for each in by_kind}
    before, after = of_kinds[kind]
    explained = 1.0 - (after / max(before, 1e-300)) ** 2
    asked = min(sure, criteria.sure_if_clear) if score.evidence > criteria.clear else sure
    if once:
        asked = criteria.once_if_clear if explained > criteria.once_nearly_all else judging.once
    objection = _objection(z, z_fitted, explained, len(blocks), out, weights, asked, once, model.criteria)
    if objection is None and any(each.name == SINCE for each in candidate.effect.shapes):
        objection = _not_of_the_log(model, score, rows, there, _explained_below(model, changes, there))
    logs = tuple(dict.fromkeys(each.rows.log for each in out))
    return Judgement(score, kind, z, z_fitted, before, after, of_kinds, blocks, logs, once, objection)


def _explained_below(model: RobotModel, changes: Sequence[_Change], there: set[str]) -> float:
    """Speed below which nearly all of what the effect explains in the logs that have it lies; infinite for none."""
    moving = [each for each in changes if each.rows.log in there and isinstance(each.rows.seen.signals, AxisSignals)]
    if not moving:
        return np.inf
    weights = model.solution.weights
    gain = np.concatenate([float(weights[each.kind]) * each.gain for each in moving])
    speed = np.concatenate([np.abs(_speeds(each)) for each in moving])
    order = np.argsort(speed)
    total = np.cumsum(gain[order])
    share = model.criteria.judging.nearly_all_speeds
    return float(speed[order][np.argmax(total >= share * total[-1])]) if total[-1] > 0.0 else np.inf


def _not_of_the_log(
    model: RobotModel, score: Score, rows: Sequence[SiteRows], there: set[str], explained_below: float
) -> Objection | None:
    """What begins with a log must not be in the others at such speeds: a joint that creeps in later logs shows from
    that log on what its friction does there. there: those that have it."""
    moving = [each for each in rows if isinstance(each.seen.signals, AxisSignals)]
    speeds = {each.log: np.abs(each.seen.signals.velocity) for each in moving}
    later = [speeds[each.log][own.samples] for each in moving if each.log in there for own in each.rows.values()]
    if not later:
        return None
    judging, weights, own = model.criteria.judging, model.solution.weights, model.equations.columns()
    fastest = min(float(np.quantile(np.concatenate(later), judging.nearly_all_speeds)), explained_below)
    effect, shapes = score.candidate.effect, score.candidate.effect.shapes
    always = tuple(0.0 if one.name == SINCE else at for one, at in zip(shapes, score.candidate.shape, strict=True))
    found = dict[tuple[str, int], float]()
    for each in (one for one in moving if one.log not in there):
        left = each.moved(score.step, own)
        for kind, columns in each.columns(effect, always).items():
            after = left[kind] + columns @ score.coefficients
            change = _Change(each, kind, left[kind], after, left[kind] ** 2 - after**2, True, judging.block_s)
            inside = speeds[each.log][each.rows[kind].samples] <= fastest
            for place, value in change.blocks(float(weights[kind]), inside):
                found[place] = found.get(place, 0.0) + value
    z = sureness(np.array(list(found.values()))) if len(found) >= judging.fewest_blocks else 0.0
    return None if z < -judging.worse else Objection(Why.SLOWER_ALONE, z)


def _errors(changes: Sequence[_Change]) -> tuple[float, float]:
    if not changes:
        return float("nan"), float("nan")
    every = ([each.before for each in changes], [each.after for each in changes])
    before, after = (float(np.sqrt(np.mean(np.concatenate(values) ** 2))) for values in every)
    return before, after


def apart(one: Judgement, other: Judgement) -> float:
    """Standard errors by which one candidate explains more than another one, block by block."""
    every = one.blocks.keys() | other.blocks.keys()
    return sureness(np.array([one.blocks.get(each, 0.0) - other.blocks.get(each, 0.0) for each in sorted(every)]))


def _summed(changes: Sequence[_Change], weights: Array) -> dict[tuple[str, int], float]:
    total: dict[tuple[str, int], float] = {}
    for change in changes:
        for place, value in change.blocks(float(weights[change.kind])):
            total[place] = total.get(place, 0.0) + value
    return total


def _objection(
    z: float,
    z_fitted: float,
    explained: float,
    blocks: int,
    out: Sequence[_Change],
    weights: Array,
    sure: float,
    once: bool,
    criteria: Criteria,
) -> Objection | None:
    judging = criteria.judging
    if blocks < judging.fewest_blocks:
        return Objection(Why.TOO_SHORT, blocks * judging.block_s, judging.needed_s)
    if z_fitted < criteria.search.sure_fitted:
        return Objection(Why.FEW_MOMENTS, z_fitted)
    if explained < judging.least:
        return Objection(Why.LITTLE, max(explained, 0.0))
    if z < sure:
        return Objection(Why.NOT_SURE_ONCE if once else Why.NOT_SURE, z, sure)
    for name, chosen in _regimes(criteria.search).items():
        moving = [each for each in out if isinstance(each.rows.seen.signals, AxisSignals)]
        inside = [chosen(each) for each in moving]
        if sum(int(mask.sum()) for mask in inside) < judging.fewest_in_regime:
            continue
        change = dict(
            pair for each, mask in zip(moving, inside, strict=True) for pair in each.blocks(weights[each.kind], mask)
        )
        worse = sureness(np.array(list(change.values())))
        if worse < -judging.worse:
            return Objection(Why.WORSE, -worse, of=(name,))
    return None


def _speeds(each: _Change) -> Array:
    """(n,) [rad/s or m/s] with sign."""
    signals: AxisSignals = each.rows.seen.signals
    return np.asarray(signals.velocity[each.rows.rows[each.kind].samples])


def _velocity(each: _Change) -> Array:
    """(n,) in units of the axis' usual speed."""
    signals: AxisSignals = each.rows.seen.signals
    return np.asarray(_speeds(each) / max(signals.speed_scale, 1e-12))


def _regimes(criteria: Searching) -> dict[str, Callable[[_Change], NDArray[np.bool_]]]:
    return {
        "low_speed": lambda each: np.abs(_velocity(each)) < criteria.slow,
        "high_speed": lambda each: np.abs(_velocity(each)) > criteria.fast,
        "positive_motion": lambda each: _velocity(each) > 0.0,
        "negative_motion": lambda each: _velocity(each) < 0.0,
    }


def refused(finding: Finding, judging: Judging) -> Objection | None:
    """Why it may not be named."""
    held = finding.held_out
    if not held.falls(judging):
        of = (held.channel, *([held.log] if held.log else []))
        return Objection(Why.NOT_FALLING, held.rmse_before, held.rmse_after, held.unit, of)
    sizes = _sizes(finding)
    if sizes and all(abs(each.value) < judging.significant * each.std for each in sizes.values()):
        return Objection(Why.MAY_BE_NONE, sizes=sizes)
    return None


def told(findings: Sequence[Finding], judging: Judging) -> tuple[tuple[Finding, ...], tuple[Alternative, ...]]:
    """Those that may be named, and the others as what was rejected."""
    judged = [(each, refused(each, judging)) for each in findings]
    named = tuple(each for each, objection in judged if objection is None)
    return named, tuple(not_named(each, objection) for each, objection in judged if objection is not None)


def not_named(finding: Finding, objection: Objection) -> Alternative:
    return Alternative(finding.effect, finding.place, finding.score, objection)


def _sizes(finding: Finding) -> dict[str, Estimate]:
    """Name -> how far from none. Of a body its mass, where that is told: its centre may
    well lie at the origin. Of a gain its distance from what is stated. Of what stands askew its angles: no weight pulls
    at a vertical joint whose base does not lean. Else the coefficients, of which one is enough:
    of a wave's two parts one may be zero. Of a curve with free shapes nothing: size and shape may trade against each
    other (`as_drawn`), and that the error falls says that there is something."""
    found = finding.parameters
    if "mass" in found:
        return {"mass": found["mass"]}
    if "ratio" in found and finding.effect != "coupling":  # there it is a shape: of the speeds of two joints
        return {"ratio - 1": replace(found["ratio"], value=found["ratio"].value - 1.0)}
    if turns := {name: each for name, each in found.items() if name.startswith("about_")}:
        return turns
    effects = [each for each in missing_effects() if each.name == finding.effect]
    straight = [each for each in effects if all(one.choice or one.name in (LOG, SINCE) for one in each.shapes)]
    names = {one.name for each in straight for one in each.coefficients}
    return {name: found[name] for name in found if name in names}
