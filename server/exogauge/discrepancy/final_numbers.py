"""Coefficients as the model that is handed on has them: what was named later moves those of what was named before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from exogauge.discrepancy.result import Finding
from exogauge.identification.added import AddedEffect
from exogauge.identification.model import RobotModel


def with_final_numbers(finding: Finding, added: Sequence[AddedEffect], model: RobotModel) -> Finding:
    """added: what of `model` the finding is about. Standard deviations and shapes stay."""
    numbers = dict(finding.parameters)
    for name, value in _coefficients(added, model).items():
        if name in numbers:
            numbers[name] = replace(numbers[name], value=value)
    return replace(finding, parameters=numbers)


def _coefficients(added: Sequence[AddedEffect], model: RobotModel) -> Mapping[str, float]:
    """Name -> value in SI units."""
    effects = model.extension.effects if model.extension else ()
    values = list(model.identified.added)
    values = values[len(values) - sum(len(each.effect.coefficients) for each in effects) :]
    found: dict[str, float] = {}
    for each in effects:
        for quantity in each.effect.coefficients:
            value = float(values.pop(0))
            if each in added:
                found[quantity.name] = value * each.site.in_si(model, quantity.unit, each.shape)[0]
    return found
