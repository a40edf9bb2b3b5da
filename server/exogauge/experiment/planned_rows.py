"""What a motion that nobody has recorded yet would say: its rows, by the model's own regressor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.experiment.felt import felt_channels
from exogauge.experiment.motion_choices import Choice
from exogauge.experiment.moving_choices import Moving
from exogauge.experiment.workspace_limits import Room
from exogauge.identification.axis_signals import loads
from exogauge.identification.model import RobotModel
from exogauge.identification.per_log import PerLog
from exogauge.identification.preparation import Prepared
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.search.ambiguity import Contender, Number, Undecided

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

NAME = "planned"


@final
@dataclass(frozen=True)
class NewRows:
    """What one repeat of a motion adds, each row in units of its noise. A: (n, R) in the parameters in question.
    c: (n, C) columns of all contenders. seconds: of one repeat."""

    A: Array
    c: Array
    seconds: float


def with_next_log(model: RobotModel) -> RobotModel:
    """The same model, for which the planned log comes after all others."""
    order = {**model.order, NAME: max(model.order.values(), default=-1) + 1}
    extension = model.extension
    if extension is not None:
        extension = replace(extension, parent=_for_one_log(extension.parent, order))
    return replace(_for_one_log(model, order), extension=extension)


def _for_one_log(model: RobotModel, order: Mapping[str, int]) -> RobotModel:
    """Planned logs are asked for once: little need be kept of one for the next."""
    one_log = 50_000_000  # bytes: of a planned log, prepared
    return replace(model, order=order, prepared=PerLog(one_log), computed=PerLog(one_log), attached=PerLog(one_log))


def new_rows(
    doubt: Undecided, model: RobotModel, room: Room, choice: Choice | Moving, kept: IntArray
) -> NewRows | None:
    """model: as `with_next_log` makes it. kept: (R,) parameters in question. None where a motor could not bear it."""
    log = as_log(model, room, choice)
    prepared = model.prepare(log)
    if len(prepared.kept) < 2 or _too_heavy(model, choice, _loads(model, prepared)):
        return None
    columns = [_columns(each, model, prepared) if isinstance(each, Contender) else {} for each in doubt.contenders]
    kinds = sorted({kind for each in doubt.contenders for kind in each.kinds(model.equations)})
    most, fewest = 160, 40  # rows of a motion that are computed and stand for the others; samples, of many kinds
    samples = prepared.kept[:: -(-len(prepared.kept) // max(most // len(kinds), fewest))]
    share = _kept_rate(model, room) * (log.samples / log.rate_hz) / len(samples)  # of the rows that a log would have
    place = np.full(model.equations.size, -1, dtype=np.intp)
    place[kept] = np.arange(len(kept))
    root = np.sqrt(share * _weights(model))
    A, c = [np.zeros((0, len(kept)))], [np.zeros((0, sum(each.width for each in doubt.contenders)))]
    x = model.solution.unbounded.x
    for _, chunks in model.equations.rows(replace(prepared, kept=samples), x):
        for chunk in (each for each in chunks if each.kind in kinds):
            known, at = place[chunk.columns], samples[chunk.samples]
            block = np.zeros((len(at), len(kept)))
            block[:, known[known >= 0]] = chunk.block[:, :-1][:, known >= 0]
            beside = [
                each.of_rows(chunk.columns, chunk.block, x)
                if isinstance(each, Number)
                else known_of[chunk.kind][at]
                if chunk.kind in known_of
                else np.zeros((len(at), each.width))
                for each, known_of in zip(doubt.contenders, columns, strict=True)
            ]
            A.append(root[chunk.kind] * block)
            c.append(root[chunk.kind] * np.concatenate(beside, axis=1))
    return NewRows(np.concatenate(A), np.concatenate(c), log.samples / log.rate_hz)


def as_log(model: RobotModel, room: Room, choice: Choice | Moving, rate_hz: float | None = None) -> Log:
    """Positions of one repeat, everything else as it is while nothing moves."""
    rate = rate_hz or _rate(model, room, choice)
    if isinstance(choice, Moving):
        motion = choice.reach.motion(choice.whole(rate))
        channels = {name: np.full(motion.samples, value) for name, value in room.resting.items()}
        loads = choice.reach.loads(motion)
        carried = loads if choice.reach.stance.robot.floating else loads[:, :0]
        channels |= felt_channels(model.robot, motion, carried)
        return Log(NAME, np.arange(motion.samples) / rate, channels)
    q = choice.positions(room.posture, rate)
    channels = {name: np.full(len(q), value) for name, value in room.resting.items()}
    channels |= {f"q.{joint.name}": q[:, j] for j, joint in enumerate(model.robot.joints)}
    return Log(NAME, np.arange(len(q)) / rate, channels)


def _columns(contender: Contender, model: RobotModel, prepared: Prepared) -> dict[int, Array]:
    """Kind -> (T, width) what the contender does to rows of it."""
    site = contender.candidate.site
    seen = site.see(model, prepared)
    every = contender.columns(seen, prepared.low_pass)
    return {kind: every[:, :, place] for place, kind in enumerate(site.kinds(model.equations))}


def _loads(model: RobotModel, prepared: Prepared) -> Array:
    """As `loads`, in between of every few samples; where `loads` will find them."""
    apart = 4  # samples between those whose loads are computed; they change slowly
    some, time = slice(None, None, apart), prepared.log.time
    thin = replace(
        prepared,
        log=Log(f"{NAME}, thinned", time[some], {}),
        motion=prepared.motion.rows(some),
        wrenches=prepared.wrenches[some],
    )
    few = loads(model, thin)
    load = np.column_stack([np.interp(time, time[some], axis) for axis in few.T])
    return model.computed.put(prepared.log, "load", load)


def _rate(model: RobotModel, room: Room, choice: Choice | Moving) -> float:
    """[Hz] a whole fraction of the logs' rate, as low as the filters bear."""
    minutes = isinstance(choice, Choice) and choice.sweep.seconds > 100.0
    times, least = (4.0, 20.0) if minutes else (6.0, 40.0)  # of the cut-off, and [Hz]
    return room.rate_hz / max(1, int(room.rate_hz / max(times * model.cutoff_hz, least)))


def _weights(model: RobotModel) -> Array:
    """(rows,) 1/variance of each kind of row. An axis that never moved in the logs has none: it counts as much as the
    worst that did, or a motion of more than the joint in question would tell nothing."""
    weights, axes = model.solution.weights.copy(), np.zeros(len(model.solution.weights), dtype=bool)
    axes[model.equations.layout.axes] = True
    unseen = axes & (weights <= 0.0)
    if unseen.any() and (axes & ~unseen).any():
        weights[unseen] = weights[axes & ~unseen].min()
    return weights


def _kept_rate(model: RobotModel, room: Room) -> float:
    """[Hz] at which samples of the logs are kept."""
    return room.rate_hz / LowPass(model.cutoff_hz, room.rate_hz).decimation()


def _too_heavy(model: RobotModel, choice: Choice | Moving, load: Array) -> bool:
    limit = model.criteria.planning.of_top * model.robot.tree.effort_limit
    moved: Sequence[int] = range(load.shape[1])
    if isinstance(choice, Choice):
        moved = [each for each in (choice.lead, choice.companion) if each is not None]
    return any(float(np.abs(load[:, joint]).max()) > limit[joint] for joint in moved)
