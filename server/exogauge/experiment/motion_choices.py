"""The motions that are considered when one is planned: a joint swept over several ranges and speeds, alone or beside
another one that changes its load."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.planning import Planning
from exogauge.experiment.workspace_limits import Room
from exogauge.findings.planned_motion import Sweep
from exogauge.identification.model import RobotModel
from exogauge.robots.motion import Motion

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Choice:
    """sweep: of joint `lead`. companion: joint that moves slowly over `companion_range`, or None.

    price: by which its time is multiplied when choices are compared and not every bound is known: what leaves the
    range or speed of the logs, or moves two joints, costs more.
    """

    lead: int
    sweep: Sweep
    companion: int | None
    companion_range: tuple[float, float]
    price: float

    def positions(self, posture: Array, rate_hz: float) -> Array:
        """(T, J) of one repeat."""
        lead = self.sweep.position(rate_hz)
        q = np.tile(posture, (len(lead), 1))
        q[:, self.lead] = lead
        if self.companion is not None:
            low, high = self.companion_range
            turn = 2.0 * np.pi * np.arange(len(lead)) / len(lead)
            q[:, self.companion] = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(turn)
        return q


def choices(
    model: RobotModel, room: Room, kinds: Sequence[int], swept: Sequence[int], slow_change: bool
) -> list[Choice]:
    """kinds: of the rows that show what is in question. swept: axes where it sits; none where it is no effect on one.
    slow_change: whether one of them needs minutes."""
    criteria = model.criteria.planning
    felt = _felt(model, room, kinds)
    by_weight = [int(joint) for joint in np.argsort(-felt) if felt[joint] > 0.0]
    leads = list(dict.fromkeys(swept)) or by_weight[: criteria.leads]
    found: list[Choice] = []
    for lead in leads:
        if room.free[lead]:
            beside = [joint for joint in by_weight if joint != lead][: criteria.companions]
            found += _of(model, room, lead, beside, slow_change)
    return found


def _of(model: RobotModel, room: Room, lead: int, beside: Sequence[int], slow_change: bool) -> Iterator[Choice]:
    criteria = model.criteria.planning
    usual, top = float(room.seen_speed[lead]), float(room.top_speed[lead])
    slowest = slowest_of(model, room, lead)
    if not slowest < 0.5 * usual:
        return
    seen, wide = _span(room.seen_low[lead], room.seen_high[lead]), _span(room.low[lead], room.high[lead])
    wider = wide[1] > criteria.far * seen[1]
    faster = top > criteria.far * usual
    alone: list[Sweep | None] = []
    for offset, size in (seen, *((wide,) if wider else ())):
        alone += [
            _speeds(criteria, offset, size, slowest, usual),
            _speeds(criteria, offset, size, slowest, 0.25 * usual),
            _sine(criteria, offset, size, usual),
            _small(criteria, offset, size, slowest),
        ]
        if faster:
            alone += [_speeds(criteria, offset, size, slowest, top), _sine(criteria, offset, size, top)]
    alone += [_speeds(criteria, wide[0] + side * 0.5 * wide[1], 0.5 * wide[1], slowest, usual) for side in (-1.0, 1.0)]
    if slow_change:
        minutes = 300.0
        alone += [_sine(criteria, *seen, usual, minutes), _speeds(criteria, *seen, slowest, usual, minutes)]
    for sweep in alone:
        if sweep is not None:
            yield Choice(lead, sweep, None, (0.0, 0.0), price_of(criteria, room, lead, sweep))
    for other in beside:
        span = (float(room.seen_low[other]), float(room.seen_high[other]))
        pairs = [_speeds(criteria, *seen, slowest, usual), _sine(criteria, *seen, usual)]
        if other == beside[0] and (wider or faster):
            pairs += [_speeds(criteria, *wide, slowest, top)]
        for sweep in pairs:
            if sweep is not None and span[1] - span[0] > criteria.least_way:
                yield Choice(lead, sweep, other, span, criteria.beside * price_of(criteria, room, lead, sweep))


def price_of(criteria: Planning, room: Room, lead: int, sweep: Sweep) -> float:
    """Of one joint's sweep, as of `Choice`."""
    middle, half = _span(room.seen_low[lead], room.seen_high[lead])
    wider = abs(sweep.offset - middle) + sweep.amplitude > criteria.far * half
    faster = sweep.fastest > criteria.far * room.seen_speed[lead]
    return (criteria.wider if wider else 1.0) * (criteria.faster if faster else 1.0)


def slowest_of(model: RobotModel, room: Room, lead: int) -> float:
    """[rad/s or m/s] below which no motion of a joint is asked for."""
    criteria = model.criteria.planning
    return max(criteria.slow * float(model.at_rest.threshold[lead]), criteria.slow_share * float(room.seen_speed[lead]))


def _span(low: float, high: float) -> tuple[float, float]:
    """Middle, and how far to either side."""
    return 0.5 * float(low + high), 0.49 * float(high - low)


def _speeds(
    criteria: Planning, offset: float, size: float, slowest: float, fastest: float, seconds: float = 1.0
) -> Sweep | None:
    if size < criteria.least_way or fastest < 2.0 * slowest:
        return None
    return Sweep("speeds", size, offset, slowest, fastest, seconds)


def _sine(criteria: Planning, offset: float, size: float, fastest: float, seconds: float = 20.0) -> Sweep | None:
    period = max(2.0 * np.pi * size / max(fastest, 1e-9), criteria.least_period_s)
    if size < criteria.least_way or period > seconds:
        return None
    return Sweep("sine", size, offset, 0.0, 2.0 * np.pi * size / period, seconds, period)


def _small(criteria: Planning, offset: float, size: float, slowest: float) -> Sweep | None:
    return Sweep.small(offset, size, slowest) if size >= criteria.least_way else None


def _felt(model: RobotModel, room: Room, kinds: Sequence[int]) -> Array:
    """(J,) how much the rows of these kinds change, in their own noise, when each joint is posed from end to end of
    what the logs hold; 0 for joints that carry the robot."""
    equations, joints = model.equations, len(room.posture)
    q = np.tile(room.posture, (3 * joints, 1))
    for joint in range(joints):
        span = (room.seen_low[joint], room.posture[joint], room.seen_high[joint])
        q[3 * joint : 3 * joint + 3, joint] = span
    still, n = np.zeros_like(q), np.zeros((len(q), 3))
    upwards = np.array([0.0, 0.0, 9.81])
    if model.robot.T_base_imu is not None:
        upwards = model.robot.T_base_imu.rotation @ np.array([room.resting[f"acc.{axis}"] for axis in "xyz"])
    motion = Motion(q, still, still, np.tile(upwards, (len(q), 1)), n, n)
    rows = equations.of_bodies(motion, equations.base.regroup @ model.identified.phi.ravel())
    told = rows[:, equations.layout.in_told(kinds)] * np.sqrt(model.solution.weights[list(kinds)])
    change = np.abs(told.reshape(joints, 3, -1) - told.reshape(joints, 3, -1)[:, 1:2]).max(axis=(1, 2))
    return np.asarray(np.where(room.free & (change > 1e-6 * max(float(change.max()), 1e-300)), change, 0.0))
