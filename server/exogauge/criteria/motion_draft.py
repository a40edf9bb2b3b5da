"""What a draft of a robot's file for motions takes as usual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class MotionDraft:
    """acceleration [rad/s²], jerk [rad/s³]: as of the robots that are known. sole_m: above the lowest point of a foot,
    what is as low stands too. least_sole_m: a rectangle that is narrower is no sole. aside: times as far from the
    middle as the feet are, where an arm's end is at least. lower: share of a leg by which hips come down at home, 6 %
    bend a knee by some 40°. calm: weight of an angle beside a miss, so that one of many postures is found. flat: by
    which a foot may miss, in legs or rad, and by which a knee is ahead [m]. hangs: share of the way from hip to foot
    that lies along z, where z is up. off_stop: share of a range that a joint keeps from its end."""

    acceleration: float = 40.0
    arm_acceleration: float = 10.0  # [rad/s²] judgement: what makers of arms state is 7 to 20
    jerk: float = 2000.0
    sole_m: float = 0.01
    least_sole_m: float = 0.03
    aside: float = 0.9
    lower: float = 0.06
    calm: float = 1e-3
    flat: float = 0.005
    hangs: float = 0.8
    off_stop: float = 0.02
    aside_rad: tuple[float, ...] = (
        0.15,
        0.3,
        0.45,
        0.6,
    )  # judgement: by which arms are taken off the body, tried in turn


USUAL = MotionDraft()
