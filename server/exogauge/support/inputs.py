"""What a supporting torque hangs on: the robot's parameters, and what is declared and no log shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.identification.disturbances import ZERO
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.support.balance import of_this_log, slopes
from exogauge.support.drift import Drift
from exogauge.support.zeros import Zeros

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]
ByName = Mapping[str, NDArray[np.float32]]


@final
@dataclass(frozen=True)
class Inputs:
    """At n samples of one log, or of a difference of two. slope: (n, D, P + I) ∂torque/∂x and with the common inputs
    (`RobotModel.doubt`). own: declared uncertainty -> (n, D, K) [N·m] one standard deviation each of what is this
    log's own, and its partner's; session: the same of what all logs of a session have in common (`Drift`, `Zeros`).
    anew: names of those of `own` that are no more alike in two logs than chance has it."""

    slope: NDArray[np.float32]
    own: ByName = field(default_factory=dict)
    session: ByName = field(default_factory=dict)
    anew: frozenset[str] = frozenset()

    def less(self, partner: Inputs, joints: BoolArray | None = None) -> Inputs:
        """Of a difference of two runs, of this run alone where not `joints` (D,). What drifts in both runs alike comes
        first, then what each has alone."""
        theirs = np.ones((1, 1, 1), dtype=np.bool_) if joints is None else joints[None, :, None]
        own = dict[str, NDArray[np.float32]]()
        for name, each in self.own.items():
            taken_off = np.where(theirs, partner.own[name], np.float32(0.0))
            alike = 0.0 if name in self.anew else DECLARED.partner_alike
            both, alone = np.float32(np.sqrt(alike)), np.float32(np.sqrt(1.0 - alike))
            own[name] = np.concatenate([both * (each - taken_off), alone * each, alone * taken_off], axis=2)
        return Inputs(
            np.where(theirs, self.slope - partner.slope, self.slope),
            own,
            {name: np.where(theirs, each - partner.session[name], each) for name, each in self.session.items()},
            self.anew,
        )

    def joint(self, place: int) -> Inputs:
        """(n, P + I), (n, K) each, of one of the D joints."""
        own, session = ({name: part[:, place] for name, part in each.items()} for each in (self.own, self.session))
        return Inputs(self.slope[:, place], own, session, self.anew)

    @property
    def declared(self) -> ByName:
        return {**self.own, **self.session}


@final
@dataclass(frozen=True)
class Doubts:
    """Of a model's torque on `joints` (D,). courses: what is known of a session's drifts."""

    model: RobotModel
    joints: IntArray
    courses: Sequence[Drift | Zeros] = ()

    def inputs(self, prepared: Prepared, samples: IntArray) -> Inputs:
        """Of one log; the same inputs in the same order, whatever the log."""
        model, joints = self.model, self.joints
        slope = np.zeros((len(samples), len(joints), model.equations.size + len(model.inputs.names)), dtype=np.float32)
        for place, each in slopes(model, prepared, samples, joints):
            slope[:, place] = each
        return Inputs(slope, *self.declared(prepared, samples), self.anew)

    @property
    def anew(self) -> frozenset[str]:
        """As of `Inputs`."""
        return frozenset({ZERO} if self.model.robot.declared.zeros_taken == "log" else ())

    def declared(self, prepared: Prepared, samples: IntArray) -> tuple[ByName, ByName]:
        """Those that are one log's own, and those of the session (`Inputs`)."""
        session = dict[str, NDArray[np.float32]]()
        for course in self.courses:
            session |= course.doubt(self.model, prepared, samples, self.joints)
        found = of_this_log(self.model, prepared, samples, self.joints)
        own = {name: each.astype(np.float32) for name, each in found.items() if each.any() and name not in session}
        return own, session

    def of_samples(self, inputs: Inputs, sloped: IntArray, samples: int) -> Array:
        """(T, D) [N²·m²] variance of each joint's torque, straight lines between the `sloped` samples."""
        everywhere, variances, C = np.arange(samples), np.zeros((samples, len(self.joints))), self.model.doubt
        for joint in range(len(self.joints)):
            S = inputs.slope[:, joint]
            live = np.flatnonzero(S.any(axis=0))
            part = S[:, live].astype(np.float64)
            own = np.einsum("np,pq,nq->n", part, C[np.ix_(live, live)], part, optimize=True)
            own += sum(np.sum(each[:, joint].astype(np.float64) ** 2, axis=1) for each in inputs.declared.values())
            variances[:, joint] = np.interp(everywhere, sloped, np.maximum(own, 0.0))
        return variances

    def of_means(self, inputs: Inputs, sloped: IntArray, windows: BoolArray) -> Array:
        """(D,) [N²·m²] variance of each joint's mean over its window (T, D) of one log; 0 where it is empty."""
        weights = np.zeros((len(self.joints), len(sloped)))
        for place in np.flatnonzero(windows.any(axis=0)):
            weights[place] = weights_of_mean(sloped, windows[:, place])
        S = np.einsum("dn,ndp->dp", weights, inputs.slope, optimize=True)
        variances = np.einsum("dp,pq,dq->d", S, self.model.doubt, S, optimize=True)
        for each in inputs.declared.values():
            variances += np.sum(np.einsum("dn,ndk->dk", weights, each, optimize=True) ** 2, axis=1)
        return np.asarray(np.maximum(variances, 0.0))


def sloped_samples(prepared: Prepared) -> IntArray:
    """(n,) those of the kept ones at which a log's inputs are computed."""
    most_slopes = 400  # per log
    slope_rate_hz = 10.0  # at which the torque's slopes with the robot's parameters are kept: they are smooth
    kept = prepared.kept
    seconds = (kept[-1] - kept[0]) / prepared.log.rate_hz
    count = int(np.clip(round(seconds * slope_rate_hz), 2, most_slopes))
    return np.unique(kept[np.round(np.linspace(0, len(kept) - 1, count)).astype(np.intp)])


def weights_of_mean(sloped: IntArray, window: BoolArray) -> Array:
    """(n,) how much each of the `sloped` samples counts in a mean over a window (T,), with straight lines between."""
    place = np.interp(np.flatnonzero(window), sloped, np.arange(len(sloped)))
    before = np.floor(place).astype(np.intp)
    after, share = np.minimum(before + 1, len(sloped) - 1), place - before
    weights = np.zeros(len(sloped))
    np.add.at(weights, before, (1.0 - share) / len(place))
    np.add.at(weights, after, share / len(place))
    return weights


def variance_of_mean(model: RobotModel, means: Sequence[tuple[Inputs, Array]]) -> dict[str, float]:
    """Source -> variance [N²·m²] of the mean over K logs of one joint's means. They err alike at every sample of a log.

    means: of each log, `Inputs.joint` and `weights_of_mean`."""
    K = len(means)
    S = np.mean([weights @ each.slope for each, weights in means], axis=0)
    own = [{name: weights @ part for name, part in each.own.items()} for each, weights in means]
    session = [{name: weights @ part for name, part in each.session.items()} for each, weights in means]
    found = {source: max(float(S @ C @ S), 0.0) for source, C in model.doubt_by_source.items()}
    for source in own[0]:
        every = np.array([parts[source] for parts in own])
        alike = 0.0 if source in means[0][0].anew else DECLARED.alike
        square = alike * np.sum(np.mean(every, axis=0) ** 2) + (1.0 - alike) * np.sum(every**2) / K**2
        found[source] = found.get(source, 0.0) + float(square)
    for source in session[0]:
        together = np.mean([parts[source] for parts in session], axis=0)
        found[source] = found.get(source, 0.0) + float(np.sum(together**2))
    return found
