"""What both approaches find on logs without a device, where the truth is zero: how far they can be believed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from exogauge.identification.model import RobotModel
from exogauge.support.at_rest import bridged
from exogauge.support.balance import Balance
from exogauge.support.same_motion import Match, Posture, match
from exogauge.support.settings import SupportSettings

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Plain:
    """A log without the device, ready to be compared with. posture: of the joints asked about."""

    balance: Balance
    posture: Posture
    motion: str | None

    @property
    def name(self) -> str:
        return self.balance.prepared.log.name


@final
@dataclass(frozen=True)
class Difference:
    """torque: (T, D) [N·m] this run minus the other at the same posture, NaN where the other has none, and where one of
    them is left out.

    compared: (T, D) both move steadily with the same friction. rest: (T, D) sum of both runs' shares at rest.
    nearest: (T,) sample of the other run.
    """

    torque: Array
    compared: BoolArray
    rest: Array
    nearest: NDArray[np.intp]


def difference(this: Balance, other: Balance, found: Match) -> Difference:
    """Approach A in full: both runs' unexplained torque, subtracted after alignment.

    Implements [Evaluator] (3). Differs from print: with the difference of the contact forces and of Y_j φ, so that
    the feet may be loaded differently and the motions need not be equal to the last digit (equations.md).
    """
    since = this.time - this.time[0] + found.lag_s
    clock = other.time - other.time[0]
    covered = np.zeros(len(since), dtype=np.bool_)
    covered[found.first : found.last] = True
    covered &= ~this.left_out
    at = np.clip(since, 0.0, clock[-1])
    nearest = np.clip(np.round(np.interp(at, clock, np.arange(len(clock)))).astype(np.intp), 0, len(clock) - 1)
    covered &= ~other.left_out[nearest]
    torque = this.torque - np.asarray(make_interp_spline(clock, other.torque, k=3)(at))
    same = np.all(this.sign == other.sign[nearest], axis=2)
    return Difference(
        torque=np.where(covered[:, None], torque, np.nan),
        compared=covered[:, None] & this.steady & other.steady[nearest] & same,
        rest=this.rest + other.rest[nearest],
        nearest=nearest,
    )


@final
@dataclass(frozen=True)
class Repeatability:
    """(D,) each [N·m], RMS of what ought to be zero; steady: in steady motion, other: at starts, stops and turns.

    by_model: approach B's, on logs without the device; between_runs: approach A's, between two of them, None where
    there is only one. Without a suffix: over all samples. What is left out (`Log.left_out`) is in none.
    """

    by_model_steady: Array
    by_model_other: Array
    between_runs_steady: Array | None
    between_runs_other: Array | None
    by_model: Array
    between_runs: Array | None


def repeatability(plains: Sequence[Plain], held: Array, settings: SupportSettings) -> Repeatability:
    """From logs without the device of one motion (or, for want of those, of any). held: (D,) friction at rest."""
    balances = [plain.balance for plain in plains]
    torque, steady = (np.concatenate([getattr(b, name) for b in balances]) for name in ("torque", "steady"))
    moving = np.concatenate([~(b.at_rest | b.left_out[:, None]) for b in balances])
    whole = np.concatenate([~b.left_out for b in balances])[:, None] & np.ones_like(steady)
    pairs = [
        difference(this.balance, other.balance, match(this.posture, other.posture, settings))
        for this, other in itertools.pairwise(plains)
        if this.motion is not None and this.motion == other.motion
    ]
    runs = None
    if pairs:
        apart = np.concatenate([pair.torque for pair in pairs])
        compared = np.concatenate([pair.compared for pair in pairs])
        runs = apart, compared, np.concatenate([pair.rest for pair in pairs]) < 0.5
    return Repeatability(
        _rms(torque, steady),
        _rms(torque, moving & ~steady),
        None if runs is None else _rms(runs[0], runs[1]),
        None if runs is None else _rms(runs[0], runs[2] & ~runs[1]),
        _rms(np.concatenate([bridged(b.torque, b.steady, b.rest * held) for b in balances]), whole),
        None if runs is None else _rms(runs[0], np.ones_like(runs[1])),
    )


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
