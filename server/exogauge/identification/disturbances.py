"""What each declared uncertainty takes off the rows of a log per unit, and what that makes of the identified robot."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.effects.imu_tilt import turned
from exogauge.effects.places import BaseChange
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.identification.session import session
from exogauge.identification.sites import STEP, read_wrongly, response
from exogauge.identification.solution import Solution
from exogauge.identification.thinned import at_all, thinned
from exogauge.identification.type_b import TypeB
from exogauge.logs.derivatives import differentiate
from exogauge.robots.description import Robot, drifts_in_doubt
from exogauge.robots.row_blocks import Swept
from exogauge.robots.rows import RowType
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

COMMON_GAIN, GAIN, SENSOR_TILT, SENSOR_PLACE, ZERO = "ft_gain_common", "ft_gain", "ft_tilt", "ft_place", "ft_zero"
TILT, ENCODER, CLOCK, IMU = "imu_tilt", "encoder_zero", "clock", "imu"
DRIFTS = {"kt_drift": "motor_gain", "viscous_drift": "viscous", "coulomb_drift": "coulomb"}  # whose coefficient goes


@final
@dataclass(frozen=True)
class _Sums:
    """Σ -w Aᵀ c of one log: (P, I) of what all logs share, (P, S) of its zeros, (P, A) of each drift of its motors."""

    common: Array
    zeros: Array
    drifts: Mapping[str, Array]


def common_inputs(robot: Robot) -> tuple[tuple[str, ...], Array]:
    """Names and standard deviations of those declared that are the same in all logs."""
    declared, found = robot.declared, list[tuple[str, float]]()
    sensors = [each.name for each in (*robot.contacts, *robot.cuts)]
    if sensors:
        found.append((COMMON_GAIN, declared.ft_gain_common))
    found += [(f"{GAIN}.{name}", declared.ft_gain) for name in sensors]
    found += [(f"{SENSOR_TILT}.{name}.{axis}", declared.ft_tilt) for name in sensors for axis in "xyz"]
    found += [(f"{SENSOR_PLACE}.{name}.{axis}", declared.ft_place) for name in sensors for axis in "xyz"]
    found += [(f"{CLOCK}.{name}", declared.clock) for name in sensors]
    if robot.floating:
        found += [(f"{TILT}.{axis}", declared.imu_tilt) for axis in "xy"]
        found.append((f"{CLOCK}.{IMU}", declared.clock))
    found += [(f"{ENCODER}.{joint.name}", declared.encoder_zero) for joint in robot.joints
              if joint.name not in robot.tree.sliding]  # fmt: skip
    live = [(name, std) for name, std in found if std > 0.0]
    return tuple(name for name, _ in live), np.array([std for _, std in live])


def common_columns(equations: Equations, prepared: Prepared, at: IntArray, cutoff_hz: float, phi: Array) -> Array:
    """(n, I, told rows) what each of `common_inputs` takes off the rows at these samples per unit. phi: (B,) base
    parameters, which feel how the base stands."""
    robot, told = equations.robot, equations.layout.told
    places = {name: place for place, name in enumerate(common_inputs(robot)[0])}
    columns = np.zeros((len(at), len(places), len(told)))
    for sensor, every, acts in _sensors(equations, prepared, at) if places else ():
        read = every[at]
        more = [(COMMON_GAIN, read), (f"{GAIN}.{sensor}", read)]
        for axis, about in zip("xyz", np.eye(3), strict=True):
            more.append((f"{SENSOR_TILT}.{sensor}.{axis}", np.cross(about, read.reshape(-1, 2, 3)).reshape(-1, 6)))
            moment = np.cross(read[:, :3], about)  # of a force that is read at a place beside the frame's
            more.append((f"{SENSOR_PLACE}.{sensor}.{axis}", np.hstack([np.zeros_like(moment), moment])))
        if (late := f"{CLOCK}.{sensor}") in places:
            more.append((late, -differentiate(every, prepared.log.rate_hz)[at]))
        for name, wrench in more:
            if name in places:  # y holds too much of it
                columns[:, places[name]] -= np.einsum("nc,ncr->nr", wrench, acts)
    for name, change in _changes_of_base(equations, prepared, places):
        columns[:, places[name]] = response(equations, cutoff_hz, phi, prepared, change)[at]
    samples = prepared.motion.samples
    few = thinned(samples, prepared.log.rate_hz, cutoff_hz)
    encoders = {number: place for number, joint in enumerate(robot.joints)
                if (place := places.get(f"{ENCODER}.{joint.name}")) is not None}  # fmt: skip
    if encoders:
        some = at if len(at) <= len(few) else few
        swept, unit = Swept.of(prepared.motion.rows(some)), np.tile([1.0, 0.0, 0.0], (len(some), 1))
        for number, place in encoders.items():
            found = read_wrongly(equations, phi, swept, prepared.wrenches[some], number, -STEP, STEP, unit)
            columns[:, place] = found if some is at else at_all(samples, few, found)[at]
    return columns


def _sensors(equations: Equations, prepared: Prepared, at: IntArray) -> Iterator[tuple[str, Array, Array]]:
    """Name of each, what it reads (T, 6), and (n, 6, told rows) one newton and one newton metre of each component."""
    told = equations.layout.told
    for number, contact in enumerate(equations.robot.contacts):
        acts = np.zeros((len(at), 6, len(told)))
        acts[:, :, : told.axes.stop] = equations.acting_components(prepared, number, at)
        yield contact.name, prepared.wrenches[:, number], acts
    for number, cut in enumerate(equations.robot.cuts):
        first = told.axes.stop + 6 * number
        acts = np.zeros((len(at), 6, len(told)))
        acts[:, range(6), range(first, first + 6)] = 1.0
        yield cut.name, prepared.carried[:, number], acts


def _changes_of_base(
    equations: Equations, prepared: Prepared, declared: Container[str]
) -> Iterator[tuple[str, BaseChange]]:
    """Of an IMU that is turned about an axis of the base, and of one that is late by a second; those declared."""
    motion, imu, rate = prepared.motion, equations.robot.T_base_imu, prepared.log.rate_hz
    r = np.zeros(3) if imu is None else imu.translation
    for axis, letter in zip(np.eye(3)[:2], "xy", strict=True):
        if (name := f"{TILT}.{letter}") in declared:
            yield name, turned(axis, motion.acc, motion.gyro, motion.gyro_dot, r)
    if (name := f"{CLOCK}.{IMU}") in declared:
        yield name, BaseChange(*(differentiate(each, rate) for each in (motion.acc, motion.gyro, motion.gyro_dot)))


def drift_columns(equations: Equations, xi: Array, prepared: Prepared, at: IntArray) -> dict[str, Array]:
    """Each drift -> (n, A) [N·m] what it takes off a motor's own row per unit of its share. xi: (A, K) coefficients of
    the equations' effects."""
    signals, found = prepared.low_passed.signals(at), dict[str, Array]()
    for name, drifting in DRIFTS.items():
        found[name] = np.zeros((len(at), len(signals)))
        for effect, own in zip(equations.effects, xi.T, strict=True):
            if effect.name == drifting:
                found[name] = np.stack([effect.column(each) for each in signals], axis=1) * own
    return found


def type_b(
    equations: Equations,
    logs: Sequence[Prepared],
    solution: Solution,
    xi: Array,
    cutoff_hz: float,
    started: Mapping[str, float],
) -> TypeB:
    """Through the normal equations of the solution. logs: fitted. xi: (A, K) coefficients of the equations' effects.
    started: `Settings.started`; where it is said, drifts are courses of the session, 0 on the average of these logs,
    and so are zeros that were taken once, 0 as it begins; else they are others in each log."""
    robot = equations.robot
    names, std = common_inputs(robot)
    motors, zeros = drifts_in_doubt(robot), zeros_in_doubt(robot)
    P = equations.size
    if not (len(names) or motors or zeros.any()):
        return TypeB(moved=np.zeros((P, 0)), moved_by_zeros=np.zeros((P, 0)))
    common, by_log = np.zeros((P, len(names))), {name: np.zeros((P, P)) for name in (ZERO, *motors)}
    zeros_alike = np.zeros((P, zeros.size if zeros.any() else 0))
    known = session([each.log for each in logs], [True] * len(logs), started)
    going = dict(motors)
    if robot.declared.zeros_taken == "session" and zeros.any():
        going[ZERO] = zeros
    along = {name: np.zeros((len(DECLARED.warming_s), P, len(size))) for name, size in going.items() if known}
    in_logs = side_by_side(lambda each: _sums_of(equations, each, solution, xi, cutoff_hz), logs)
    for prepared, sums in zip(logs, in_logs, strict=True):
        common += sums.common
        zeros_alike += sums.zeros
        own = {name: B * motors[name] for name, B in sums.drifts.items()}
        if zeros.any():
            own[ZERO] = sums.zeros * zeros
        for name, B in own.items():
            if known is not None and name in along:
                course = (known.gone if name == ZERO else known.course)[known.logs[prepared.log.name]]
                along[name] += np.multiply.outer(course / np.sqrt(len(course)), B)
            else:
                V = solution.unbounded.divided(B)
                by_log[name] += V @ V.T
    for name, courses in along.items():
        for B in courses:
            V = solution.unbounded.divided(B)
            by_log[name] += V @ V.T
    alike, by_zeros = solution.unbounded.divided(common), solution.unbounded.divided(zeros_alike)
    return TypeB(names, std, alike, {n: C for n, C in by_log.items() if C.any()}, by_zeros)


def _sums_of(equations: Equations, prepared: Prepared, solution: Solution, xi: Array, cutoff_hz: float) -> _Sums:
    """Of one log, by the weights of the solution."""
    layout, P = equations.layout, equations.size
    axes, at_rest = layout.told.axes, layout.numbers(RowType.AT_REST)
    phi, kept, motors = solution.solved.x[: equations.base_size], prepared.kept, drifts_in_doubt(equations.robot)
    columns = common_columns(equations, prepared, kept, cutoff_hz, phi)
    zero, every = zero_columns(equations, prepared, kept), drift_columns(equations, xi, prepared, kept)
    common, zeros = np.zeros((P, columns.shape[1])), np.zeros((P, zero.shape[1]))
    drifts = {name: np.zeros((P, len(equations.robot.joints))) for name in motors}
    for _, chunks in equations.rows(prepared, solution.solved.x):
        for chunk in chunks:
            weight = solution.weights[chunk.kind]
            if weight <= 0.0 or chunk.kind in at_rest:
                continue
            (told,), A, own = layout.in_told([chunk.kind]), -weight * chunk.block[:, :-1].T, chunk.columns
            common[own] += A @ columns[chunk.samples, :, told]
            if told < axes.stop:
                zeros[own] += A @ zero[chunk.samples, :, told]
            if layout.rows[chunk.kind].type == RowType.AXIS:
                axis = layout.rows[chunk.kind].place
                for name, drift in drifts.items():
                    drift[own, axis] += A @ every[name][chunk.samples, axis]
    return _Sums(common, zeros, drifts)


def zeros_in_doubt(robot: Robot) -> Array:
    """(6 S,) standard deviation of each component's zero in one log, of the contact sensors."""
    declared = robot.declared
    return np.tile(np.repeat([declared.ft_zero_force, declared.ft_zero_moment], 3), len(robot.contacts))


def zero_columns(equations: Equations, prepared: Prepared, at: IntArray) -> Array:
    """(n, 6 S, base and axis rows) what each component of each contact sensor takes off the rows per unit of its zero,
    none where no zero is in doubt. The zeros of sensors that carry bodies are fitted."""
    if not zeros_in_doubt(equations.robot).any():
        return np.zeros((len(at), 0, equations.layout.told.axes.stop))
    sensors = range(len(equations.robot.contacts))
    return -np.concatenate([equations.acting_components(prepared, sensor, at) for sensor in sensors], axis=1)
