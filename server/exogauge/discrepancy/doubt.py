"""How well an effect's numbers are known: coefficients and shapes together, the baseline fitted beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Estimate
from exogauge.discrepancy.axis_rows import AxisRows
from exogauge.discrepancy.score import Score, residual_memory
from exogauge.discrepancy.sums import AxisSums
from exogauge.effects.scales import in_si
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

STEP = 0.02  # of a shape's value, for its slope


def parameters(model: RobotModel, found: Score, rows: Sequence[AxisRows]) -> Mapping[str, Estimate]:
    """Name -> value, standard deviation, unit; shapes in units of the axis are given in SI units."""
    candidate, effect = found.candidate, found.candidate.effect
    kind = model.equations.first_axis + candidate.axis
    own = model.equations.columns()[kind]
    fitted = [each for each in rows if not each.held_out]
    left = [each.after(effect, candidate.shape, found.coefficients, found.step[own]) for each in fitted]
    variance = float(np.mean(np.concatenate(left) ** 2))
    memory = float(np.median([residual_memory(each) for each in left]))
    total = AxisSums.empty(candidate.width + len(candidate.shape), fitted[0].A.shape[1])
    for each, e in zip(fitted, left, strict=True):
        total.add(each.A, np.hstack([each.torque(effect, candidate.shape), *_slopes(found, each)]), e)
    w = model.solution.weights[kind]
    B = np.zeros((model.equations.size, len(total.own)))
    B[own] = w * total.cross.T
    S = w * total.own - B.T @ model.solution.unbounded.divided(B)
    std = np.sqrt(np.maximum(np.diag(np.linalg.pinv(S, hermitian=True)), 0.0) * w * variance * memory)
    names = [(each.name, each.unit) for each in effect.coefficients] + [
        (each.name, each.unit) for each in effect.shapes
    ]
    values = [*found.coefficients, *candidate.shape]
    estimates = {}
    for (name, own_unit), value, doubt in zip(names, values, std, strict=True):
        sizes = (model.sizes.velocity, model.sizes.torque, model.sizes.range)
        size, unit = in_si(own_unit, *(float(each[candidate.axis]) for each in sizes))
        estimates[name] = Estimate(float(value) * size, float(doubt) * size, unit)
    return estimates


def _slopes(found: Score, rows: AxisRows) -> list[Array]:
    """(n, 1) per shape: change of the effect's torque with it."""
    effect, shape = found.candidate.effect, found.candidate.shape
    columns = []
    for k, (value, one) in enumerate(zip(shape, effect.shapes, strict=True)):
        step = STEP * (abs(value) or one.high - one.low)
        low, high = max(value - step, one.low), min(value + step, one.high)
        below, above = ((*shape[:k], end, *shape[k + 1 :]) for end in (low, high))
        rise = (rows.torque(effect, above) - rows.torque(effect, below)) @ found.coefficients / (high - low)
        columns.append(rise[:, None])
    return columns
