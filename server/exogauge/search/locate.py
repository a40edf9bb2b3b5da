"""Which channels are off by more than their sensors' noise, on logs that were not fitted, and where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.searching import Searching
from exogauge.findings.result import THROUGHOUT, Concentration, Coordinate, Excess
from exogauge.findings.verdict import Seen
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import channel_of_row
from exogauge.identification.result import ChannelFit, Identification
from exogauge.identification.validate import unit_of
from exogauge.robots.parameters import unit_at
from exogauge.robots.rows import RowType
from exogauge.search.baseline import LogResiduals

Array = NDArray[np.float64]


def located(
    equations: Equations, found: Identification, residuals: Sequence[LogResiduals], logs: Set[str] | None = None
) -> tuple[Excess, ...]:
    """Channels whose error in these logs, the held-out ones if not otherwise said, stands above the noise floor in
    steady motion; largest ratio first."""
    logs = {each.log for each in residuals if each.held_out} if logs is None else logs
    shown, judging = [each for each in residuals if each.log in logs], found.model.criteria.judging
    above = dict[int, tuple[str, float, float]]()
    for kind, channel in all_channels(equations).items():
        rmse, floor = pooled([fit for fit in found.validation if fit.log in logs and fit.channel == channel])
        if np.isfinite(rmse) and rmse >= judging.above * floor:
            above[kind] = channel, rmse, floor
    sure = _sureness(found, shown, {kind: channel for kind, (channel, _, _) in above.items()})
    result = [
        Excess(channel, unit_of(channel, equations.robot), rmse, floor, sure[kind],
               _where(shown, residuals, kind, equations, found.model.criteria))
        for kind, (channel, rmse, floor) in above.items()
        if sure[kind] > judging.sure_above
    ]  # fmt: skip
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
    found: Identification, residuals: Sequence[LogResiduals], channels: Mapping[int, str]
) -> Mapping[int, float]:
    """Kind -> standard errors by which the mean square error of the rows stands above what noise alone would leave in
    as many. channels: kind -> channel, of those that are asked for.

    Of noise, and not of the error itself: one jolt that stands far above all would make that as large as the mean.
    """
    resolved = 1e-9  # of the largest error: a lower floor is that of rounding
    criteria = found.model.criteria.search
    floors = {(fit.log, fit.channel): fit.noise_floor for fit in found.validation}
    predictions = {prediction.log: prediction for prediction in found.predictions}
    relative: dict[int, list[Array]] = {kind: [] for kind in channels}
    for each in residuals:
        asked = {kind: name for kind, name in channels.items() if (each.log, name) in floors and kind in each.residual}
        if not asked:
            continue
        prediction, told = predictions[each.log], predictions[each.log].channels()  # computed anew when asked for
        time = prediction.time - prediction.time[0]
        for kind, name in asked.items():
            at = np.searchsorted(time, each.time[np.isfinite(each.residual[kind])])
            error = (told.measured[name] - told.predicted[name])[np.minimum(at, len(time) - 1)]
            least = resolved * float(np.max(np.abs(error), initial=1e-300))
            relative[kind].append((error / max(floors[each.log, name], least)) ** 2)
    return {kind: _above_noise(np.concatenate(parts or [np.zeros(0)]), criteria) for kind, parts in relative.items()}


def _above_noise(squares: Array, criteria: Searching) -> float:
    """squares: (n,) of errors, in units of their noise."""
    if len(squares) < criteria.told_rows:
        return 0.0
    independent = len(squares) / criteria.row_memory
    return float((squares.mean() - 1.0) / np.sqrt(2.0 / independent))


def _where(
    shown: Sequence[LogResiduals],
    every: Sequence[LogResiduals],
    kind: int,
    equations: Equations,
    criteria: Criteria,
) -> Concentration:
    """The few moments that hold most of the error; or else the third of times, and for an axis of speeds, loads or
    positions, in which it is largest, and those of `every` log in which it is."""
    known = [each for each in shown if kind in each.residual]
    moments = _moments(known, kind, criteria)
    if moments:
        return Concentration(moments)
    e = np.concatenate([each.residual[kind] for each in known])
    used = np.isfinite(e)
    if used.sum() < 30:
        return THROUGHOUT
    square, row = e[used] ** 2, equations.layout.rows[kind]
    over: dict[Coordinate, tuple[Array, str]] = {"time": (np.concatenate([each.time for each in known])[used], "s")}
    if row.type == RowType.AXIS:

        def of_axis(name: str) -> Array:
            return np.asarray(np.concatenate([getattr(each.axes[row.place], name) for each in known])[used])

        told: dict[Coordinate, tuple[Array, str]] = {
            "speed": (np.abs(of_axis("velocity")), "rad/s"),
            "position": (of_axis("position"), "rad"),
            "load": (np.abs(of_axis("load")), "N·m"),
        }
        tree, joint = equations.robot.tree, equations.robot.joints[row.place].name
        over |= {name: (values, unit_at(tree, joint, unit)) for name, (values, unit) in told.items()}
    best, found = criteria.search.part, THROUGHOUT
    for name, (values, unit) in over.items():
        low, high = (float(end) for end in np.quantile(values, [1 / 3, 2 / 3]))
        for above, at, part in ((False, low, values <= low), (True, high, values >= high)):
            if part.any() and square[part].mean() / square.mean() > best:
                best, found = float(square[part].mean() / square.mean()), Concentration((), name, above, at, unit)
    logs, times = _most_of_all(every, kind, criteria.search.part)
    return replace(found, logs=logs, times=times) if logs else found


def _most_of_all(residuals: Sequence[LogResiduals], kind: int, part: float) -> tuple[tuple[str, ...], float]:
    """Logs whose mean square error is `part` times that of all together, largest first, and how many times its root is
    in the first."""
    e = {each.log: each.residual[kind] for each in residuals if kind in each.residual}
    squares = {log: own[np.isfinite(own)] ** 2 for log, own in e.items()}
    every = float(np.concatenate(list(squares.values())).mean())
    means = {log: float(own.mean()) / every for log, own in squares.items() if own.size}
    logs = sorted((log for log, mean in means.items() if mean > part), key=lambda log: -means[log])
    return tuple(logs), float(np.sqrt(means[logs[0]])) if logs else 1.0


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
