"""One log with the device: every approach, their doubt, and where the bands are, before the bands are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.routing import Routing
from exogauge.identification.model import RobotModel
from exogauge.identification.result import Channels, Prediction
from exogauge.identification.sites import positions
from exogauge.identification.validate import predict_log, prediction_of
from exogauge.logs.derivatives import differentiate
from exogauge.logs.model import Log
from exogauge.support.at_rest import bridged, doubt_at_rest, scatter_at_rest
from exogauge.support.balance import balance, prepare_worn
from exogauge.support.difference import difference
from exogauge.support.drift import Drift
from exogauge.support.inputs import ByName, Doubts, Inputs, sloped_samples
from exogauge.support.paired import paired
from exogauge.support.phases import find_phases, main_joint
from exogauge.support.repeatability import Plain, Repeatability
from exogauge.support.same_motion import Match, Posture, match
from exogauge.support.settings import SupportSettings, WornLog
from exogauge.support.zeros import Zeros

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Evidence:
    """T samples, D joints, W bands, P robot parameters.

    q: (T, D), posture: (T, J) [rad] low-passed. main: place among the D joints of the one that moves most.
    a, b, paired, a_priori: (T, D) [N·m] supporting torque by each approach; a and paired are None without a reference
    and NaN where the reference has no such moment or leaves it out. std_…: (T, D). low_…, half_…: (T, D) lower end and
    half of the interval that friction at rest leaves. compared, steady, rest: (T, D). length: (T, W) [m].
    kept: samples for a fit. sloped: (n,) samples of inputs_…: what each approach's torque hangs on. rest_a, rest_b:
    (T, D) [N·m] of std_a, and of std_b and std_paired, what friction at rest makes.
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
    inputs_b: Inputs
    prediction: Prediction
    inputs_a: Inputs | None = None
    paired: Array | None = None
    std_paired: Array | None = None
    low_paired: Array | None = None
    half_paired: Array | None = None
    from_partner: BoolArray | None = None
    inputs_paired: Inputs | None = None
    rest_a: Array | None = None
    rest_b: Array | None = None

    def inputs(self, approach: str) -> Inputs:
        """Of `a`, `b` or `paired`."""
        found = {"a": self.inputs_a, "b": self.inputs_b, "paired": self.inputs_paired}[approach]
        assert found is not None
        return found

    def at_rest(self, approach: str) -> Array:
        """(T, D) [N·m] standard deviation of what friction hides at rest, of `a`, `b` or `paired`."""
        found = self.rest_a if approach == "a" else self.rest_b
        assert found is not None
        return found


@final
@dataclass(frozen=True)
class Nothing:
    """A log without the device, at its kept samples: (n,) time [s], (n, J) posture, (n, D) torques that ought to be
    zero. own, session, anew: as of `Inputs`, at the places `sloped` among the kept samples."""

    motion: str
    time: Array
    posture: Array
    b: Array
    a_priori: Array
    steady: BoolArray
    sloped: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    own: ByName = field(default_factory=dict)
    session: ByName = field(default_factory=dict)
    anew: frozenset[str] = frozenset()


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
    posture = positions(model, prepared)
    geometry = routing.geometry(posture)
    sloped = sloped_samples(prepared)
    doubts = Doubts(model, joints, courses)
    inputs = doubts.inputs(prepared, sloped)
    known = partial(doubts.of_samples, sloped=sloped, samples=len(own.time))
    std_b = _spread(known(inputs), own.steady, *repeats.spread("b"))
    half_b = own.rest * background.held
    jacobian = on_joints(geometry.jacobian, routing, joints)
    at_rest = doubt_at_rest(own.torque, own.steady, half_b, geometry.length, np.any(jacobian, axis=0))
    std_b = np.hypot(std_b, at_rest)
    a = std_a = rest_a = inputs_a = found = reference = pair = std_pair = inputs_pair = None
    half_a, compared = np.zeros_like(half_b), np.zeros_like(own.steady)
    if background.reference is not None:
        plain = background.plains[background.reference]
        found = match(Posture(worn.log, names), plain.posture, settings)
        apart = difference(own, plain.balance, found)
        a, compared, half_a, reference = apart.torque, apart.compared, apart.rest * background.held, plain.name
        partner = doubts.inputs(plain.balance.prepared, apart.nearest[sloped])
        inputs_a = inputs.less(partner)
        std_a = _spread(known(inputs_a), own.steady, *repeats.spread("a"))
        rest_a = _rest_of_a(a, compared, half_a)
        std_a = np.hypot(std_a, rest_a)
        pair = paired(own, plain.balance, apart, background.held)
        inputs_pair = inputs_a if pair.from_partner.all() else inputs.less(partner, pair.from_partner)
        std_pair = _spread(known(inputs_pair), own.steady, *repeats.spread("paired"))
        std_pair = np.hypot(std_pair, at_rest)
    main = main_joint(q)
    return Evidence(
        worn=worn,
        reference=reference,
        found=found,
        time=worn.log.time,
        q=q,
        posture=posture,
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
        inputs_b=inputs,
        inputs_a=inputs_a,
        prediction=prediction_of(worn.log, True, model.equations, partial(_told, model, worn.log)),
        paired=None if pair is None else pair.torque,
        std_paired=std_pair,
        low_paired=None if pair is None else pair.middle - pair.half,
        half_paired=None if pair is None else pair.half,
        from_partner=None if pair is None else pair.from_partner,
        inputs_paired=inputs_pair,
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


def _spread(known: Array, moves: BoolArray, steady: Array, other: Array) -> Array:
    """(T, D) standard deviation. known: (T, D) variance of the robot's parameters and what is declared; steady, other:
    (D,) of what does not repeat, by regime."""
    return np.asarray(np.sqrt(np.where(moves, steady**2, other**2) + known))
