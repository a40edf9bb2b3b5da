"""One log with the device: every approach, their doubt, and where the bands are, before the bands are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.devices.routing import Routing
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.identification.result import Channels, Prediction
from exogauge.identification.validate import predict_log, prediction_of
from exogauge.logs.derivatives import differentiate
from exogauge.logs.model import Log
from exogauge.support.at_rest import bridged, doubt_at_rest, scatter_at_rest
from exogauge.support.balance import balance, of_this_log, prepare_worn, slopes
from exogauge.support.difference import difference
from exogauge.support.drift import Drift
from exogauge.support.paired import paired
from exogauge.support.phases import find_phases, main_joint
from exogauge.support.repeatability import Plain, Repeatability
from exogauge.support.same_motion import Match, Posture, match
from exogauge.support.settings import SupportSettings, WornLog
from exogauge.support.zeros import Zeros

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]
OwnInputs = Mapping[str, NDArray[np.float32]]


@final
@dataclass(frozen=True)
class Doubted:
    """What one approach's torque of one joint in one log hangs on. slope: (n, P + I), own, session: (n, K) each, as
    `slope_…`, `own_…` and `session_…` of `Evidence`. at_rest: (T,) [N·m] standard deviation of what friction hides at
    rest."""

    slope: NDArray[np.float32]
    own: OwnInputs
    session: OwnInputs
    at_rest: Array


@final
@dataclass(frozen=True)
class Evidence:
    """T samples, D joints, W bands, P robot parameters.

    q: (T, D), posture: (T, J) [rad] low-passed. main: place among the D joints of the one that moves most.
    a, b, paired, a_priori: (T, D) [N·m] supporting torque by each approach; a and paired are None without a reference
    and NaN where the reference has no such moment or leaves it out. std_…: (T, D). low_…, half_…: (T, D) lower end and
    half of the interval that friction at rest leaves. compared, steady, rest: (T, D). length: (T, W) [m].
    kept: samples for a fit. sloped: (n,) samples of slope_…: (n, D, P + I) ∂torque/∂x and with the common inputs
    (`RobotModel.doubt`). own_…: declared uncertainty -> (n, D, K) [N·m] one standard deviation each of what is this
    log's own, and its partner's; session_…: the same of what all logs of a session have in common (`Drift`,
    `Zeros`). rest_a, rest_b: (T, D) [N·m] of std_a, and of std_b and std_paired, what friction at rest makes.
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
    own_b: OwnInputs = field(default_factory=dict)
    own_a: OwnInputs = field(default_factory=dict)
    paired: Array | None = None
    std_paired: Array | None = None
    low_paired: Array | None = None
    half_paired: Array | None = None
    from_partner: BoolArray | None = None
    own_paired: OwnInputs = field(default_factory=dict)
    session_b: OwnInputs = field(default_factory=dict)
    session_a: OwnInputs = field(default_factory=dict)
    session_paired: OwnInputs = field(default_factory=dict)
    rest_a: Array | None = None
    rest_b: Array | None = None

    @property
    def slope_paired(self) -> NDArray[np.float32] | None:
        """(n, D, P + I) as `slope_a` of the joints that the partner tells of, as `slope_b` of the others."""
        if self.slope_a is None or self.from_partner is None:
            return None
        return np.where(self.from_partner[:, None], self.slope_a, self.slope_b)

    def doubted(self, approach: str, joint: int) -> Doubted:
        """Of `a`, `b` or `paired` at a place among the D joints."""
        own, session, at_rest = {
            "a": (self.own_a, self.session_a, self.rest_a),
            "b": (self.own_b, self.session_b, self.rest_b),
            "paired": (self.own_paired, self.session_paired, self.rest_b),
        }[approach]
        told = approach == "paired" and self.from_partner is not None and self.from_partner[joint]
        slope = self.slope_a if approach == "a" or told else self.slope_b
        assert slope is not None
        assert at_rest is not None
        own, session = ({name: part[:, joint] for name, part in each.items()} for each in (own, session))
        return Doubted(slope[:, joint], own, session, at_rest[:, joint])


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
    held: (D,) [N·m] the largest friction seen at rest. reference: the place in plains to compare with, if any. drift:
    of motors through the session, zeros: of the feet's sensors; None where nothing is known of it.
    """

    joints: IntArray
    plains: Sequence[Plain]
    repeats: Repeatability
    held: Array
    reference: int | None
    drift: Drift | None = None
    zeros: Zeros | None = None


def gather(
    model: RobotModel, worn: WornLog, routing: Routing, background: Background, settings: SupportSettings
) -> Evidence:
    """Everything that one log with the device says."""
    joints, repeats = background.joints, background.repeats
    prepared = prepare_worn(model, worn.log)
    own = balance(model, prepared, joints)
    courses = [each for each in (background.drift, background.zeros) if each is not None]
    for course in courses:
        own = course.without(model, own)
    names = [model.robot.joints[j].name for j in joints]
    q = prepared.motion.q[:, joints]
    geometry = routing.geometry(prepared.motion.q)
    sloped = _sloped(prepared)
    slope_b = _slopes(model, prepared, sloped, joints)
    own_b, session_b = _own_inputs(model, prepared, sloped, joints, courses)
    std_b = _spread(model.doubt, slope_b, own_b | session_b, sloped, own.steady, *repeats.spread("b"))
    half_b = own.rest * background.held
    jacobian = on_joints(geometry.jacobian, routing, joints)
    at_rest = doubt_at_rest(own.torque, own.steady, half_b, geometry.length, np.any(jacobian, axis=0))
    std_b = np.hypot(std_b, at_rest)
    a = std_a = rest_a = slope_a = found = reference = pair = std_pair = slope_pair = None
    own_a, session_a, own_pair, session_pair = (dict[str, NDArray[np.float32]]() for _ in range(4))
    half_a, compared = np.zeros_like(half_b), np.zeros_like(own.steady)
    if background.reference is not None:
        plain = background.plains[background.reference]
        found = match(Posture(worn.log, names), plain.posture, settings)
        apart = difference(own, plain.balance, found)
        a, compared, half_a, reference = apart.torque, apart.compared, apart.rest * background.held, plain.name
        slope_a = slope_b - _slopes(model, plain.balance.prepared, apart.nearest[sloped], joints)
        partner, then = _own_inputs(model, plain.balance.prepared, apart.nearest[sloped], joints, courses)
        own_a = _with_partner(own_b, partner)
        session_a = {name: each - then[name] for name, each in session_b.items()}
        std_a = _spread(model.doubt, slope_a, own_a | session_a, sloped, own.steady, *repeats.spread("a"))
        rest_a = _rest_of_a(a, compared, half_a)
        std_a = np.hypot(std_a, rest_a)
        pair = paired(own, plain.balance, apart, background.held)
        theirs = pair.from_partner[None, :, None]
        slope_pair = np.where(theirs, slope_a, slope_b)
        taken_off = {name: np.where(theirs, each, np.float32(0.0)) for name, each in partner.items()}
        own_pair = _with_partner(own_b, taken_off)
        session_pair = {name: np.where(theirs, session_a[name], each) for name, each in session_b.items()}
        std_pair = _spread(
            model.doubt, slope_pair, own_pair | session_pair, sloped, own.steady, *repeats.spread("paired")
        )
        std_pair = np.hypot(std_pair, at_rest)
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
        own_b=own_b,
        own_a=own_a,
        prediction=prediction_of(worn.log, True, model.equations, partial(_told, model, worn.log)),
        paired=None if pair is None else pair.torque,
        std_paired=std_pair,
        low_paired=None if pair is None else pair.middle - pair.half,
        half_paired=None if pair is None else pair.half,
        from_partner=None if pair is None else pair.from_partner,
        own_paired=own_pair,
        session_b=session_b,
        session_a=session_a,
        session_paired=session_pair,
        rest_a=rest_a,
        rest_b=at_rest,
    )


def _told(model: RobotModel, log: Log) -> Channels:
    prepared = prepare_worn(model, log)
    return predict_log(model.equations, prepared, model.identified, model.a_priori, model.k_T)


def on_joints(values: Array, routing: Routing, joints: IntArray) -> Array:
    """(..., D) what belongs to a routing's columns, for the joints asked for; 0 where no band acts."""
    out = np.zeros((*values.shape[:-1], len(joints)))
    for column, joint in enumerate(routing.columns):
        out[..., np.flatnonzero(joints == joint)] = values[..., [column]]
    return out


def _rest_of_a(torque: Array, steady: BoolArray, half: Array) -> Array:
    """(T, D) [N·m] standard deviation of what friction at rest adds to approach A: for a joint that also moves, how far
    the torque at rest stands off the line between its motions; for one that never moves, an interval's."""
    scatter = scatter_at_rest(torque, steady, half)
    most = np.max(half, axis=0, initial=1e-300)
    moved = (half / most) * np.nan_to_num(scatter)
    return np.asarray(np.where(np.isnan(scatter), half / np.sqrt(3.0), moved))


def _sloped(prepared: Prepared) -> IntArray:
    most_slopes = 400  # per log
    slope_rate_hz = 10.0  # at which the torque's slopes with the robot's parameters are kept: they are smooth
    kept = prepared.kept
    seconds = (kept[-1] - kept[0]) / prepared.log.rate_hz
    count = int(np.clip(round(seconds * slope_rate_hz), 2, most_slopes))
    return np.unique(kept[np.round(np.linspace(0, len(kept) - 1, count)).astype(np.intp)])


def _slopes(model: RobotModel, prepared: Prepared, samples: IntArray, joints: IntArray) -> NDArray[np.float32]:
    out = np.zeros((len(samples), len(joints), model.equations.size + len(model.inputs.names)), dtype=np.float32)
    for place, slope in slopes(model, prepared, samples, joints):
        out[:, place] = slope
    return out


def _own_inputs(
    model: RobotModel,
    prepared: Prepared,
    samples: IntArray,
    joints: IntArray,
    courses: Sequence[Drift | Zeros],
) -> tuple[dict[str, NDArray[np.float32]], dict[str, NDArray[np.float32]]]:
    """What is this log's own, and what all logs of the session have in common; the same inputs in the same order,
    whatever the log."""
    found = of_this_log(model, prepared, samples, joints)
    own = {name: each.astype(np.float32) for name, each in found.items() if each.any()}
    session = dict[str, NDArray[np.float32]]()
    for course in courses:
        session |= course.doubt(model, prepared, samples, joints)
    return {name: each for name, each in own.items() if name not in session}, session


def _with_partner(own: OwnInputs, partner: OwnInputs) -> dict[str, NDArray[np.float32]]:
    """Of a difference of two runs: what the drifts of both have in common, then what each has alone."""
    both, alone = np.float32(np.sqrt(DECLARED.partner_alike)), np.float32(np.sqrt(1.0 - DECLARED.partner_alike))
    return {
        name: np.concatenate([both * (each - partner[name]), alone * each, alone * partner[name]], axis=2)
        for name, each in own.items()
    }


def _spread(
    covariance: Array,
    slope: NDArray[np.float32],
    inputs: OwnInputs,
    sloped: IntArray,
    moves: BoolArray,
    steady: Array,
    other: Array,
) -> Array:
    """(T, D) standard deviation: of the robot's parameters and what is declared, and of what does not repeat, by
    regime."""
    everywhere = np.arange(len(moves))
    result = np.where(moves, steady**2, other**2)
    for joint in range(slope.shape[1]):
        S = slope[:, joint]
        live = np.flatnonzero(S.any(axis=0))
        part = S[:, live].astype(np.float64)
        variance = np.einsum("np,pq,nq->n", part, covariance[np.ix_(live, live)], part, optimize=True)
        variance += sum(np.sum(each[:, joint].astype(np.float64) ** 2, axis=1) for each in inputs.values())
        result[:, joint] += np.interp(everywhere, sloped, np.maximum(variance, 0.0))
    return np.sqrt(result)
