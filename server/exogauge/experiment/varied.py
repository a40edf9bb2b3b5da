"""Motions that are changed a little again and again, as long as they keep their bounds and tell more a second."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.planning import Planning
from exogauge.experiment.motion_choices import Choice, price_of, slowest_of
from exogauge.experiment.moving_choices import Moving
from exogauge.experiment.workspace_limits import Room
from exogauge.findings.planned_motion import Sweep
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]
Weighed = TypeVar("Weighed")


def climbed(
    begin: Weighed, changed: Callable[[Weighed, np.random.Generator, float], Weighed | None],
    worth: Callable[[Weighed], tuple[int, float]], criteria: Planning, times: int,
) -> Weighed:  # fmt: skip
    """The best that is met when what is best so far is changed, `times` at most, by more after each
    success and by less after each failure (Rechenberg, Evolutionsstrategie, 1973: one in five), until that is little.
    """
    rng, size, best, most = np.random.default_rng(0), criteria.change, begin, worth(begin)
    for _ in range(times):
        made = changed(best, rng, size)
        if made is not None and worth(made) > most:
            best, most, size = made, worth(made), size * np.exp(0.8)
        else:
            size *= np.exp(-0.2)
        if size < criteria.least_change:
            break
    return best


def nearby(
    choice: Choice | Moving, rng: np.random.Generator, size: float, model: RobotModel, room: Room
) -> Choice | Moving | None:
    """size: of the change, 1 is as large as the motion is; None where no such motion is left."""
    if isinstance(choice, Choice):
        return _swept(choice, rng, size, model, room)
    swept = None if choice.swept is None else _swept(choice.swept, rng, size, model, room)
    if choice.swept is not None and swept is None:
        return None
    return replace(choice, x=_moved(choice, rng, size), swept=swept)


def _swept(choice: Choice, rng: np.random.Generator, size: float, model: RobotModel, room: Room) -> Choice | None:
    criteria, lead, sweep = model.criteria.planning, choice.lead, choice.sweep
    low, high, top = float(room.low[lead]), float(room.high[lead]), float(room.top_speed[lead])
    n = size * rng.standard_normal(4)
    amplitude = float(np.clip(sweep.amplitude * np.exp(n[0]), criteria.least_way, 0.49 * (high - low)))
    offset = float(np.clip(sweep.offset + n[1] * sweep.amplitude, low + amplitude, high - amplitude))
    least = slowest_of(model, room, lead)
    match sweep.kind:
        case "sine":
            shortest = max(2.0 * np.pi * amplitude / top, criteria.least_period_s)
            period = max(float(sweep.period * np.exp(n[2])), shortest)
            if period > sweep.seconds:
                return None
            made = replace(
                sweep, amplitude=amplitude, offset=offset, period=period, fastest=2.0 * np.pi * amplitude / period
            )
        case "speeds":
            ends = np.clip(np.array([sweep.slowest, sweep.fastest]) * np.exp(2.0 * n[2:]), least, top)
            made = replace(
                sweep, amplitude=amplitude, offset=offset, slowest=float(ends.min()), fastest=float(ends.max())
            )
        case "small":
            made = Sweep.small(offset, amplitude, max(float(sweep.slowest * np.exp(2.0 * n[2])), least))
    price = price_of(criteria, room, lead, made) * (1.0 if choice.companion is None else criteria.beside)
    return replace(choice, sweep=made, price=price)


def _moved(choice: Moving, rng: np.random.Generator, size: float) -> Array:
    """x with one coordinate's waves larger or smaller, otherwise made up, and elsewhere."""
    x, reach = choice.x.copy(), choice.reach
    one = int(rng.integers(len(x)))
    waves = x[one, :-1]
    usual = float(np.sqrt(np.mean(waves**2))) or 1e-3 * float(reach.sizes[one, 0])
    x[one, :-1] = waves * np.exp(size * rng.standard_normal()) + size * usual * rng.standard_normal(len(waves))
    x[one, -1] += size * rng.standard_normal() * float(np.ptp(reach.series.motion(x[[one]], reach.time)[0]))
    return x
