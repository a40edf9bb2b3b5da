"""A quick solution of one log, and what it leaves of blocks that it did not fit: to compare preparations by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.predict import measured_channels, motor_gain, predictions, split
from exogauge.identification.preparation import prepare
from exogauge.identification.prior import added_std, per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.solution import FOLDS, PASSES, solve
from exogauge.identification.static_friction import fill_static_friction
from exogauge.identification.steady import keeps_most
from exogauge.identification.turns import rest_detection
from exogauge.logs.model import Log

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class QuickFit:
    """left: mean over channels of the logarithm of the share of the unfiltered channel, turns and rests included, that
    is left unexplained in blocks that were not fitted. keeps_most: see `steady.keeps_most`; keeps_judged: the same of a
    log that is held out."""

    left: float
    keeps_most: bool
    keeps_judged: bool


def quick_fit(equations: Equations, judged: Log | None, log: Log, cutoff_hz: float) -> QuickFit:
    """Each of `FOLDS` consecutive blocks explained by what the others say.

    One pass less than a whole solution, at the prior's stated strength. equations: without added effects. judged: a log
    that is held out; of it only the motion is looked at, not what drives it.
    """
    robot = equations.robot
    at_rest = rest_detection(robot, [log], cutoff_hz)
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
    keeps_judged = judged is None or keeps_most(prepare(robot, judged, cutoff_hz, at_rest))
    return QuickFit(float(np.mean(0.5 * np.log(shares))), keeps_most(prepared), keeps_judged)
