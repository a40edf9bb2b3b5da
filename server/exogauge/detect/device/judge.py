"""Whether an effect of a band may be claimed: on logs or parts of them that were left out of the fit, by blocks.

The shape of the best is searched once more with the bands' springs fitted to it in full: candidates are compared
beside springs that move a little, and a law that was named moves them by more.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from exogauge.criteria.supporting import Wearing
from exogauge.detect.device.baseline import Ground, weighed
from exogauge.detect.device.score import BandScore, evidence
from exogauge.effects.shaped import Shape
from exogauge.findings.basis import LeftOut
from exogauge.findings.verdict import Objection, Why
from exogauge.search.sums import summed, sureness
from exogauge.support.band_model import Added, Begin, Fitted, Setting, fit, lowest, residual, told
from exogauge.support.band_rows import BLOCK_S, WearLogs

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Folds:
    """left_out: (N,) masks, one per fit. what: is left out in turn."""

    left_out: tuple[BoolArray, ...]
    what: LeftOut


@final
@dataclass(frozen=True)
class BandJudgement:
    """One candidate, fitted with everything else. also: the same at further bands. z: standard errors by which the
    square error on what was left out falls; std: of its coefficients, one band's after the other's. before, after: (N,
    D) [N·m] residuals there, NaN where never left out. blocks: (B,) gains by block, of samples that were left out;
    fitted_blocks: of all that are fitted, or of the logs in which an effect of one moment acts. NaN: of none. joint:
    place of the one that shows it most."""

    added: Added
    also: tuple[Added, ...]
    fitted: Fitted
    evidence: float
    left: float
    z: float
    std: Array
    before: Array
    after: Array
    blocks: Array
    fitted_blocks: Array
    joint: int
    objection: Objection | None

    @property
    def once(self) -> bool:
        return self.added.effect.once

    @property
    def members(self) -> tuple[Added, ...]:
        return (self.added, *self.also)

    @property
    def score(self) -> BandScore:
        return BandScore(self.added, 0.0, self.evidence, self.left, tuple(each.wire for each in self.also))

    @property
    def gone(self) -> Array:
        """(D,) [N·m] RMS of what is gone with it, by joint."""
        square = [
            np.nanmean(np.where(np.isfinite(e).any(axis=0), e, 0.0) ** 2, axis=0) for e in (self.before, self.after)
        ]
        return np.asarray(np.sqrt(np.maximum(square[0] - square[1], 0.0)))

    @property
    def explained(self) -> float:
        """Share of the square error of that joint that goes."""
        before, after = rmse(self.before, self.joint), rmse(self.after, self.joint)
        return float(1.0 - (after / max(before, 1e-300)) ** 2)


def folds_of(logs: WearLogs, criteria: Wearing) -> Folds:
    """The k-th log of every motion together; one log each where none is repeated; parts of a single log."""
    motions = [each.motion for each in logs.logs]
    place = np.array([motions[:k].count(motion) for k, motion in enumerate(motions)])
    what: LeftOut
    repeated = np.array([motions.count(motion) > 1 for motion in motions])
    if repeated.any():
        number, what = np.where(repeated, place % criteria.most_folds, -1), "repetitions"
    elif len(motions) > 1:
        number, what = np.arange(len(motions)) % criteria.most_folds, "motions"
    else:
        parts = int(min(criteria.parts, logs.time[-1] // criteria.shortest_part_s))
        if parts < 2:
            return Folds((), "nothing")
        part = np.minimum((logs.time / (logs.time[-1] / parts)).astype(np.intp), parts - 1)
        return Folds(tuple(part == k for k in range(parts)), "parts")
    return Folds(tuple(number[logs.log] == k for k in range(number.max() + 1)), what)


def left_out_residual(setting: Setting, begin: Begin, folds: Folds, held: Mapping[int, float] | None = None) -> Array:
    """(N, D) [N·m] each sample by a fit that did not see it, less its log's offset; NaN where it does not count or is
    never left out."""
    e, begin = np.full(setting.weight.shape, np.nan), told(setting, begin)
    for left_out in folds.left_out:
        weight = setting.weight * ~left_out[:, None]
        own = lowest(replace(setting, weight=weight), begin, held).wear
        left = setting.nuisances.without(residual(setting.logs, setting.wires, own))
        e[left_out] = left[left_out]
    return np.where(setting.weight > 0.0, e, np.nan)


def judge(ground: Ground, scored: BandScore, folds: Folds) -> BandJudgement:
    """Errors count as large, and as lasting, as they are once the effect is there: for the model without it, too."""
    without, members = ground.fitted.wear, scored.members
    after_all = weighed(ground, fit(ground.setting, without.with_added(*members)))
    setting, fitted = after_all.setting, after_all.fitted
    base = fit(setting, ground.fitted)
    gain = base.cost - fitted.cost
    effect, width = scored.added.effect, len(members) * len(scored.added.coefficients)
    left_out = [left_out_residual(setting, each, folds) for each in (base, fitted)]
    used = setting.weight > 0.0
    seen = [np.where(used, each.e, np.nan) for each in (base, fitted)]
    acts = ground.model.criteria.device.acts
    gains, fitted_gains = ((was**2 - now**2) / after_all.sigma**2 for was, now in (left_out, seen))
    by_joint = np.nansum(fitted_gains if effect.once else gains, axis=0)
    by_joint = np.where(_acted_on(setting, fitted, width, acts), by_joint, -np.inf)
    if effect.once:  # logs before it can only dilute what those say in which it happens or lasts
        acting = np.abs(fitted.A[:, :, -1]).sum(axis=1) > 0.0
        own = np.isin(setting.logs.log, setting.logs.log[acting])
        fitted_gains = np.where(own[:, None], fitted_gains, np.nan)
    blocks, fitted_blocks = by_block(setting.logs, gains), by_block(setting.logs, fitted_gains)
    before, after = seen if effect.once else left_out
    judged = BandJudgement(
        added=fitted.wear.added[-len(members)],
        also=fitted.wear.added[len(fitted.wear.added) - len(members) + 1 :],
        fitted=fitted,
        evidence=evidence(setting, gain, base.cost, width + len(scored.added.shape)),
        left=scored.left,
        z=sureness(fitted_blocks if effect.once else blocks),
        std=after_all.deviations(fitted)[-width:],
        before=before,
        after=after,
        blocks=blocks,
        fitted_blocks=fitted_blocks,
        joint=int(np.argmax(by_joint)),
        objection=None,
    )
    return replace(judged, objection=_objection(judged, after_all))


def _acted_on(setting: Setting, fitted: Fitted, width: int, acts: float) -> BoolArray:
    """(D,) joints on which the last effect acts more than by the way. width: of its coefficients."""
    coefficients = fitted.wear.theta[-width:]
    size = np.sqrt(np.sum(setting.weight * (fitted.A[:, :, -width:] @ coefficients) ** 2, axis=0))
    return np.asarray(size >= acts * max(float(size.max()), 1e-300))


def by_block(logs: WearLogs, gains: Array) -> Array:
    """(B,) sums over joints, by block of all logs. gains: (N, D). NaN: where nothing counts."""
    counts, total = np.isfinite(gains).any(axis=1), np.full(int(logs.block.max()) + 1, np.nan)
    total[np.unique(logs.block[counts])] = summed(np.nansum(gains[counts], axis=1), logs.block[counts])
    return total


def apart(one: BandJudgement, other: BandJudgement) -> float:
    """Standard errors by which one explains more than another, on the blocks that both are known of."""
    if one.once or other.once:
        return sureness(one.fitted_blocks - other.fitted_blocks)
    return sureness(one.blocks - other.blocks)


def rmse(e: Array, joint: int) -> float:
    """[N·m] of one joint, (N, D) with NaN where it does not count."""
    own = e[:, joint]
    return float(np.sqrt(np.nanmean(own**2))) if np.isfinite(own).any() else float("nan")


def _objection(judged: BandJudgement, ground: Ground) -> Objection | None:
    criteria, judging = ground.model.criteria.device, ground.model.criteria.judging
    with np.errstate(over="ignore"):  # without any doubt it is as sure as can be
        sizes = np.abs([each.coefficients for each in judged.members])
        size = float(np.min(np.max(sizes / np.maximum(judged.std.reshape(sizes.shape), 1e-300), axis=1)))
    sure = judging.once if judged.once else judging.sure
    if size < sure:
        return Objection(Why.SIZE_NOT_SURE, size, sure)
    if judged.once:
        if judged.evidence < criteria.evidence_once:
            return Objection(Why.ONCE)
    elif (blocks := int(np.isfinite(judged.blocks).sum())) < judging.fewest_blocks:
        return Objection(Why.TOO_SHORT, blocks * BLOCK_S, judging.fewest_blocks * BLOCK_S)
    needed = criteria.spread_once if judged.once else judging.sure
    if judged.z < needed:
        return Objection(Why.NOT_SURE_ONCE if judged.once else Why.NOT_SURE, judged.z, needed)
    if rmse(judged.before, judged.joint) <= ground.floor[judged.joint]:
        return Objection(Why.AT_FLOOR)
    if _size(judged, ground) < 1.0:
        return Objection(Why.UNDER_SUPPORT, criteria.of_support)
    if judged.explained < judging.least:
        return Objection(Why.LITTLE, max(judged.explained, 0.0))
    gains = (judged.before**2 - judged.after**2) / ground.sigma**2
    for name, inside in itertools.chain(*(_regimes(ground, each.wire) for each in judged.members)):
        own = np.where(inside[:, None], gains, np.nan)
        if np.isfinite(own).any(axis=1).sum() >= judging.fewest_in_regime:
            worse = sureness(by_block(ground.setting.logs, own))
            if worse < -judging.worse:
                return Objection(Why.WORSE, -worse, of=(name,))
    return None


def _size(judged: BandJudgement, ground: Ground) -> float:
    """RMS of what the effect adds on that joint, in what is worth a name."""
    logs, joint = ground.setting.logs, judged.joint
    used = logs.used[:, joint]
    coefficients = np.concatenate([each.coefficients for each in judged.members])
    own = judged.fitted.A[used, joint, -len(coefficients) :] @ coefficients
    support = float(np.sqrt(np.mean(logs.torque[used, joint] ** 2)))
    least = ground.model.criteria.device.of_support * support
    return float(np.sqrt(np.mean(own**2)) / max(min(least, ground.floor[joint]), 1e-300))


def _regimes(ground: Ground, wire: int) -> Sequence[tuple[str, BoolArray]]:
    own = ground.setting.wires[wire]
    usual = float(np.median(own.length))
    chosen: Mapping[str, Callable[[], BoolArray]] = {
        "short": lambda: own.length < usual,
        "long": lambda: own.length > usual,
        "lengthening": lambda: own.rate > 0.0,
        "shortening": lambda: own.rate < 0.0,
    }
    return [(name, np.asarray(inside())) for name, inside in chosen.items()]


def with_best_shape(ground: Ground, winner: BandJudgement, folds: Folds) -> BandJudgement:
    """The winner, judged anew with the shape that fits best, if that may still be claimed and explains more of what was
    left out of the fit; else as it was. Of an effect of one moment nothing was left out."""
    added, without = winner.added, ground.fitted.wear
    shapes = added.effect.shapes
    free = [k for k, one in enumerate(shapes) if not one.of_two]
    if not free:
        return winner
    setting, criteria = weighed(ground, winner.fitted).setting, ground.model.criteria.device

    def tried(shares: Array) -> tuple[float, ...]:
        shape = list(added.shape)
        for k, share in zip(free, np.clip(shares, 0.0, 1.0), strict=True):
            shape[k] = shapes[k].at(float(share))
        return tuple(shape)

    @cache
    def cost_of(shape: tuple[float, ...]) -> float:
        return lowest(setting, without.with_added(*(replace(each, shape=shape) for each in winner.members))).cost

    def cost(shares: Array) -> float:
        return cost_of(tried(shares))

    start = np.array([shapes[k].share(added.shape[k]) for k in free])
    steps = np.array([_first_step(shapes[k], criteria) for k in free]) * np.where(start < 0.9, 1.0, -1.0)
    found = minimize(
        cost, start, method="Nelder-Mead",
        options={"maxfev": criteria.trials * len(free), "initial_simplex": np.vstack([start, start + np.diag(steps)]),
                 "xatol": 0.005, "fatol": 1.0},
    )  # fmt: skip
    if found.fun > cost(start) - criteria.shape_worth:
        return winner
    again = judge(ground, replace(winner.score, added=replace(added, shape=tried(found.x))), folds)
    better = winner.once or float(np.nansum(again.blocks)) > float(np.nansum(winner.blocks))
    return again if better and not again.objection else winner


def _first_step(shape: Shape, criteria: Wearing) -> float:
    """As a share of its range."""
    return criteria.first_step if len(shape.grid) < criteria.fine else 0.5 / len(shape.grid)
