"""What stands above the sensors' noise, and no further than the declared uncertainties of the measurement let it stand.

Noise that is stronger at low frequencies than where it is seen counts with them: the floor takes it for white.
A foot's zero of 2 N that robot.yaml declares leaves 2 N in the base's rows: no effect is missing there, and none can be
seen that is smaller. The declared inputs are fitted to the held-out residuals, with what is declared as their prior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.bounded_arrow import Block, solve_bounded
from exogauge.findings.result import Excess, WithinDeclared
from exogauge.identification.disturbances import (
    ZERO,
    common_columns,
    drift_columns,
    zero_columns,
    zeros_in_doubt,
)
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import DRIVE, wrench_channels
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording
from exogauge.logs.noise_colour import hidden_noise
from exogauge.robots.description import drifts_in_doubt
from exogauge.robots.rows import RowType
from exogauge.search.baseline import LogResiduals
from exogauge.search.locate import all_channels, located
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

COLOUR = "noise_colour"  # beside the kinds of declared inputs


@final
@dataclass(frozen=True)
class _Sums:
    """Of rows of one kind in one log. C: (n, K) what K of the inputs put into their residual e per standard deviation;
    the others put nothing.

    columns: (K,) of the inputs. own: (K, K) Σ CᵀC. with_residual: (K,) Σ Cᵀe. square: Σ e².
    """

    columns: IntArray
    own: Array
    with_residual: Array
    square: float

    def with_rows(self, more: _Sums) -> _Sums:
        return _Sums(
            self.columns, self.own + more.own, self.with_residual + more.with_residual, self.square + more.square
        )

    def left(self, inputs: Array) -> float:
        """Σ (e - C u)². inputs: of all."""
        u = inputs[self.columns]
        return float(self.square - 2.0 * u @ self.with_residual + u @ self.own @ u)

    def done_by(self, inputs: Array) -> float:
        """Σ (C u)²."""
        return float(inputs[self.columns] @ self.own @ inputs[self.columns])


def within_declared(model: RobotModel, recordings: Sequence[Recording], excesses: Sequence[Excess]) -> WithinDeclared:
    """Those channels that stand at their floors once the declared inputs are what suits the held-out logs best."""
    held_out = [each for each in recordings if each.held_out]
    if not excesses or not held_out:
        return WithinDeclared()
    hidden = _hidden_noise(model, recordings)
    coloured = [each for each in excesses if not _above(model, each, each.rmse, hidden)]
    others = _within_inputs(model, held_out, [each for each in excesses if each not in coloured], hidden)
    sources = (*others.sources, *([COLOUR] if coloured else []))
    return WithinDeclared(tuple(each for each in excesses if each in (*coloured, *others.channels)), sources)


def left_over(
    found: Identification,
    residuals: Sequence[LogResiduals],
    recordings: Sequence[Recording],
    joined: Set[str] = frozenset(),
) -> tuple[tuple[Excess, ...], WithinDeclared]:
    """What stands above the noise on held-out logs and is unexplained; and what declared uncertainties explain. joined:
    logs that were held out until something was found by fitting them, looked at where no other is held out."""
    held_out = any(each.held_out for each in recordings)
    above = located(found.model.equations, found, residuals, None if held_out else joined)
    declared = within_declared(found.model, recordings, above)
    return tuple(each for each in above if each not in declared.channels), declared


def explained(
    found: Identification, residuals: Sequence[LogResiduals], recordings: Sequence[Recording], logs: Set[str]
) -> Mapping[str, bool]:
    """Channels that stand above their noise in these logs, and whether declared inputs explain all of that. Noise of
    whatever colour is not foretold on logs that were not fitted, and counts for nothing."""
    there = located(found.model.equations, found, residuals, logs)
    shown = [each for each in recordings if each.log.name in logs]
    within = _within_inputs(found.model, shown, there, {}) if shown else WithinDeclared()
    return {each.channel: each in within.channels for each in there}


def _above(model: RobotModel, excess: Excess, rmse: float, hidden: Mapping[str, float]) -> bool:
    floor = np.hypot(excess.noise_floor, hidden.get(excess.channel, 0.0))
    return bool(rmse >= model.criteria.judging.above * floor)


def _hidden_noise(model: RobotModel, recordings: Sequence[Recording]) -> Mapping[str, float]:
    """Channel -> noise of what was measured there [N, N·m] that its floor lacks, as it takes noise for white."""
    robot, gains, names = model.robot, dict[str, float](), dict[str, str]()
    for joint, k_T in zip(robot.joints, model.k_T, strict=True):
        if joint.actuation != "none":
            names[f"tau.{joint.name}"] = f"{DRIVE[joint.actuation]}.{joint.name}"
            gains[f"tau.{joint.name}"] = float(k_T)
    for cut in robot.cuts:
        for name in wrench_channels(cut.name):
            names[name], gains[name] = name, 1.0
    logs = [each.log for each in recordings]
    found = hidden_noise(logs, tuple(names.values()), model.cutoff_hz, model.criteria.judging)
    return {channel: abs(gains[channel]) * float(std) for channel, std in zip(names, found, strict=True)}


def _within_inputs(
    model: RobotModel, held_out: Sequence[Recording], excesses: Sequence[Excess], hidden: Mapping[str, float]
) -> WithinDeclared:
    if not excesses or not any(map(len, _sizes(model))):
        return WithinDeclared()
    logs = list(side_by_side(lambda each: _of_log(model, each), held_out))
    inputs = _best(model, logs)
    kinds, within = {channel: kind for kind, channel in all_channels(model.equations).items()}, list[Excess]()
    for excess in excesses:
        sums = [(number, log[kinds[excess.channel]]) for number, log in enumerate(logs) if kinds[excess.channel] in log]
        before = sum((each.square for _, each in sums), 1e-300)
        after = sum(each.left(inputs[number]) for number, each in sums)
        if not _above(model, excess, excess.rmse * float(np.sqrt(max(after, 0.0) / before)), hidden):
            within.append(excess)
    return WithinDeclared(tuple(within), _sources(model, logs, inputs) if within else ())


def _sources(model: RobotModel, logs: Sequence[Mapping[int, _Sums]], inputs: Array) -> tuple[str, ...]:
    """Kinds of inputs that do a part worth telling of what all of them do to the residuals, what does most first."""
    zeros = len(_sizes(model)[0]) - len(model.inputs.names)
    names = [each.partition(".")[0] for each in model.inputs.names] + [ZERO] * 2 * zeros
    for drift, size in drifts_in_doubt(model.robot).items():
        names += [drift] * len(size)
    done = dict.fromkeys(names, 0.0)
    for name in done:
        for u, log in zip(np.where(np.array(names) == name, inputs, 0.0), logs, strict=True):
            done[name] += sum(float(model.solution.weights[kind]) * each.done_by(u) for kind, each in log.items())
    told = [name for name in done if done[name] >= model.criteria.judging.declared_told * sum(done.values())]
    return tuple(sorted(told, key=lambda name: -done[name]))


def _sizes(model: RobotModel) -> tuple[Array, Array]:
    """Standard deviations of what all logs share, zeros among it, and of what is another in each log."""
    zeros = zeros_in_doubt(model.robot)
    zeros = zeros if zeros.any() else np.zeros(0)
    motors = list(drifts_in_doubt(model.robot).values())
    return np.concatenate([model.inputs.std, zeros]), np.concatenate([zeros, *motors])


def _of_log(model: RobotModel, recording: Recording) -> Mapping[int, _Sums]:
    """By kind of row: what is declared, with what it did to the robot, e = -(c + A V) θ."""
    equations, prepared = model.equations, model.prepare(recording.log)
    x, layout, kept = model.solution.unbounded.x, equations.layout, prepared.kept
    phi = model.solution.solved.x[: equations.base_size]
    common, zeros = (
        common_columns(equations, prepared, kept, model.cutoff_hz, phi),
        zero_columns(equations, prepared, kept),
    )
    columns = drift_columns(equations, model.identified.xi, prepared, kept)
    drifts = [columns[name] for name in drifts_in_doubt(model.robot)]
    at_rest, axes = layout.numbers(RowType.AT_REST), layout.told.axes
    shared, own = _sizes(model)
    moved = np.hstack([model.inputs.moved, model.inputs.moved_by_zeros])
    every, A = np.concatenate([shared, own]), len(equations.robot.joints)
    Z, sums = zeros.shape[1], dict[int, _Sums]()
    for _, chunks in equations.rows(prepared, x):
        for chunk in chunks:
            if chunk.kind in at_rest:
                continue
            (told,), row = layout.in_told([chunk.kind]), layout.rows[chunk.kind]
            zero = zeros[chunk.samples, :, told] if told < axes.stop else np.zeros((len(chunk.samples), Z))
            alike = np.hstack([common[chunk.samples, :, told], zero]) + chunk.block[:, :-1] @ moved[chunk.columns]
            live, motors = np.arange(len(shared) + Z), list[Array]()
            if row.type == RowType.AXIS:
                live = np.concatenate([live, len(shared) + Z + row.place + A * np.arange(len(drifts))])
                motors = [drift[chunk.samples, row.place, None] for drift in drifts]
            C, e = -np.hstack([alike, zero, *motors]) * every[live], chunk.residual(x)
            new, old = _Sums(live, C.T @ C, C.T @ e, float(e @ e)), sums.get(chunk.kind)
            sums[chunk.kind] = new if old is None else old.with_rows(new)
    return sums


def _best(model: RobotModel, logs: Sequence[Mapping[int, _Sums]]) -> Array:
    """(logs, K) of the inputs, in standard deviations: weighted least squares beside a prior of one each, none further
    from none than is declared."""
    S, L = (len(each) for each in _sizes(model))
    weights, shared, g, blocks = model.solution.weights, np.eye(S), np.zeros(S), list[Block]()
    for log in logs:
        H, right = np.zeros((S + L, S + L)), np.zeros(S + L)
        for kind, each in log.items():
            H[np.ix_(each.columns, each.columns)] += weights[kind] * each.own
            right[each.columns] += weights[kind] * each.with_residual
        shared += H[:S, :S]
        g += right[:S]
        blocks.append(Block(H[S:, S:] + np.eye(L), H[:S, S:], right[S:]))
    alike, own = solve_bounded(shared, g, blocks, model.criteria.judging.declared_most)
    return np.stack([np.concatenate([alike, each]) for each in own])
