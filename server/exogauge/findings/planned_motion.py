"""A motion that was planned to tell a finding from what else it may be, and how well it would."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.words import effect_words
from exogauge.findings.sweeps import Sweep

Array = NDArray[np.float64]

SURE = 10.0  # evidence (twice the log likelihood) that tells two effects apart: odds of 150 to one
LONGEST = 600.0  # [s] of motion that is worth asking for
ALIKE = 0.02  # of an effect left beside the other, below which they count as one


@final
@dataclass(frozen=True)
class Apart:
    """How far a finding and one rival are apart, computed before any such motion is recorded.

    rival: `stribeck`; place: where it would sit, in words. left_now: share of the effect, once the model's own
    parameters are fitted again, that the other one does not take as well, 0…1, in these logs; left_then: with the
    planned motion. Of finding and rival, whichever is harder to see beside the other.
    evidence_now, evidence: twice the log likelihood by which the true one of the two stands out, to be expected of
    these logs, and what the motion adds; rate: the same per 10 s. seconds: of the motion until that is `SURE`, None
    where no motion that was tried does so within `LONGEST`.
    """

    rival: str
    place: str
    left_now: float
    left_then: float
    evidence_now: float
    evidence: float
    rate: float
    seconds: float | None


@final
@dataclass(frozen=True)
class PlannedMotion:
    """What to record next. joint: that is swept. companion: that moves slowly beside it to change its load, or "".

    sweep: of the joint. repeats: how often the whole is to be moved; duration: [s] of all repeats. unit: `rad` or `m`.
    time: (T,) [s] of one repeat; joints: (J,) names; q: (T, J) [rad or m]. pairs: what it tells apart.
    legs_rest: joints that carry the robot stay as they are, and the base stands still.
    """

    joint: str
    companion: str
    companion_range: tuple[float, float]
    sweep: Sweep
    unit: str
    repeats: int
    duration: float
    pairs: tuple[Apart, ...]
    legs_rest: bool
    time: Array
    joints: tuple[str, ...]
    q: Array

    @property
    def sentence(self) -> str:
        """`Move torso_pitch to and fro by ±0.3 rad …: of what tells them apart 12 % was left in these logs, 64 % …`"""
        return " ".join([*self._what(), *self._why(), *self._given()])

    def _what(self) -> list[str]:
        sweep, unit = self.sweep, self.unit
        span = f"±{sweep.amplitude:.2f} {unit} about {sweep.offset:.2f} {unit}"
        how = {
            "speeds": f"Move {self.joint} to and fro by {span} at steady speeds from {sweep.slowest:.2g} to "
            f"{sweep.fastest:.2g} {unit}/s (shorter ways where it is slow)",
            "sine": f"Swing {self.joint} by {span} with a period of {sweep.period:.2g} s, "
            f"at {sweep.fastest:.2g} {unit}/s at most",
            "small": f"Move {self.joint} to and fro by small ways at {sweep.slowest:.2g} {unit}/s, at several places "
            f"within {span}",
        }[sweep.kind]
        low, high = self.companion_range
        beside = (
            f", while {self.companion} moves slowly from {low:.2f} to {high:.2f} and back" if self.companion else ""
        )
        return [f"{how}{beside}, for {self.duration:.0f} s."]

    def _why(self) -> list[str]:
        return [f"{shares(each)}{evidence(each)}" for each in self.pairs]

    def _given(self) -> list[str]:
        legs = "The base and the joints that carry it stay still. " if self.legs_rest else ""
        return [
            f"Record it twice and hold one of the two out. {legs}Every joint's own limits are kept; whether the robot "
            "would touch itself is not known."
        ]


def shares(pair: Apart) -> str:
    """How much more of what sets them apart there would be; nothing where the share does not grow."""
    if pair.left_then <= pair.left_now:
        return ""
    then = f"{percent(pair.left_now)} was left in these logs, {percent(pair.left_then)} would be. "
    return f"Of what tells it from {effect_words(pair.rival)} {then}"


def evidence(pair: Apart) -> str:
    holds = f"{pair.evidence_now:.1f}" if pair.evidence_now < 9.95 else f"{pair.evidence_now:.0f}"
    these = f"Between it and {effect_words(pair.rival)} these logs hold evidence of {holds}"
    return f"{these}; this adds {pair.evidence:.0f}, where {SURE:.0f} is enough."


def not_told(pair: Apart) -> str:
    """That no motion helps."""
    never = f"No motion that was tried tells it from {effect_words(pair.rival)} at {pair.place}"
    if pair.left_then < ALIKE:
        return f"{never}: on each of them both look the same."
    left = f"{percent(pair.left_then)} of what tells them apart would be left, which is small beside the noise"
    return f"{never} within {LONGEST / 60.0:.0f} minutes: {left}."


def percent(share: float) -> str:
    """`12 %`, `below 0.1 %`."""
    value = 100.0 * share
    return "below 0.1 %" if value < 0.1 else f"{value:.1f} %" if value < 9.95 else f"{value:.0f} %"
