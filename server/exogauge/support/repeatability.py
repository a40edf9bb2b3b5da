"""What every approach finds on logs without a device, where the truth is zero: how far they can be believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.support.at_rest import bridged
from exogauge.support.balance import Balance
from exogauge.support.difference import difference
from exogauge.support.inputs import Doubts, Inputs, sloped_samples
from exogauge.support.paired import paired
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

    RMS of the number that is told in steady motion, elsewhere, and over all samples. lasting: regime -> (D,) [s].
    Beyond what is known to be in doubt, which stands beside it in every number: beyond, RMS by regime, of them `moves`,
    elsewhere, of A at starts, stops and turns alone, as what it holds at rest has a doubt of its own; mean, RMS over
    the logs of their means in steady motion. A log errs alike throughout, so that its mean is one draw: what chance
    may be is none.
    """

    steady: Array
    other: Array
    whole: Array
    beyond: Mapping[str, Array]
    mean: Array
    lasting: Mapping[str, Array]


@final
@dataclass(frozen=True)
class Repeatability:
    """b: on logs without the device. a, paired: on the first of them against the last of the same motion, so that what
    drifts is in them; None where there is only one."""

    b: Null
    a: Null | None
    paired: Null | None

    @property
    def by_approach(self) -> Mapping[str, Null]:
        found = {"a": self.a, "b": self.b, "paired": self.paired}
        return {name: each for name, each in found.items() if each is not None}

    def spread(self, approach: str) -> tuple[Array, Array]:
        """(D,) each [N·m] of approach `a`, `b` or `paired`, in steady motion and elsewhere, beyond what is known to be
        in doubt. From one log without the device only, the model's error stands in for what compares runs, once for
        each run."""
        found, runs = self.by_approach.get(approach), 1.0
        if found is None:
            found, runs = self.b, np.sqrt(2.0)
        return runs * found.beyond["steady"], runs * found.beyond["moves"]

    @property
    def between_runs_steady(self) -> Array:
        """(D,) [N·m] of approach A; from one log only the model's error stands in, once for each run."""
        return np.asarray(np.sqrt(2.0) * self.b.steady if self.a is None else self.a.steady)


def repeatability(
    plains: Sequence[Plain], held: Array, settings: SupportSettings, doubts: Doubts | None = None
) -> Repeatability:
    """From logs without the device of one motion (or, for want of those, of any). held: (D,) friction at rest. doubts:
    what of it stands beside it anyhow."""
    by_b, by_a, by_pair = list[_Seen](), list[_Seen](), list[_Seen]()
    inputs = dict[str, tuple[Inputs, IntArray]]()  # of those that were not fitted
    for plain in plains:
        own = plain.balance
        whole = ~own.left_out[:, None] & np.ones_like(own.steady)
        told = bridged(own.torque, own.steady, own.rest * held)
        seen = _Seen(told, own.steady & whole, ~own.steady & whole, _step(own))
        if doubts is not None and plain.held_out:
            sloped = sloped_samples(own.prepared)
            inputs[plain.name] = doubts.inputs(own.prepared, sloped), sloped
            seen = seen.less(doubts, *inputs[plain.name])
        by_b.append(seen)
    for first, last in _first_and_last(plains):
        this, other = first.balance, last.balance
        apart = difference(this, other, match(first.posture, last.posture, settings))
        pair = paired(this, other, apart, held)
        a = _Seen(apart.torque, apart.compared, ~apart.compared, _step(this), moves=apart.rest < 0.5)
        both = _Seen(pair.torque, this.steady, ~this.steady, _step(this))
        if doubts is not None and first.name in inputs and last.name in inputs:
            at_first, sloped = inputs[first.name]
            partner = doubts.inputs(other.prepared, apart.nearest[sloped])
            a = a.less(doubts, at_first.less(partner), sloped)
            both = both.less(doubts, at_first.less(partner, pair.from_partner), sloped)
        by_a.append(a)
        by_pair.append(both)
    sure = 0.0 if doubts is None else doubts.model.criteria.support.equal
    b = _null(by_b, sure)
    assert b is not None
    return Repeatability(b, _null(by_a, sure), _null(by_pair, sure))


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
    RMS is taken where rest has a doubt of its own. known: (T, D) [N²·m²] of each sample what is known to be in doubt,
    of_mean: regime -> (D,) the same of the mean over it."""

    told: Array
    steady: BoolArray
    other: BoolArray
    step_s: float
    moves: BoolArray | bool = True
    known: Array | float = 0.0
    of_mean: Mapping[str, Array] = field(default_factory=dict)

    def less(self, doubts: Doubts, inputs: Inputs, sloped: IntArray) -> _Seen:
        """Beyond what is in doubt of this log anyhow."""
        of_mean = {name: doubts.of_means(inputs, sloped, chosen) for name, chosen in self.windows.items()}
        return replace(self, known=doubts.of_samples(inputs, sloped, len(self.told)), of_mean=of_mean)

    @property
    def windows(self) -> Mapping[str, BoolArray]:
        moves, whole = self.other & self.moves, self.steady | self.other
        return {"steady": self.steady, "other": self.other, "moves": moves, "whole": whole}


def _null(seen: Sequence[_Seen], sure: float) -> Null | None:
    if not seen:
        return None
    told = np.concatenate([each.told for each in seen])
    regimes = {name: np.concatenate([each.windows[name] for each in seen]) for name in ("steady", "other", "whole")}
    step = np.concatenate([np.full(len(each.told), each.step_s) for each in seen])[:, None]
    lasting = {name: np.sum(step * (chosen & np.isfinite(told)), axis=0) for name, chosen in regimes.items()}
    size = {name: _rms(told, chosen) for name, chosen in regimes.items()}
    beyond = {name: _beyond(seen, name, sure) for name in seen[0].windows}
    return Null(
        **size, beyond={name: each for name, (each, _) in beyond.items()}, mean=beyond["steady"][1], lasting=lasting
    )


def _beyond(seen: Sequence[_Seen], regime: str, sure: float) -> tuple[Array, Array]:
    """(D,) each: RMS beyond what is known to be in doubt, and the part of it that logs have on the average."""
    within, of_means, known, samples = (np.zeros(seen[0].told.shape[1]) for _ in range(4))
    for each in seen:
        used = each.windows[regime] & np.isfinite(each.told)
        count, at_mean = used.sum(axis=0), each.of_mean.get(regime, 0.0)
        mean = np.sum(np.where(used, each.told, 0.0), axis=0) / np.maximum(count, 1)
        within += np.sum(np.where(used, (each.told - mean) ** 2 - (each.known - at_mean), 0.0), axis=0)
        of_means += count * mean**2
        known += count * at_mean
        samples += count
    told, within = beyond_chance(of_means, known, sure), np.maximum(within, 0.0)
    return np.sqrt((within + told) / np.maximum(samples, 1)), np.sqrt(told / np.maximum(samples, 1))


def beyond_chance(square: Array | float, known: Array | float, sure: float) -> Array:
    """What a square has beyond a variance that is known, where it is more than chance: `sure` standard deviations."""
    return np.where(np.asarray(square) > sure**2 * np.asarray(known), np.asarray(square) - known, 0.0)


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


def _step(own: Balance) -> float:
    """[s]"""
    return float((own.time[-1] - own.time[0]) / max(len(own.time) - 1, 1))
