"""Coefficients as the model with all that was named has them: what was named later moves those of what was before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from exogauge.findings.result import Finding
from exogauge.identification.model import AddedEffect, RobotModel
from exogauge.search.shape_doubt import coefficients


def with_final_numbers(finding: Finding, added: AddedEffect, model: RobotModel) -> Finding:
    """added: which effect of `model` the finding is about. Standard deviations and shapes stay."""
    numbers = dict(finding.parameters)
    for name, value in _coefficients(added, model).items():
        numbers[name] = replace(numbers[name], value=value)
    return replace(finding, parameters=numbers)


def _coefficients(added: AddedEffect, model: RobotModel) -> Mapping[str, float]:
    """Name -> value in SI units."""
    return {
        quantity.name: float(value) * added.site.in_si(model, quantity.unit, added.shape)[0]
        for quantity, value in zip(added.effect.coefficients, coefficients(model, added), strict=True)
    }
