"""One quick solution of a few logs, and what it leaves of their unfiltered channels: to compare preparations by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.predict import measured_channels, motor_gain, predicted_channels, split
from exogauge.identification.preparation import prepare
from exogauge.identification.prior import added_std, per_parameter, scales
from exogauge.identification.settings import Settings
from exogauge.identification.solution import solve
from exogauge.identification.turns import rest_detection
from exogauge.logs.model import Log

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class QuickFit:
    """One log. measured, residual: channel -> (T,) unfiltered, and less what is predicted; turns and rests included."""

    measured: Mapping[str, Array]
    residual: Mapping[str, Array]


def quick_fit(equations: Equations, logs: Sequence[Log], cutoff_hz: float) -> list[QuickFit]:
    """One solution for all logs together, each explained by it.

    Two passes at the prior's stated strength. equations: without added effects.
    """
    robot = equations.robot
    at_rest = rest_detection(robot, logs, cutoff_hz)
    prepared = [prepare(robot, log, cutoff_hz, at_rest) for log in logs]
    seen = scales(robot, prepared)
    prior = per_parameter(robot, equations.base, equations.effects, seen, added_std(equations, prepared, seen))
    solution = solve(equations, prepared, prior, Settings(prior_strength=1.0), passes=2)
    parameters = split(equations, solution.solved.prior.lift(solution.sticking.x))
    k_T = motor_gain(equations, parameters)
    found = []
    for one in prepared:
        measured, predicted = measured_channels(equations, one, k_T), predicted_channels(equations, one, parameters)
        found.append(QuickFit(measured, {channel: values - predicted[channel] for channel, values in measured.items()}))
    return found
