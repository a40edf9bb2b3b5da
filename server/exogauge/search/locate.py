"""Which channels are off by more than their sensors' noise, on logs that were not fitted, and where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.findings.result import THROUGHOUT, Concentration, Coordinate, Excess
from exogauge.findings.verdict import Seen
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import channel_of_row
from exogauge.identification.result import ChannelFit, Identification
from exogauge.identification.validate import unit_of
from exogauge.robots.rows import Row, RowType
from exogauge.search.baseline import LogResiduals

Array = NDArray[np.float64]


def located(equations: Equations, found: Identification, residuals: Sequence[LogResiduals]) -> tuple[Excess, ...]:
    """Channels whose held-out error, in steady motion, stands above the noise floor; largest ratio first."""
    result, judging = list[Excess](), found.model.criteria.judging
    for kind, channel in all_channels(equations).items():
        fits = [fit for fit in found.validation if fit.held_out and fit.channel == channel]
        rmse, floor = pooled(fits)
        if not np.isfinite(rmse) or rmse < judging.above * floor:
            continue
        z = _sureness(found, residuals, channel, kind, fits)
        if z > judging.sure_above:
            held_out = [each for each in residuals if each.held_out]
            where = _where(held_out, kind, equations.layout.rows[kind], found.model.criteria)
            result.append(Excess(channel, unit_of(channel, equations.robot), rmse, floor, z, where))
    return tuple(sorted(result, key=lambda each: -each.rmse / each.noise_floor))


def seen(equations: Equations, found: Identification) -> tuple[Seen, ...]:
    """Every channel that was looked at on logs that were not fitted; none where none was held out."""
    result = []
    for channel in all_channels(equations).values():
        fits = [fit for fit in found.validation if fit.channel == channel]
        held_out = [fit for fit in fits if fit.held_out]
        if held_out:
            rmse, floor = pooled(held_out)
            ratio = rmse / floor if floor > 0.0 else float("nan")
            steady_s, moved_s = sum(fit.steady_s for fit in held_out), sum(fit.moved_s for fit in fits)
            result.append(Seen(channel, ratio, steady_s, moved_s))
    return tuple(result)


def all_channels(equations: Equations) -> dict[int, str]:
    """Kind of row -> channel: those of `channels`, and on a floating robot the wrench on its base."""
    every = (RowType.BASE, RowType.AXIS, RowType.SENSOR)
    return {kind: channel_of_row(equations.robot, kind) for kind in equations.layout.numbers(*every)}


def channels(equations: Equations) -> dict[int, str]:
    """Kind of row -> channel of joint torques and of the sensors that carry bodies."""
    told = equations.layout.numbers(RowType.AXIS, RowType.SENSOR)
    return {kind: channel_of_row(equations.robot, kind) for kind in told}


def pooled(fits: Sequence[ChannelFit]) -> tuple[float, float]:
    """RMSE in steady motion and noise floor over several logs; NaN where no log has any."""
    moving = [(fit.rmse_moving, fit.noise_floor) for fit in fits if fit.rmse_moving is not None]
    if not moving:
        return float("nan"), float("nan")
    rmse, floor = np.array(moving).T
    return float(np.sqrt(np.mean(rmse**2))), float(np.sqrt(np.mean(floor**2)))


def _sureness(
    found: Identification, residuals: Sequence[LogResiduals], channel: str, kind: int, fits: Sequence[ChannelFit]
) -> float:
    """Standard errors by which the mean square error of the rows stands above what noise alone would leave in as many.

    Of noise, and not of the error itself: one jolt that stands far above all would make that as large as the mean.
    """
    resolved = 1e-9  # of the largest error: a lower floor is that of rounding
    criteria = found.model.criteria.search
    floor: Mapping[str, float] = {fit.log: fit.noise_floor for fit in fits}
    predictions = {prediction.log: prediction for prediction in found.predictions}
    relative: list[Array] = []
    for each in residuals:
        if not each.held_out or each.log not in floor or kind not in each.residual:
            continue
        prediction, told = predictions[each.log], predictions[each.log].channels()
        time = prediction.time - prediction.time[0]
        at = np.searchsorted(time, each.time[np.isfinite(each.residual[kind])])
        error = (told.measured[channel] - told.predicted[channel])[np.minimum(at, len(time) - 1)]
        least = resolved * float(np.max(np.abs(error), initial=1e-300))
        relative.append((error / max(floor[each.log], least)) ** 2)
    squares = np.concatenate(relative) if relative else np.zeros(0)
    if len(squares) < criteria.told_rows:
        return 0.0
    independent = len(squares) / criteria.row_memory
    return float((squares.mean() - 1.0) / np.sqrt(2.0 / independent))


def _where(residuals: Sequence[LogResiduals], kind: int, row: Row, criteria: Criteria) -> Concentration:
    """The few moments that hold most of the error; or else the third of times, and for an axis of speeds, loads or
    positions, in which it is largest."""
    known = [each for each in residuals if kind in each.residual]
    moments = _moments(known, kind, criteria)
    if moments:
        return Concentration(moments)
    e = np.concatenate([each.residual[kind] for each in known])
    used = np.isfinite(e)
    if used.sum() < 30:
        return THROUGHOUT
    square = e[used] ** 2
    over: dict[Coordinate, tuple[Array, str]] = {"time": (np.concatenate([each.time for each in known])[used], "s")}
    if row.type == RowType.AXIS:

        def of_axis(name: str) -> Array:
            return np.asarray(np.concatenate([getattr(each.axes[row.place], name) for each in known])[used])

        over |= {
            "speed": (np.abs(of_axis("velocity")), "rad/s"),
            "position": (of_axis("position"), "rad"),
            "load": (np.abs(of_axis("load")), "N·m"),
        }
    best, found = criteria.search.part, THROUGHOUT
    for name, (values, unit) in over.items():
        low, high = (float(end) for end in np.quantile(values, [1 / 3, 2 / 3]))
        for above, at, part in ((False, low, values <= low), (True, high, values >= high)):
            if part.any() and square[part].mean() / square.mean() > best:
                best, found = float(square[part].mean() / square.mean()), Concentration((), name, above, at, unit)
    return found


def _moments(residuals: Sequence[LogResiduals], kind: int, criteria: Criteria) -> tuple[tuple[str, float], ...]:
    """(log, [s]) of the few blocks that hold most of it; none where the error is spread wider."""
    block_s, shares = criteria.judging.block_s, criteria.search
    blocks: list[tuple[float, tuple[str, float]]] = []
    for each in residuals:
        square = each.residual[kind] ** 2
        used = np.isfinite(square)
        starts, number = np.unique(np.floor(each.time[used] / block_s), return_inverse=True)
        at = [(each.log, float(start * block_s)) for start in starts]
        blocks += zip(np.bincount(number, square[used]).tolist(), at, strict=True)
    blocks.sort(reverse=True)
    held = np.cumsum([total for total, _ in blocks])
    needed = int(np.searchsorted(held, shares.of_moments * held[-1])) + 1 if blocks else 0
    return tuple(at for _, at in blocks[:needed]) if needed <= shares.moments * len(blocks) else ()
