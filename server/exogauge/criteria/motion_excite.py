"""What decides when a motion is planned from which a robot is identified well."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class MotionExcite:
    """top_hz: of the series' harmonics: a robot's drives follow it, and its log's low-pass leaves it whole, turns
    round seldom enough to move steadily between. standing_hz: likewise of a robot that stands: its balance binds before
    its joints fill their ranges, and half of it left 1.3 times the doubt.
    per_period: samples per period of the fastest harmonic while planning: between them a sine is 3 % higher at most.
    kept: share of every bound that is used then.
    margin_m, friction, least_weight: of standing feet, as `MotionPlan`'s; 30 mm, for a motion that nobody has tried.
    clearance_m, look_m: as `MotionPlan`'s.
    turn_s: so near to a turn an axis counts half: .7 periods of a cut-off of 10 Hz.
    slow_share: of the top speed, at which an axis counts half. starts: searches; each begins from the best of
    drawn random motions.
    costs: weights of excess, one after the other; steps: of the search at each. check_hz: at which every bound holds.
    out: cost of what cannot be had at all: beyond what any excess comes to. wild: [rad/s²] of a leg that is all but
    straight.
    halvings: of the amplitude of a random motion. shrinks: at most, of what is found, until it is within all bounds.
    tight: of a bound that has been exceeded, that is used after. smaller: times a motion that breaks one from rest to
    rest, until none is: a step costs at most a twentieth of its size.
    approach_s: from home to the motion's begin, and back. rest_s: at home before and after: what a joint's friction
    holds there is a number too.
    cutoff_hz: of the low-pass that identification chooses as a rule; encoders' noise counts below it.
    unknown_noise: of a joint's largest torque, where no noise of it is stated; known only so far as ratios go.
    rate_hz: of logs, where none is named.
    """

    top_hz: float = 1.0
    standing_hz: float = 2.0
    per_period: int = 12
    kept: float = 0.98
    margin_m: float = 0.03
    friction: float = 0.5
    least_weight: float = 0.3
    clearance_m: float = 0.01
    look_m: float = 0.03
    turn_s: float = 0.07
    slow_share: float = 0.01
    starts: int = 1
    drawn: int = 6
    costs: tuple[float, ...] = (1e2, 1e3)
    steps: int = 70
    check_hz: float = 1000.0
    out: float = 1e6
    wild: float = 1e4
    halvings: int = 8
    shrinks: int = 6
    tight: float = 0.999
    smaller: float = 0.95
    approach_s: float = 2.0
    rest_s: float = 1.0
    cutoff_hz: float = 10.0
    unknown_noise: float = 0.002
    rate_hz: float = 200.0


USUAL = MotionExcite()
