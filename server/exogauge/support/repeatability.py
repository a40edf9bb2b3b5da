"""What every approach finds on logs without a device, where the truth is zero: how far they can be believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.support.at_rest import bridged
from exogauge.support.balance import Balance
from exogauge.support.difference import difference
from exogauge.support.inputs import Doubts, Inputs, sloped_samples
from exogauge.support.paired import paired
from exogauge.support.peak import peak_places, same_moments
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import SupportSettings

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Plain:
    """A log without the device, ready to be compared with. posture: of the joints asked about. held_out: it was not
    fitted, so that it errs by all that is in doubt."""

    balance: Balance
    posture: Posture
    motion: str | None
    held_out: bool = True

    @property
    def name(self) -> str:
        return self.balance.prepared.log.name


@final
@dataclass(frozen=True)
class Null:
    """What an approach finds where the truth is zero, (D,) [N·m] each. What is left out (`Log.left_out`) is in none.

    RMS of the number that is told in steady motion, elsewhere, and over all samples. moves: elsewhere, of A at starts,
    stops and turns alone: what it holds at rest has a doubt of its own. mean: RMS over the logs of their
    means in steady motion, beyond what is known to be in doubt: that stands beside it in every number.
    lasting: regime -> (D,) [s].
    """

    steady: Array
    other: Array
    whole: Array
    moves: Array
    mean: Array
    lasting: Mapping[str, Array]


@final
@dataclass(frozen=True)
class Repeatability:
    """b: on logs without the device. a, paired: on the first of them against the last of the same motion, so that what
    drifts is in them; None where there is only one. peak_b: (D,) [N·m] the peak that B finds on logs without the
    device, 0 where no motion was repeated: what compares runs has none, as what the model lacks is in both."""

    b: Null
    a: Null | None
    paired: Null | None
    peak_b: Array

    @property
    def by_approach(self) -> Mapping[str, Null]:
        found = {"a": self.a, "b": self.b, "paired": self.paired}
        return {name: each for name, each in found.items() if each is not None}

    def spread(self, approach: str) -> tuple[Array, Array]:
        """(D,) each [N·m] of approach `a`, `b` or `paired`, in steady motion and elsewhere. From one log without the
        device only, the model's error stands in for what compares runs, once for each run."""
        found = self.by_approach.get(approach)
        if found is None:
            return np.sqrt(2.0) * self.b.steady, np.sqrt(2.0) * self.b.other
        return found.steady, found.other if approach == "b" else found.moves

    @property
    def between_runs_steady(self) -> Array:
        """(D,) [N·m] of approach A; from one log only the model's error stands in, once for each run."""
        return np.asarray(np.sqrt(2.0) * self.b.steady if self.a is None else self.a.steady)


def repeatability(
    plains: Sequence[Plain], held: Array, settings: SupportSettings, peak_s: float, doubts: Doubts | None = None
) -> Repeatability:
    """From logs without the device of one motion (or, for want of those, of any). held: (D,) friction at rest. peak_s:
    how long the mean lasts that is told as a peak. doubts: what of it stands beside it anyhow."""
    by_b, by_a, by_pair = list[_Seen](), list[_Seen](), list[_Seen]()
    inputs = dict[str, tuple[Inputs, IntArray]]()  # of those that were not fitted
    for plain in plains:
        own, known = plain.balance, None
        whole = ~own.left_out[:, None] & np.ones_like(own.steady)
        told = bridged(own.torque, own.steady, own.rest * held)
        steady = own.steady & whole
        if doubts is not None and plain.held_out:
            sloped = sloped_samples(own.prepared)
            inputs[plain.name] = doubts.inputs(own.prepared, sloped), sloped
            known = doubts.of_means(*inputs[plain.name], steady)
        by_b.append(_Seen(told, steady, ~own.steady & whole, _step(own), known))
    for first, last in _first_and_last(plains):
        this, other = first.balance, last.balance
        apart = difference(this, other, match(first.posture, last.posture, settings))
        pair = paired(this, other, apart, held)
        a = _Seen(apart.torque, apart.compared, ~apart.compared, _step(this), moves=apart.rest < 0.5)
        both = _Seen(pair.torque, this.steady, ~this.steady, _step(this))
        if doubts is not None and first.name in inputs and last.name in inputs:
            at_first, sloped = inputs[first.name]
            partner = doubts.inputs(other.prepared, apart.nearest[sloped])
            of_a, of_both = (at_first.less(partner, joints) for joints in (None, pair.from_partner))
            a = replace(a, known=doubts.of_means(of_a, sloped, a.steady))
            both = replace(both, known=doubts.of_means(of_both, sloped, both.steady))
        by_a.append(a)
        by_pair.append(both)
    b = _null(by_b)
    assert b is not None
    return Repeatability(b, _null(by_a), _null(by_pair), _peak(plains, by_b, settings, peak_s))


def _first_and_last(plains: Sequence[Plain]) -> list[tuple[Plain, Plain]]:
    """Of every motion that was repeated: not neighbours, so that what drifts slowly shows."""
    found = []
    for motion in dict.fromkeys(plain.motion for plain in plains if plain.motion is not None):
        same = [plain for plain in plains if plain.motion == motion]
        if len(same) > 1:
            found.append((same[0], same[-1]))
    return found


@final
@dataclass(frozen=True)
class _Seen:
    """(T, D) each: the number that is told, and the samples of each regime; moves: of the other one, those of which an
    RMS is taken where rest has a doubt of its own. known: (D,) [N²·m²] of the mean in steady motion, if any."""

    told: Array
    steady: BoolArray
    other: BoolArray
    step_s: float
    known: Array | None = None
    moves: BoolArray | bool = True


def _null(seen: Sequence[_Seen]) -> Null | None:
    if not seen:
        return None
    told, steady, other = (
        np.concatenate([getattr(each, name) for each in seen]) for name in ("told", "steady", "other")
    )
    moves = np.concatenate([each.other & each.moves for each in seen])
    step = np.concatenate([np.full(len(each.told), each.step_s) for each in seen])[:, None]
    squares = [_mean(each.told, each.steady) ** 2 - (0.0 if each.known is None else each.known) for each in seen]
    regimes = {"steady": steady, "other": other, "whole": steady | other}
    lasting = {name: np.sum(step * (chosen & np.isfinite(told)), axis=0) for name, chosen in regimes.items()}
    size = {name: _rms(told, chosen) for name, chosen in regimes.items()}
    return Null(
        **size, moves=_rms(told, moves), mean=np.sqrt(np.maximum(np.mean(squares, axis=0), 0.0)), lasting=lasting
    )


def _peak(plains: Sequence[Plain], seen: Sequence[_Seen], settings: SupportSettings, peak_s: float) -> Array:
    """(D,) read as the peak with the device is: where the other repetitions have theirs. Noise leaves little there, and
    what the model lacks in one posture all of it. seen: of each of the logs."""
    largest = np.zeros(seen[0].told.shape[1])
    for motion in dict.fromkeys(plain.motion for plain in plains):
        own = [k for k, plain in enumerate(plains) if plain.motion == motion and motion is not None]
        if len(own) < 2:
            continue
        shifts = [match(plains[own[0]].posture, plains[k].posture, settings).lag_s for k in own]
        times = [np.arange(len(seen[k].told), dtype=np.float64) * seen[k].step_s for k in own]
        moments = same_moments(times, shifts)
        for d in range(len(largest)):
            lines, used = [seen[k].told[:, d] for k in own], [(seen[k].steady | seen[k].other)[:, d] for k in own]
            found = peak_places(times, moments, lines, [None] * len(own), used, peak_s)
            values = [each[1] for each in found if each is not None]
            largest[d] = max(largest[d], abs(float(np.mean(values))) if values else 0.0)
    return largest


def held_friction(model: RobotModel, own: Balance) -> Array:
    """(D,) [N·m] the largest torque that friction was seen to hold at rest, at least the identified τ_s and τ_c."""
    names = {effect.name: k for k, effect in enumerate(model.equations.effects)}
    xi, C = model.identified.xi, np.abs(model.robot.axes_from_joints[:, own.joints])
    known = [xi[:, names[name]] @ C for name in ("static_friction", "coulomb") if name in names]
    resting = own.at_rest & ~own.left_out[:, None]
    seen = np.max(np.abs(np.where(resting, own.torque, 0.0)), axis=0, initial=0.0)
    return np.asarray(np.max([*known, seen], axis=0))


def _rms(values: Array, chosen: BoolArray) -> Array:
    """(D,) over the chosen samples that are finite; 0 where there are none."""
    used = chosen & np.isfinite(values)
    return np.asarray(np.sqrt(np.sum(np.where(used, values, 0.0) ** 2, axis=0) / np.maximum(used.sum(axis=0), 1)))


def _mean(values: Array, chosen: BoolArray) -> Array:
    """(D,) over the chosen samples that are finite; 0 where there are none."""
    used = chosen & np.isfinite(values)
    return np.asarray(np.sum(np.where(used, values, 0.0), axis=0) / np.maximum(used.sum(axis=0), 1))


def _step(own: Balance) -> float:
    """[s]"""
    return float((own.time[-1] - own.time[0]) / max(len(own.time) - 1, 1))
