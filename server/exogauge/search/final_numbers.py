"""Coefficients as the model with all that was named has them: what was named later moves those of what was before.

So does what the same fit decides, such as a joint's k_T: torques are told on its scale, and so is the curve.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.findings.result import Finding
from exogauge.identification.model import AddedEffect, RobotModel
from exogauge.search.shape_doubt import coefficients, place_of

Array = NDArray[np.float64]


def with_final_numbers(finding: Finding, added: AddedEffect, model: RobotModel) -> Finding:
    """added: which effect of `model` the finding is about. Shapes stay. A standard deviation is no less than that of
    the whole fit, in which a torque is no better known than the scale of all torques. The curve is what the effect
    does with these coefficients; where they moved apart, with the factor that comes nearest."""
    quantities, numbers = added.effect.coefficients, dict(finding.parameters)
    scale = np.array([added.site.in_si(model, quantity.unit, added.shape)[0] for quantity in quantities])
    now, place = coefficients(model, added) * scale, place_of(model, added)
    std = np.sqrt(np.maximum(np.diag(model.covariance)[place], 0.0)) * np.abs(scale)
    was = np.array([numbers[quantity.name].value for quantity in quantities])
    for quantity, value, least in zip(quantities, now, std, strict=True):
        known = numbers[quantity.name]
        numbers[quantity.name] = replace(known, value=float(value), std=float(max(known.std, least)))
    drawn = replace(finding.evidence, model=finding.evidence.model * _factor(was, now))
    return replace(finding, parameters=numbers, evidence=drawn)


def _factor(was: Array, now: Array) -> float:
    square = float(was @ was)
    return float(was @ now) / square if square > 0.0 else 1.0
