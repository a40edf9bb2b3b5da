"""95 % intervals: symmetric where the estimate is, by profile likelihood where its doubt is skewed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from exogauge.devices.band_fit import SEARCHED, BandFit, Belief, at, fit_bands, refit_with_held

Array = NDArray[np.float64]

QUANTILE = 1.959964
SKEWED = 0.15  # std over the value (over the stretch, for a length) above which a symmetric interval misleads
REACH = 12.0  # standard deviations within which the ends of a profile are sought


def interval(
    fit: BandFit, covariance: Array, index: int, relative_to: float, beliefs: Sequence[Belief] = ()
) -> tuple[float, float]:
    """(low, high) of one parameter. relative_to: its size, against which its std says whether the doubt is skewed.

    The profile's square sum counts by how much the curvature overstates what coloured residuals really tell, so that
    both kinds of interval agree where the cost is a parabola. Neither parameter is below 0; an end beyond reach is
    0 or infinite.
    """
    std = float(np.sqrt(covariance[index, index]))
    value = float(fit.theta[index])
    if not np.isfinite(std):
        return 0.0, np.inf
    if std < SKEWED * relative_to:
        return value - QUANTILE * std, value + QUANTILE * std
    few = fit.reduced.every(max(1, fit.reduced.samples // SEARCHED))
    coarse = at(fit.layout, few, fit_bands(fit.layout, few, beliefs).theta, beliefs)
    lowest = refit_with_held(coarse, index, float(coarse.theta[index]), beliefs)
    scale = fit.layout.scale
    curvature = np.linalg.pinv(coarse.hessian * np.outer(scale, scale), rcond=1e-12, hermitian=True)
    share = float(curvature[index, index]) * scale[index] ** 2 / std**2
    shift = value - float(coarse.theta[index])

    def excess(candidate: float) -> float:
        return float(share * (refit_with_held(coarse, index, candidate - shift, beliefs) - lowest) - QUANTILE**2)

    floor = 1e-3
    return (
        _crossing(excess, value, -std, max(floor, value - REACH * std)) or 0.0,
        _crossing(excess, value, std, value + REACH * std) or np.inf,
    )


def _crossing(excess: Callable[[float], float], value: float, step: float, limit: float) -> float | None:
    """Where the profile crosses its level, going from value by steps towards limit; None if it does not."""
    near = value
    while (limit - near) * np.sign(step) > 0.0:
        far = near + step
        far = min(far, limit) if step > 0.0 else max(far, limit)
        if excess(far) > 0.0:
            return float(brentq(excess, near, far, xtol=1e-3 * abs(step)))
        near = far
        step *= 1.5
    return None
