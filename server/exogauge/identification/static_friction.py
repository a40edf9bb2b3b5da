"""Static friction, from the samples at which an axis rests; all else is known by then.

What a joint's friction does there is known less well than in steady motion: it may stick at any value below its
largest. Fitted together with everything else, those samples bend Coulomb and viscous friction, and with them k_T. So
they decide one parameter per axis only, and what they leave unexplained says how far it can be believed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.equations import Equations

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Sticking:
    """x: (P,) with static friction filled in. std: name -> [N·m] spread of the friction met at rest.

    lower_bounds: joints where that spread says that friction at rest is often below its largest value, so that
    [Evaluator] (8), |τ_s| = τ_s^max, does not hold and τ_s is a lower bound.
    """

    x: Array
    std: Mapping[str, float]
    lower_bounds: tuple[str, ...]


def fill_static_friction(equations: Equations, statistics: Statistics, prior: Prior, x: Array) -> Sticking:
    """Least squares for τ_s of every axis with all other parameters of x held; left at the prior, and so not known,
    where the axis hardly rests."""
    criteria = equations.criteria.identifying
    x, std, doubtful = x.copy(), {}, []
    for k in [k for k, effect in enumerate(equations.effects) if effect.name == "static_friction"]:
        for axis, joint in enumerate(equations.robot.joints):
            moving, resting = equations.layout.axis(axis), equations.layout.resting(axis)
            column = int(equations.effect_columns(axis)[k])
            slope, curvature = statistics.along(resting, len(equations.blocks.columns[moving]) + k, x)
            rows = statistics.count[resting]
            fewest = max(criteria.rest_rows, criteria.least_rest * (rows + statistics.count[moving]))
            if joint.actuation == "none" or rows < fewest or curvature <= 1e-6 * rows:
                x[column] = prior.seen_mean[column]
                continue
            x[column] = max(x[column] + slope / curvature, 0.0)
            met, usual = (statistics.left(kind, x) / max(statistics.count[kind], 1) for kind in (resting, moving))
            std[f"tau_s[{joint.name}]"] = float(np.sqrt(met))
            if met > criteria.scatter**2 * usual:
                doubtful.append(joint.name)
    return Sticking(x, std, tuple(doubtful))
