"""95 % intervals: symmetric where the estimate is, by profile likelihood where its doubt is skewed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from exogauge.support.band_model import Fitted, Setting, fit, thinned

Array = NDArray[np.float64]

QUANTILE = 1.959964
SKEWED = 0.15  # std over the value (over the stretch, for a length) above which a symmetric interval misleads
REACH = 12.0  # standard deviations within which the ends of a profile are sought
SHORTEST = 1e-3  # [N/m or m] of either value


def interval(
    setting: Setting, fitted: Fitted, covariance: Array, index: int, relative_to: float
) -> tuple[float, float]:
    """(low, high) of one spring's value. relative_to: its size, against which its std says whether the doubt is skewed.

    The profile's square sum counts by how much the curvature overstates what coloured residuals really tell, so that
    both kinds of interval agree where the cost is a parabola. Neither value is below 0; an end beyond reach is 0 or
    infinite.
    """
    std, value = float(np.sqrt(covariance[index, index])), float(fitted.wear.springs[index])
    if not np.isfinite(std):
        return 0.0, np.inf
    if std < SKEWED * relative_to:
        return value - QUANTILE * std, value + QUANTILE * std
    few = thinned(setting)
    coarse = fit(few, fitted.wear)
    size = 1.0 / np.sqrt(np.maximum(np.diag(coarse.hessian), 1e-300))
    curvature = np.linalg.pinv(coarse.hessian * np.outer(size, size), rcond=1e-12, hermitian=True)
    share = float(curvature[index, index]) * size[index] ** 2 / std**2
    shift = value - float(coarse.wear.springs[index])

    def excess(candidate: float) -> float:
        held = fit(few, coarse.wear, {index: max(candidate - shift, SHORTEST)})
        return float(share * (held.cost - coarse.cost) - QUANTILE**2)

    return (
        _crossing(excess, value, -std, max(SHORTEST, value - REACH * std)) or 0.0,
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
