"""The cut-off that serves the equations best, found by trying."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from itertools import takewhile
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.errors import NotIdentifiable
from exogauge.identification.equations import Equations
from exogauge.identification.predict import measured_channels, motor_gain, predictions, split
from exogauge.identification.preparation import Prepared, prepare, suggested_cutoffs
from exogauge.identification.prior import added_std, per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.solution import FOLDS, PASSES, solve
from exogauge.identification.static_friction import fill_static_friction
from exogauge.identification.steady import keeps_most
from exogauge.identification.turns import WIDEST, rest_detection
from exogauge.logs.derivatives import derivative_noise_gain
from exogauge.logs.model import Log
from exogauge.logs.noise import noise_of
from exogauge.robots.description import Robot
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

LOWEST_HZ = 2.0
AS_GOOD = np.log(1.02)  # two per cent of the residual are of no use to anyone; a lower cut-off lets in less noise
STOP = np.log(1.15)  # so much worse that no other gain makes up for it


class Keeps(IntEnum):
    """Whose motion a cut-off keeps: that of the log that is fitted, and of the one that judges."""

    NEITHER = 0
    FITTED = 1
    BOTH = 2


@final
@dataclass(frozen=True)
class Trial:
    """left: mean over channels of the logarithm of the share of the unfiltered channel, turns and rests included, that
    is left unexplained in blocks that were not fitted; infinite where so low a bandwidth leaves no steady motion to
    identify from. keeps: most of it, see `steady.keeps_most`. quiet: no axis' acceleration holds more noise of its
    position than a fit can take off again. noise: half of the axes' accelerations are more noise than motion."""

    left: float
    keeps: Keeps
    quiet: bool = True
    noise: bool = False


def choose_cutoff(robot: Robot, logs: Sequence[Log], slowest_hz: float, trial: Callable[[Log, float], Trial]) -> float:
    """[Hz] the lowest that predicts left-out blocks as well as the best does and keeps most of every axis' motion, in
    the log that is fitted and in the one that judges; in the former alone, where no cut-off does both.

    Tried from the highest cut-off that the spectra suggest, downwards and upwards, in octaves, on the log that suggests
    it, of those at least half as long as the longest: a calm one would say that a low one serves, and what only fast
    motion shows be lost.
    Downwards, because elastic vibration and current ripple often call for less bandwidth than the sensors could give.
    Upwards, because a slow motion's positions bear little bandwidth, but what is left out around every turn lasts as
    long as the low-pass: so slow a one may leave no row, or rows in one direction only. Where nothing that is as good
    keeps most of the motion, what keeps it may be worse by 15 %. Where any keeps it whose accelerations are not drowned
    in noise, only such; and none at which half of the axes' accelerations are more noise than motion, where a lower one
    identifies: turns that are sharp again make up for no inertia. Never more than 0.2 of the sampling rate, or than
    `slowest_hz`, the lowest sampling rate of any log that is to be predicted, bears.
    """
    halvings = 5  # at most: below the positions' own bandwidth by a factor of 32
    suggested, longest = suggested_cutoffs(robot, logs), max(one.samples for one in logs)
    long_enough = [pair for pair in zip(suggested, logs, strict=True) if pair[1].samples >= longest / 2]
    _, log = max(long_enough, key=lambda pair: (pair[0], pair[1].samples))
    highest = min(LOGS.fastest * min(one.rate_hz for one in logs), WIDEST * slowest_hz)
    first = min(max(suggested), highest)
    lower = (first / 2.0**number for number in range(1, halvings + 1))
    downwards = [first, *takewhile(lambda hz: hz >= LOWEST_HZ, lower)]
    doubled = (first * 2.0**number for number in range(1, 64))
    upwards = [*takewhile(lambda hz: hz < highest, doubled), highest] if first < highest else []
    tried: dict[float, Trial] = {}

    def drowned(hz: float) -> bool:
        if tried[hz].noise and any(not one.noise and np.isfinite(one.left) for one in tried.values()):
            return True
        return not tried[hz].quiet and any(one.quiet and one.keeps is Keeps.BOTH for one in tried.values())

    for cutoff_hz, found in _in_turn(trial, log, downwards):
        tried[cutoff_hz] = found
        if cutoff_hz < first and np.isfinite(_best(tried)) and found.left > _best(tried) + STOP:
            break
    before = tried[first]
    for cutoff_hz, found in _in_turn(trial, log, upwards):
        tried[cutoff_hz] = found
        if drowned(cutoff_hz):
            break
        improved = not np.isfinite(before.left) or found.left < before.left - AS_GOOD
        if before.keeps is Keeps.BOTH and not improved:
            break
        some_keep = any(one.keeps > Keeps.NEITHER for one in tried.values())
        if some_keep and found.left > _best(tried) + STOP:  # a fit of hardly any rows errs as the stated numbers do
            break
        before = found
    tried = {hz: one for hz, one in tried.items() if not drowned(hz)}
    as_good = [hz for hz, one in tried.items() if one.left <= _best(tried) + AS_GOOD]
    good_enough = [hz for hz, one in tried.items() if one.left <= _best(tried) + STOP]
    for wanted in (Keeps.BOTH, Keeps.FITTED):
        keeping = [hz for hz in good_enough if tried[hz].keeps >= wanted]
        if keeping:
            return min(set(as_good) & set(keeping) or keeping)
    return min(as_good)


def _best(tried: Mapping[float, Trial]) -> float:
    return min(one.left for one in tried.values())


def _in_turn(trial: Callable[[Log, float], Trial], log: Log, cutoffs: Sequence[float]) -> Iterator[tuple[float, Trial]]:
    """On several processors the next are under way while one is looked at; of what nobody asks for any more nothing is
    known."""
    yield from zip(cutoffs, side_by_side(partial(_tried, trial, log), cutoffs), strict=True)


def _tried(trial: Callable[[Log, float], Trial], log: Log, cutoff_hz: float) -> Trial:
    try:
        return trial(log, cutoff_hz)
    except NotIdentifiable:
        return Trial(np.inf, Keeps.NEITHER)


def noise_of_acceleration(robot: Robot, log: Prepared) -> Array:
    """(A,) share of each axis' mean square acceleration, in steady motion, that is noise of its position; 0 where it
    has none."""
    positions = [log.log.channels[f"q.{joint.name}"] for joint in robot.joints]
    seen = [each.std for each in noise_of(positions, log.log.rate_hz, 0.25 * log.log.rate_hz)]
    std = derivative_noise_gain(log.low_pass, 2) * np.maximum(seen, robot.noise.get("q", 0.0))
    inside = log.steady & log.settled[:, None]
    square = np.mean(log.axis_acceleration**2, axis=0, where=inside | ~inside.any(axis=0))
    noise = robot.axes_from_joints**2 @ std**2
    return np.asarray(np.divide(noise, square, out=np.zeros(len(noise)), where=inside.any(axis=0) & (square > 0.0)))


def quick_fit(equations: Equations, judged: Log | None, log: Log, cutoff_hz: float) -> Trial:
    """Each of `FOLDS` consecutive blocks explained by what the others say.

    One pass less than a whole solution, at the prior's stated strength. equations: without added effects. judged: a log
    that is held out; of it only the motion is looked at, not what drives it.
    """
    robot = equations.robot
    at_rest = rest_detection(robot, [log], cutoff_hz, criteria=equations.criteria.resting)
    prepared = prepare(robot, log, cutoff_hz, at_rest)
    seen = scales(robot, [prepared])
    added = added_std(equations, [prepared], seen)
    prior = per_parameter(robot, equations.base, equations.effects, seen, added, equations.added)
    solution = solve(equations, [prepared], prior, Settings(prior_strength=1.0), passes=PASSES - 1)
    folds = equations.collect(prepared, solution.x_before, FOLDS)
    alternatives = []
    for fold in folds:
        others = sum((each for each in folds if each is not fold), start=fold.cleared())
        x = fill_static_friction(equations, others, prior, solution.of(others).x).x
        alternatives.append(split(equations, prior.lift(x)))
    blocks = np.array_split(np.arange(log.samples), FOLDS)
    residuals = dict[str, list[Array]]()
    everywhere = predictions(equations, prepared, alternatives)
    for parameters, predicted, block in zip(alternatives, everywhere, blocks, strict=True):
        measured = measured_channels(equations, prepared, motor_gain(equations, parameters))
        for channel, values in measured.items():
            size = np.mean(values**2)
            error = values[block] - predicted[channel][block]
            residuals.setdefault(channel, []).append(error**2 / size if size > 0.0 else np.full(len(block), np.inf))
    shares = [np.mean(np.concatenate(each)) for each in residuals.values()]
    criteria = equations.criteria.identifying
    keeps = Keeps.NEITHER
    if keeps_most(prepared, criteria):
        both = judged is None or keeps_most(prepare(robot, judged, cutoff_hz, at_rest), criteria)
        keeps = Keeps.BOTH if both else Keeps.FITTED
    share = noise_of_acceleration(robot, prepared)
    moves = share[share > 0.0]
    quiet, noise = bool(np.all(share <= criteria.noisy)), moves.size > 0 and float(np.median(moves)) > criteria.drowned
    return Trial(float(np.mean(0.5 * np.log(shares))), keeps, quiet, noise)
