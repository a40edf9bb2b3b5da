"""The low-pass through which a model explains logs best: its cut-off, its order, and whether it made them late.

A low-pass smears what jumps: friction, where a joint turns round. How a joint breaks away from rest depends on what
nobody logs, so only turns at once are looked at.

Logs with a device, filtered as those without it were found to have been stored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.optimize import minimize_scalar

from exogauge.criteria.detecting import StoredFilter
from exogauge.devices.result import Estimate
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import measured_channels, predictions
from exogauge.identification.preparation import Prepared
from exogauge.identification.settings import Recording
from exogauge.identification.turns import TurnsOf
from exogauge.logs.filtering import StoredPass
from exogauge.logs.model import Log
from exogauge.logs.stored_band import stored_edge
from exogauge.support.settings import WornLog

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

USUAL = StoredPass(0.0)
SHAPES: tuple[tuple[Literal["butterworth", "bessel"], int, bool], ...] = (
    *(("butterworth", order, late) for order in (1, 2, 3, 4) for late in (False, True)),
    *(("bessel", order, late) for order in (2, 3, 4) for late in (False, True)),
)


@final
@dataclass(frozen=True)
class Band:
    """cutoff: where half of an amplitude is left. logs: names of those stored with it."""

    stored: StoredPass
    cutoff: Estimate
    logs: tuple[str, ...]


def beside_rest(prepared: Prepared, criteria: StoredFilter) -> BoolArray:
    """(T, A) samples of motion and of turns, as far from rest and from the log's ends as a low-pass reaches; of an axis
    that hardly has any, all that are settled."""
    rate_hz, settled = prepared.log.rate_hz, prepared.settled[:, None].copy()
    turn, reach = (max(round(seconds * rate_hz), 1) for seconds in (criteria.turn_s, criteria.forgotten_s))
    end = min(reach, prepared.log.samples // 10)
    settled[:end] = settled[prepared.log.samples - end :] = False
    still = (prepared.raw_direction == 0.0).astype(np.uint8)
    long = maximum_filter1d(minimum_filter1d(still, turn, axis=0), turn, axis=0)
    free = (maximum_filter1d(long, 2 * reach + 1, axis=0) == 0) & settled
    enough = free.sum(axis=0) > criteria.least_s * rate_hz
    return np.asarray(np.where(enough, free, settled))


def stored_band(model: RobotModel, logs: Sequence[Log], edge_hz: float) -> Band | None:
    """The low-pass through which the model, one without added effects, explains the unfiltered logs best; None where
    the best of the usual shape is at an end of what is tried, so that no band explains them.

    Std: one block of a second left out at a time (jackknife).
    """
    trials, criteria = _Trials(model, logs), model.criteria.stored_filter
    highest = criteria.above_edge * edge_hz
    steps = round(np.log(highest / criteria.lowest_hz) / np.log(criteria.coarse))
    cutoffs = np.geomspace(criteria.lowest_hz, highest, max(steps, 3))
    best = int(np.argmin(_unexplained(trials.squares(USUAL, cutoffs))))
    if best in (0, len(cutoffs) - 1):
        return None
    shape = _best_shape(trials, float(cutoffs[best]), criteria.widths)
    cutoffs = np.geomspace(shape.hz / criteria.near, shape.hz * criteria.near, criteria.fine)
    squares = trials.squares(shape, cutoffs)
    total = squares.sum(axis=2, keepdims=True)
    hz = _lowest(cutoffs, _unexplained(squares))
    without = np.array(
        [_lowest(cutoffs, _unexplained(total - squares[:, :, [block]])) for block in range(squares.shape[2])]
    )
    count = len(without)
    std = float(np.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))) if count > 1 else float("inf")
    step = float(hz * np.log(cutoffs[1] / cutoffs[0]))
    names = tuple(log.name for log in logs)
    stored = replace(shape, hz=hz)
    half = stored.half_hz(logs[0].rate_hz)
    return Band(stored, Estimate(half, float(np.hypot(std, step / np.sqrt(12.0))) * half / hz, "Hz"), names)


@final
class _Trials:
    """What the model leaves of these logs behind one low-pass or another.

    Nothing is identified anew for each: a low-pass acts on what jumps, which is friction. So every joint's friction,
    the scale of its load and an offset are fitted, beside what the model says without friction's jumps.
    """

    def __init__(self, model: RobotModel, logs: Sequence[Log]) -> None:
        self._prepared = [model.prepare(log) for log in logs]
        self._turns = [TurnsOf(model.robot, log, model.at_rest) for log in logs]
        self._free = [beside_rest(each, model.criteria.stored_filter) for each in self._prepared]
        block_s = model.criteria.judging.block_s
        self._block = [(np.arange(log.samples) / (block_s * log.rate_hz)).astype(np.intp) for log in logs]
        measured = [measured_channels(model.equations, each, model.k_T) for each in self._prepared]
        smooth = [predictions(model.equations, _without_jumps(each), [model.identified])[0] for each in self._prepared]
        names = enumerate(f"tau.{joint.name}" for joint in model.robot.joints)
        self._axes = [(axis, name) for axis, name in names if name in measured[0]]
        self._y = [[each[name] for each in measured] for _, name in self._axes]
        self._load = [[each[name] for each in smooth] for _, name in self._axes]

    def squares(self, shape: StoredPass, cutoffs: Sequence[float] | Array) -> Array:
        """(cut-offs, joints, blocks) sums of squared residuals over a block each."""
        return np.array([self._left(replace(shape, hz=float(hz))) for hz in cutoffs])

    def _left(self, stored: StoredPass) -> Array:
        jumps = [each.stored_direction(stored) for each in self._turns]
        found = []
        for (axis, _), measured, smooth in zip(self._axes, self._y, self._load, strict=True):
            free = [each[:, axis] for each in self._free]
            columns = [
                np.column_stack([jump[:, axis], each.axis_velocity[:, axis], load, np.ones(len(load))])
                for jump, each, load in zip(jumps, self._prepared, smooth, strict=True)
            ]
            A = np.concatenate([each[own] for each, own in zip(columns, free, strict=True)])
            y = np.concatenate([each[own] for each, own in zip(measured, free, strict=True)])
            x = np.linalg.lstsq(A, y, rcond=None)[0]
            left = [np.where(own, y - A @ x, 0.0) for own, y, A in zip(free, measured, columns, strict=True)]
            found.append(np.concatenate([np.bincount(n, e**2) for n, e in zip(self._block, left, strict=True)]))
        return np.array(found)


def _without_jumps(prepared: Prepared) -> Prepared:
    nothing = np.zeros(prepared.raw_direction.shape)
    return replace(prepared, stored_direction=nothing, stored_rest=nothing)


def _best_shape(trials: _Trials, usual_hz: float, widths: float) -> StoredPass:
    """Of all kinds and orders, passed once or there and back, each at its best cut-off."""
    found = []
    for kind, order, late in SHAPES:
        shape = StoredPass(usual_hz, order, late, kind)
        best = minimize_scalar(
            lambda log_hz, shape=shape: float(_unexplained(trials.squares(shape, [np.exp(log_hz)]))[0]),
            bounds=(np.log(usual_hz / widths), np.log(usual_hz * widths)),
            method="bounded",
            options={"xatol": 0.01},
        )
        found.append((float(best.fun), replace(shape, hz=float(np.exp(best.x)))))
    return min(found, key=lambda each: each[0])[1]


def _unexplained(squares: Array) -> Array:
    """(cut-offs,) mean over channels of the logarithm of what is left."""
    return np.asarray(np.log(np.maximum(squares.sum(axis=2), 1e-300)).mean(axis=1))


def _lowest(cutoffs: Array, score: Array) -> float:
    """Where a parabola through the best three has its lowest point."""
    middle = int(np.clip(np.argmin(score), 1, len(cutoffs) - 2))
    x, y = np.log(cutoffs[middle - 1 : middle + 2]), score[middle - 1 : middle + 2]
    a, b, _ = np.polyfit(x - x[1], y, 2)
    at = -b / (2.0 * a) if a > 0.0 else 0.0
    return float(np.exp(x[1] + np.clip(at, x[0] - x[1], x[2] - x[1])))


def filtered_alike(
    worn: Sequence[WornLog], recordings: Sequence[Recording], criteria: StoredFilter
) -> tuple[WornLog, ...]:
    """recordings: without a device, with the band that was found in them, if any (`band_limits`).

    A log with a device gets the same band where its spectrum ends where theirs do: bands pull as slowly as the robot
    moves, so an end of the spectrum that is the recorder's own is seen with them on as well. Which cut-off it is cannot
    be found from such a log by itself, because no model of the wear is known yet.
    """
    limited = [each.log for each in recordings if each.log.stored is not None]
    if not limited:
        return tuple(worn)
    edges = [edge.hz for edge in map(stored_edge, limited) if edge]
    middle, stored = float(np.median(edges)), limited[0].stored

    def alike(each: WornLog) -> bool:
        edge = stored_edge(each.log)
        return edge is not None and middle / criteria.alike < edge.hz < middle * criteria.alike

    return tuple(replace(each, log=replace(each.log, stored=stored)) if alike(each) else each for each in worn)
