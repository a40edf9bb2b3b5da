"""What decides when a file of captured motion is read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class MotionImport:
    """shortest_m, tallest_m: feet to head of a person that stands; beyond 98 % of adults, bent postures included in
    the 90th percentile over time that is compared. no_body: times that far off it is no person's unit: the nearest two
    units, in and cm, lie 2.5 apart. upright: share of the way from feet to head that must lie along one
    axis before it is taken as up; a bend of 45° leaves .7. uneven: share of a sample by which a clock may stray.
    spline_s: longest gap that a spline closes; a body's fastest parts swing at 2 Hz, half a swing is not guessed.
    beside: samples on each side that the spline goes through. rigid_m: rms by which the other markers of a segment may
    miss a rigid motion before they carry a lost one; skin moves by 1 to 2 cm.
    low_m, slow_m_per_s: a foot's point that is no higher above its own floor and no faster stands; a foot that swings
    passes 1 m/s, one that stands sways by some cm/s. smooth_s: over which speed is taken. shortest_step_s: shorter
    stands and steps are flicker; a fast step takes .3 s. level: cosine of how far from level the hips, or from upright
    the trunk, may be in a skeleton's rest pose; another axis up leaves 0. Legs that reach down by less than that share
    of their length are folded up. farthest_m: from the origin; what lies beyond was not seen, as some programs write
    9999999 there; no capture volume is as large."""

    shortest_m: float = 0.9
    tallest_m: float = 2.3
    no_body: float = 3.0
    no_giant_m: float = 3.0  # judgement: a person of 1.2 m or more, whose centimetres were read as inches
    upright: float = 0.8
    level: float = 0.5
    uneven: float = 0.1
    farthest_m: float = 1000.0
    most_bytes: int = 2_000_000_000
    most_points: int = 20_000_000
    spline_s: float = 0.1
    beside: int = 8
    rigid_m: float = 0.02
    low_m: float = 0.05
    slow_m_per_s: float = 0.3
    smooth_s: float = 0.05
    shortest_step_s: float = 0.1
    least_turn_deg: float = (
        3.2  # judgement: π in radians, by which no joint of a body turns; a motion in degrees has more
    )
    least_foot_m: float = 0.03  # judgement: a foot's bone that reaches less far ahead says not where ahead is
    same_place: float = 0.001  # judgement: of the longest bone; what programs round a bone's place to is less
    same_rate: float = 0.05  # judgement: 59.94 Hz are stated as 60; a resampled table or milliseconds are farther off
    rounded_s: float = 0.00101  # times written to the millisecond stray by one from a line between two of them
    rounded: float = 0.3  # share of a sample that they may; a frame that is lost leaves half of one
    widest_m: float = 10.0  # judgement: markers of no known name that reach farther up are no person's, nor a thing's
    quaternion: float = 0.01  # judgement: of its length; files write four decimals, other numbers are farther off
    longest_frame_s: float = 1.0  # judgement: whoever moves is not captured so; milliseconds that were read as seconds
    looked_at: int = 2000  # frames or so, by which a body's height and its up are told
    shortest_frame_s: float = 1e-5  # judgement: of cameras the fastest take some thousand a second
    largest_number: float = 1e12  # judgement: programs write 9999999 for what they do not know, and no turn is larger
    largest_angle_rad: float = 12.6  # two turns: what is larger was written in degrees
    leap_m: float = 0.06  # measured: by which a step of a marker differs from those beside it; recordings 5 cm at most
    jerk_m_per_s3: float = 2000.0  # judgement: of a foot that runs; of one that walks 390 were measured
    most_leap: float = 0.5  # judgement: of what is seen in both frames; the body is elsewhere, and not a marker
    held_frames: int = 2  # frames that repeat the one before: one does so by chance where numbers are rounded
    held_m: float = 0.02  # judgement: by which the others of its part move meanwhile; a foot turns about one that rests
    fast_m_per_s2: float = 20.0  # measured: rms of a point of the trunk; recordings 5, ten times as fast 37
    fast_s: float = 0.05
    lands: float = 0.25  # judgement: of the way that two would have gone which have not exchanged their places
    apart_least_m: float = 0.02  # judgement: twice the distance of two markers; below noise turns a way round
    slow_s: float = 1.0
    slow_hz: float = 0.12  # measured: trunks over their feet .5 to .8, ten times as slow .06 to .1
    strays_m: float = 0.03  # measured: by which a marker leaps against the others of pelvis or thorax; recordings 2 cm
    moves_m: float = 0.05  # judgement: of what moves less a rate is told by noise
    usual_hz: tuple[float, float] = (20.0, 1000.0)  # judgement: cameras and suits run at 24 to 500
    crossed: float = 0.9  # judgement: of frames in which a left point lies to the right of its fellow; legs cross too
    apart_m: float = 0.03  # judgement: two that are nearer say not which is left


USUAL = MotionImport()
