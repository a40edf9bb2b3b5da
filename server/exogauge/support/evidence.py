"""One log with the device: both approaches, their doubt, and where the bands are, before the bands are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.routing import Routing
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.identification.result import Prediction
from exogauge.identification.validate import predict_log
from exogauge.logs.derivatives import differentiate
from exogauge.support.at_rest import bridged, scatter_at_rest, stretched_meanwhile
from exogauge.support.balance import Balance, balance, prepare_worn, slopes
from exogauge.support.phases import find_phases, main_joint
from exogauge.support.repeatability import Plain, Repeatability, difference
from exogauge.support.same_motion import Match, Posture, match
from exogauge.support.settings import SupportSettings, WornLog

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

SLOPE_RATE_HZ = 10.0  # at which the torque's slopes with the robot's parameters are kept: they are smooth
MOST_SLOPES = 400  # per log


@final
@dataclass(frozen=True)
class Evidence:
    """T samples, D joints, W bands, P robot parameters.

    q: (T, D), posture: (T, J) [rad] low-passed. main: place among the D joints of the one that moves most.
    a, b, a_priori: (T, D) [N·m] supporting torque by each approach; a is None without a reference and NaN where the
    reference has no such moment or leaves it out. std_a, std_b: (T, D). half_a, half_b: (T, D) half of the interval
    that friction at rest leaves. compared, steady, rest: (T, D). length: (T, W) [m].
    kept: samples for a fit. sloped: (n,) samples of slope_b, slope_a: (n, D, P) ∂torque/∂x.
    """

    worn: WornLog
    reference: str | None
    found: Match | None
    time: Array
    q: Array
    posture: Array
    phase: IntArray
    main: int
    a: Array | None
    b: Array
    a_priori: Array
    std_a: Array | None
    std_b: Array
    half_a: Array
    half_b: Array
    low_b: Array
    compared: BoolArray
    steady: BoolArray
    rest: BoolArray
    length: Array
    kept: IntArray
    sloped: IntArray
    slope_b: NDArray[np.float32]
    slope_a: NDArray[np.float32] | None
    prediction: Prediction


@final
@dataclass(frozen=True)
class Nothing:
    """A log without the device, at its kept samples: (n,) time [s], (n, J) posture, (n, D) torques that ought to be
    zero."""

    motion: str
    time: Array
    posture: Array
    b: Array
    a_priori: Array
    steady: BoolArray


@final
@dataclass(frozen=True)
class Background:
    """What a log with the device is held against. joints: (D,) columns of q that the bands act on.

    plains: logs without the device of the same motion. repeats: what both approaches find where the truth is zero.
    held: (D,) [N·m] the largest friction seen at rest. reference: the place in plains to compare with, if any.
    """

    joints: IntArray
    plains: Sequence[Plain]
    repeats: Repeatability
    held: Array
    reference: int | None


def gather(
    model: RobotModel, worn: WornLog, routing: Routing, background: Background, settings: SupportSettings
) -> Evidence:
    """Everything that one log with the device says."""
    joints, repeats = background.joints, background.repeats
    prepared = prepare_worn(model, worn.log)
    own = balance(model, prepared, joints)
    names = [model.robot.joints[j].name for j in joints]
    q = prepared.motion.q[:, joints]
    geometry = routing.geometry(prepared.motion.q)
    sloped = _sloped(prepared)
    slope_b = _slopes(model, prepared, sloped, joints)
    std_b = _spread(model.covariance, slope_b, sloped, own, repeats.by_model_steady, repeats.by_model_other)
    half_b = own.rest * background.held
    jacobian = on_joints(geometry.jacobian, routing, joints)
    stretched = stretched_meanwhile(geometry.length, np.any(jacobian, axis=0), own.steady)
    std_b = _with_rest(std_b, own.torque, own.steady, half_b, on_line=~stretched)
    a = std_a = slope_a = found = reference = None
    half_a, compared = np.zeros_like(half_b), np.zeros_like(own.steady)
    if background.reference is not None:
        plain = background.plains[background.reference]
        found = match(Posture(worn.log, names), plain.posture, settings)
        apart = difference(own, plain.balance, found)
        a, compared, half_a, reference = apart.torque, apart.compared, apart.rest * background.held, plain.name
        slope_a = slope_b - _slopes(model, plain.balance.prepared, apart.nearest[sloped], joints)
        steady, other = _between_runs(repeats)
        std_a = _spread(model.covariance, slope_a, sloped, own, steady, other)
        std_a = _with_rest(std_a, apart.torque, apart.compared, half_a)
    main = main_joint(q)
    return Evidence(
        worn=worn,
        reference=reference,
        found=found,
        time=worn.log.time,
        q=q,
        posture=prepared.motion.q,
        phase=find_phases(worn.log.time, q, differentiate(q, worn.log.rate_hz), main),
        main=main,
        a=a,
        b=bridged(own.torque, own.steady, half_b),
        a_priori=bridged(own.torque_a_priori, own.steady, half_b),
        low_b=own.torque - half_b,
        std_a=std_a,
        std_b=std_b,
        half_a=half_a,
        half_b=half_b,
        compared=compared,
        steady=own.steady & own.prepared.settled[:, None],
        rest=own.at_rest,
        length=geometry.length,
        kept=prepared.kept,
        sloped=sloped,
        slope_b=slope_b,
        slope_a=slope_a,
        prediction=predict_log(
            model.equations, prepared, model.identified, model.a_priori, model.k_T, True, model.prepared
        ),
    )


def on_joints(values: Array, routing: Routing, joints: IntArray) -> Array:
    """(..., D) what belongs to a routing's columns, for the joints asked for; 0 where no band acts."""
    out = np.zeros((*values.shape[:-1], len(joints)))
    for column, joint in enumerate(routing.columns):
        out[..., np.flatnonzero(joints == joint)] = values[..., [column]]
    return out


def _between_runs(repeats: Repeatability) -> tuple[Array, Array]:
    """Spread of approach A. From one log without the device only, the model's error stands in, once for each run."""
    if repeats.between_runs_steady is None or repeats.between_runs_other is None:
        return np.sqrt(2.0) * repeats.by_model_steady, np.sqrt(2.0) * repeats.by_model_other
    return repeats.between_runs_steady, repeats.between_runs_other


def _with_rest(std: Array, torque: Array, steady: BoolArray, half: Array, on_line: BoolArray | None = None) -> Array:
    """(T, D) std with what friction at rest may add: for a joint that also moves, how far the torque at rest stands
    off the line between its motions; for one that never moves, an interval's standard deviation. on_line: (T, D) where
    the line itself is taken, for which nothing is added where it holds, and an interval's standard deviation elsewhere.
    """
    scatter = scatter_at_rest(torque, steady, half)
    alone = half / np.sqrt(3.0)
    if on_line is None:
        most = np.max(half, axis=0, initial=1e-300)
        moved = (half / most) * np.nan_to_num(scatter)
    else:
        moved = np.where(on_line, 0.0, alone)
    return np.asarray(np.hypot(std, np.where(np.isnan(scatter), alone, moved)))


def _sloped(prepared: Prepared) -> IntArray:
    kept = prepared.kept
    seconds = (kept[-1] - kept[0]) / prepared.log.rate_hz
    count = int(np.clip(round(seconds * SLOPE_RATE_HZ), 2, MOST_SLOPES))
    return np.unique(kept[np.round(np.linspace(0, len(kept) - 1, count)).astype(np.intp)])


def _slopes(model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray) -> NDArray[np.float32]:
    out = np.zeros((len(samples), len(joints), model.equations.size), dtype=np.float32)
    for place, slope in slopes(model, prepared, samples, joints):
        out[:, place] = slope
    return out


def _spread(
    covariance: Array, slope: NDArray[np.float32], sloped: IntArray, own: Balance, steady: Array, other: Array
) -> Array:
    """(T, D) standard deviation: of the robot's parameters, and of what does not repeat, by regime."""
    everywhere = np.arange(len(own.torque))
    result = np.where(own.steady, steady**2, other**2)
    for joint in range(slope.shape[1]):
        S = slope[:, joint]
        live = np.flatnonzero(S.any(axis=0))
        part = S[:, live].astype(np.float64)
        variance = np.einsum("np,pq,nq->n", part, covariance[np.ix_(live, live)], part, optimize=True)
        result[:, joint] += np.interp(everywhere, sloped, np.maximum(variance, 0.0))
    return np.sqrt(result)
