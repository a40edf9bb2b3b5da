"""The ground that candidates are tried on: one pass over all logs, after which none is needed to rank them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.discrepancy.candidates import Candidate, candidates_on, torques
from exogauge.discrepancy.score import Score, residual_memory, score
from exogauge.discrepancy.sums import Sums
from exogauge.effects.shaped import AxisSignals, ShapedEffect
from exogauge.identification.added import axis_signals
from exogauge.identification.model import RobotModel
from exogauge.identification.settings import Recording

Array = NDArray[np.float64]
Tick = Callable[[float, str], None]

FEWEST = 20  # samples of steady motion, below which a log says nothing of how residuals are coloured


@final
@dataclass(frozen=True)
class LogResiduals:
    """What is left of one log at its n kept samples: (n, A) each, NaN where an axis gives no row.

    residual [N·m]; signals: by axis, at the kept samples, for words and plots.
    """

    log: str
    held_out: bool
    rate_hz: float
    residual: Array
    velocity: Array
    position: Array
    load: Array
    time: Array


@final
@dataclass(frozen=True)
class Ground:
    """candidates: axis -> those that any fitted log holds what they need for. fitted: sums of the columns of all
    effects that the model has not, in the order of `candidates_on`. memory: axis -> samples of the fitted logs that
    count as one. scores: of every candidate that the baseline does not swallow, best first."""

    model: RobotModel
    candidates: Mapping[int, Sequence[Candidate]]
    fitted: Sums
    memory: Mapping[int, float]
    residuals: tuple[LogResiduals, ...]
    scores: tuple[Score, ...]


def measured_axes(model: RobotModel) -> list[int]:
    return [axis for axis, joint in enumerate(model.robot.joints) if joint.actuation != "none"]


def lay_ground(
    model: RobotModel, recordings: Sequence[Recording], effects: Sequence[ShapedEffect], tick: Tick
) -> Ground:
    """Pass over the logs, then score every candidate on the fitted ones."""
    axes, x = measured_axes(model), model.solution.unbounded.x
    fitted, kept_out = Sums(), Sums()
    missing = {axis: _not_in(model, axis, effects) for axis in axes}
    candidates = {axis: candidates_on(axis, missing[axis]) for axis in axes}
    shown: dict[int, set[str]] = {axis: set() for axis in axes}  # effects that some fitted log can show
    residuals: list[LogResiduals] = []
    order = sorted(recordings, key=lambda each: each.held_out)
    for number, recording in enumerate(order):
        tick(number / len(order), f"trying what may be missing in {recording.log.name}")
        prepared = model.prepare(recording.log)
        signals = dict(zip(axes, axis_signals(model, prepared, axes), strict=True))
        if not recording.held_out:
            for axis in axes:
                shown[axis] |= {effect.name for effect in missing[axis] if effect.applies(signals[axis])}
        columns: dict[int, Array] = (
            {axis: np.zeros((len(prepared.kept), 0)) for axis in axes}
            if recording.held_out
            else {axis: torques(candidates[axis], signals[axis], prepared) for axis in axes}
        )
        left = (kept_out if recording.held_out else fitted).take(model.equations, prepared, x, columns)
        residuals.append(_residuals(recording, left, signals, prepared.kept, prepared.log.rate_hz))
    memory = {axis: _memory(residuals, axis) for axis in axes}
    scores = [each for each in _ranked(model, candidates, fitted, memory) if _is_shown(each.candidate, shown)]
    tried = {axis: [each for each in candidates[axis] if _is_shown(each, shown)] for axis in axes}
    return Ground(model, tried, fitted, memory, tuple(residuals), tuple(scores))


def _is_shown(candidate: Candidate, shown: Mapping[int, set[str]]) -> bool:
    return candidate.effect.name in shown[candidate.axis]


def _not_in(model: RobotModel, axis: int, effects: Sequence[ShapedEffect]) -> list[ShapedEffect]:
    """An effect sits on an axis once."""
    there = {each.effect.name for each in model.extension.effects if each.axis == axis} if model.extension else set()
    return [effect for effect in effects if effect.name not in there]


def _memory(residuals: Sequence[LogResiduals], axis: int) -> float:
    """Median of the fitted logs in which the axis moves; one in which it rests knows nothing of it."""
    fitted = [each.residual[:, axis] for each in residuals if not each.held_out]
    known = [residual_memory(e) for e in fitted if np.isfinite(e).sum() >= FEWEST]
    return float(np.median(known)) if known else 1.0


def _residuals(
    recording: Recording, left: Array, signals: Mapping[int, AxisSignals], kept: NDArray[np.intp], rate_hz: float
) -> LogResiduals:
    velocity, position, load = (np.zeros_like(left) for _ in range(3))
    for axis, seen in signals.items():
        velocity[:, axis], position[:, axis], load[:, axis] = (
            seen.velocity[kept], seen.position[kept], seen.load[kept],
        )  # fmt: skip
    time = recording.log.time[kept] - recording.log.time[0]
    rate = rate_hz / float(kept[1] - kept[0])
    return LogResiduals(recording.log.name, recording.held_out, rate, left, velocity, position, load, time)


def _ranked(
    model: RobotModel, candidates: Mapping[int, Sequence[Candidate]], fitted: Sums, memory: Mapping[int, float]
) -> tuple[Score, ...]:
    scores = []
    for axis, sums in fitted.by_axis.items():
        start = 0
        for candidate in candidates[axis]:
            part = slice(start, start + candidate.width)
            start += candidate.width
            found = score(model, candidate, sums.part(part), memory[axis])
            if found is not None and found.gain > 0.0:
                scores.append(found)
    return tuple(sorted(scores, key=lambda each: -each.evidence))
