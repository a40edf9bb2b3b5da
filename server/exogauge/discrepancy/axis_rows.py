"""The rows of a few axes, log by log: what refining a shape and judging a candidate need beyond sums."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.discrepancy.sums import AxisSums
from exogauge.effects.shaped import AxisSignals, ShapedEffect
from exogauge.identification.added import axis_signals
from exogauge.identification.model import RobotModel
from exogauge.identification.settings import Recording
from exogauge.logs.filtering import LowPass

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class AxisRows:
    """Steady rows of one axis in one log. samples: (n,) of the log. A: (n, k), e: (n,) y - A x [N·m]."""

    log: str
    held_out: bool
    rate_hz: float
    signals: AxisSignals
    low_pass: LowPass
    samples: IntArray
    A: Array
    e: Array

    def torque(self, effect: ShapedEffect, shape: tuple[float, ...]) -> Array:
        """(n, C) the effect's columns as the drive sees them."""
        return np.asarray(self.low_pass.apply(effect.columns(self.signals, shape))[self.samples])

    def after(self, effect: ShapedEffect, shape: tuple[float, ...], coefficients: Array, step: Array) -> Array:
        """(n,) what is left with the effect in the model. step: (k,) by which the baseline moves."""
        return np.asarray(self.e - self.A @ step + self.torque(effect, shape) @ coefficients)


def collect_rows(
    model: RobotModel, recordings: Sequence[Recording], axes: Sequence[int]
) -> Mapping[int, tuple[AxisRows, ...]]:
    """axis -> its rows in every log that has any."""
    if not axes:
        return {}
    equations, x = model.equations, model.solution.unbounded.x
    kinds = equations.columns()
    found: dict[int, list[AxisRows]] = {axis: [] for axis in axes}
    for recording in recordings:
        prepared = model.prepare(recording.log)
        parts: dict[int, list[tuple[IntArray, Array, Array]]] = {axis: [] for axis in axes}
        for _, chunks in equations.rows(prepared, x):
            for chunk in chunks:
                axis = chunk.kind - equations.first_axis
                if axis in parts:
                    A, y = chunk.block[:, :-1].copy(), chunk.block[:, -1]
                    parts[axis].append((prepared.kept[chunk.samples], A, y - A @ x[kinds[chunk.kind]]))
        for axis, signals in zip(axes, axis_signals(model, prepared, axes), strict=True):
            if parts[axis]:
                samples, A, e = (np.concatenate(each) for each in zip(*parts[axis], strict=True))
                rate = prepared.log.rate_hz / float(prepared.kept[1] - prepared.kept[0])
                found[axis].append(
                    AxisRows(recording.log.name, recording.held_out, rate, signals, prepared.low_pass, samples, A, e)
                )
    return {axis: tuple(rows) for axis, rows in found.items()}


def sums_of(rows: Sequence[AxisRows], effect: ShapedEffect, shape: tuple[float, ...]) -> AxisSums:
    """Over the fitted logs."""
    fitted = [each for each in rows if not each.held_out]
    total = AxisSums.empty(len(effect.coefficients), fitted[0].A.shape[1])
    for each in fitted:
        total.add(each.A, each.torque(effect, shape), each.e)
    return total
