"""A motion that was planned to tell a finding from what else it may be: how a joint is swept, and how well it would."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

Kind = Literal["speeds", "sine", "small"]
Bound = Literal["touch", "torque", "balance"]

PASS_S = 3.0  # [s] in one direction at one speed: slow passes are shorter ways
PLACES = 4  # of `small`, over the range
SMALL = 0.04  # of the range: half a small movement


@final
@dataclass(frozen=True)
class Sweep:
    """One joint's part. amplitude, offset: [rad, or m of a prismatic joint]. slowest, fastest: [rad/s] speeds that it
    is to have. period: [s] of a sine, 0 of others. seconds: how long it is repeated."""

    kind: Kind
    amplitude: float
    offset: float
    slowest: float
    fastest: float
    seconds: float
    period: float = 0.0

    @staticmethod
    def small(offset: float, amplitude: float, slowest: float) -> Sweep:
        """Small movements that each take a few seconds at most."""
        slow = max(slowest, 8.0 * SMALL * amplitude / PASS_S)
        return Sweep("small", amplitude, offset, slow, max(4.0 * slow, amplitude / PASS_S), 1.0)

    def position(self, rate_hz: float) -> Array:
        """(T,) from rest at the offset (of a sine: at its lower end) and back."""
        once = {"speeds": self._speeds, "sine": self._sine, "small": self._small}[self.kind](rate_hz)
        times = max(1, round(self.seconds * rate_hz / len(once)))
        return np.tile(once, times)

    def _sine(self, rate_hz: float) -> Array:
        t = np.arange(max(2, round(self.period * rate_hz))) / rate_hz
        return np.asarray(self.offset - self.amplitude * np.cos(2.0 * np.pi * t / self.period))

    def _speeds(self, rate_hz: float) -> Array:
        speeds = 6  # of `speeds`
        legs: list[tuple[float, float]] = []
        for v in np.geomspace(self.slowest, self.fastest, speeds):
            way = min(self.amplitude, 0.5 * v * PASS_S)  # from the middle
            for _ in range(max(1, round(PASS_S * v / (2.0 * way)))):
                legs += [(v, way), (-v, 2.0 * way), (v, way)]
        return self.offset + _travelled(legs, rate_hz)

    def _small(self, rate_hz: float) -> Array:
        legs: list[tuple[float, float]] = []
        way = SMALL * 2.0 * self.amplitude
        places = np.linspace(-self.amplitude + way, self.amplitude - way, PLACES)
        for place, before in zip([*places, 0.0], [0.0, *places], strict=True):
            legs.append((np.sign(place - before) * self.fastest, abs(place - before)))
            if place:
                legs += [(self.slowest, way), (-self.slowest, 2.0 * way), (self.slowest, way)] * 2
        return self.offset + _travelled(legs, rate_hz)


def _travelled(legs: Sequence[tuple[float, float]], rate_hz: float) -> Array:
    """(T,) from rest to rest. legs: (velocity, way) one after the other; speeds change within 0.3 s."""
    turn_s = 0.3  # [s] that a change of speed takes
    edges = np.concatenate([[0.0], np.cumsum([abs(way / v) if v else 0.0 for v, way in legs])])
    at = np.concatenate([[0.0], np.cumsum([np.sign(v) * way for v, way in legs])])
    pause = turn_s  # still before and after
    t = np.arange(-pause, edges[-1] + pause, 1.0 / rate_hz)
    sharp = np.interp(t, edges, at)
    window = np.hanning(max(3, round(turn_s * rate_hz)) + 2)
    half = len(window) // 2
    padded = np.pad(sharp, (half, len(window) - 1 - half), mode="edge")
    return np.convolve(padded, window / window.sum(), mode="valid")


Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Apart:
    """How far a finding and one rival are apart, computed before any such motion is recorded.

    rival: `stribeck`; place: where it would sit, `wrist.fx`. left_now: share of the effect, once the model's own
    parameters are fitted again, that the other one does not take as well, 0…1, in these logs; left_then: with the
    planned motion. Of finding and rival, whichever is harder to see beside the other.
    evidence_now, evidence: twice the log likelihood by which the true one of the two stands out, to be expected of
    these logs, and what the motion adds; rate: the same per 10 s. seconds: of the motion until that is `enough`, None
    where no motion that was tried does so within `longest` [s].
    """

    rival: str
    place: str
    left_now: float
    left_then: float
    evidence_now: float
    evidence: float
    rate: float
    seconds: float | None
    enough: float
    longest: float


@final
@dataclass(frozen=True)
class PlannedMotion:
    """What to record next. joint: that is swept, "" where none is. companion: that moves slowly beside it to change its
    load, or "". others: joints that move as they were drawn, alone or while `joint` is swept.

    sweep: of the joint, None where none is. repeats: how often the whole is to be moved; duration: [s] of all repeats.
    unit: `rad` or `m`. time: (T,) [s] of one repeat; joints: (J,) names; q: (T, J) [rad or m]. pairs: what it tells
    apart. legs_rest: joints that carry the robot stay as they are, and the base stands still. kept: what holds
    beside every joint's own limits: the robot does not touch itself, bears the torques, keeps its balance on both feet;
    unknown: of which that is not known, as its file does not tell enough.
    """

    joint: str
    companion: str
    companion_range: tuple[float, float]
    sweep: Sweep | None
    unit: str
    repeats: int
    duration: float
    pairs: tuple[Apart, ...]
    legs_rest: bool
    time: Array
    joints: tuple[str, ...]
    q: Array
    kept: tuple[Bound, ...]
    unknown: tuple[Bound, ...]
    others: tuple[str, ...] = ()
