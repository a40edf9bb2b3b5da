"""Which motion is asked for to tell a finding from what else it may be, and when it is enough.

What is told together, and how well a planned motion has to tell two effects apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

RULES = "docs/decisions/0011-rules-of-single-effects.md, the motion that would tell"


@final
@dataclass(frozen=True)
class Planning:
    """evidence: twice the log likelihood by which the true one of the two is expected to stand out."""

    enough: float = criterion(
        10.0, "evidence", "tells two effects apart: odds of 150 to one", derived("2 ln 150 = 10.02")
    )
    longest_s: float = criterion(600.0, "s", "of motion that is worth asking for", judgement(RULES))
    shortest_s: float = criterion(20.0, "s", "that a recording lasts at least", judgement(RULES))
    much_smaller: float = criterion(
        0.1,
        "1",
        "square sum of a rival over that of the finding, below which it is none of the two that may be true",
        judgement(RULES),
    )
    margin: float = criterion(
        0.05, "1", "of the range between a joint's limits, that is kept from either", judgement(RULES)
    )
    of_top: float = criterion(
        0.8, "1", "of the speed limit and the largest torque that a motion may ask for", judgement(RULES)
    )
    times_seen: float = criterion(
        2.0, "1", "times the top speed of the logs that a motion may ask for", judgement(RULES)
    )
    top: float = criterion(0.995, "1", "quantile of speeds that counts as the top one", judgement(RULES))
    slow: float = criterion(
        4.0, "1", "times the speed below which a joint is at rest: slower motion shows in no log", judgement(RULES)
    )
    slow_share: float = criterion(0.02, "1", "of the top speed, below which no motion is asked for", judgement(RULES))
    least_way: float = criterion(0.02, "rad or m", "amplitude of a motion that is worth making", judgement(RULES))
    least_period_s: float = criterion(1.0, "s", "of a sine: faster ones shake the robot", judgement(RULES))
    far: float = criterion(
        1.1, "1", "times the range or speed of the logs, from which on a motion counts as another", judgement(RULES)
    )
    wider: float = criterion(1.5, "1", "price of leaving the range of the logs, in time", judgement(RULES))
    faster: float = criterion(2.5, "1", "price of leaving the speed of the logs, in time", judgement(RULES))
    beside: float = criterion(1.3, "1", "price of moving two joints, in time", judgement(RULES))
    leads: int = criterion(3, "joints", "that are swept where no joint is in question", judgement(RULES))
    companions: int = criterion(
        2, "joints", "that are moved beside the one in question, one after the other", judgement(RULES)
    )

    drawn: int = criterion(
        4,
        "motions",
        "of the whole robot, of each pace, that are drawn within its bounds, where its file tells them",
        judgement(RULES),
    )
    calm_hz: float = criterion(
        0.25, "Hz", "up to which calm ones move: at a passage of two seconds a joint is steady", judgement(RULES)
    )
    varied: int = criterion(
        150,
        "times",
        "that the best motion of each sort is changed a little at most, to tell more a second",
        measured(f"{RULES}: 200 gave 1.5 times the evidence of 40"),
    )
    varied_standing: int = criterion(
        40,
        "times",
        "the same of a robot that stands, one motion of which takes some twenty times as long",
        judgement(RULES),
    )
    change: float = criterion(0.3, "1", "of a motion's sizes, by which it is changed at first", judgement(RULES))
    least_change: float = criterion(
        0.01, "1", "of them, below which nothing more is looked for: a joint does not follow closer", judgement(RULES)
    )
    unseen: float = criterion(
        0.1, "1", "of the top speed, for joints that hardly moved in the logs while others are told", judgement(RULES)
    )
    level_m: float = criterion(
        0.01,
        "m",
        "height between corners of soles, above which the feet stood otherwise than the file says",
        judgement(RULES),
    )
    handed_hz: float = criterion(50.0, "Hz", "of the motion that is handed out as a table", judgement(RULES))
    no_limit: float = criterion(
        1e6, "N·m, rad/s", "of a joint's largest torque or speed, from which on its maker states none", judgement(RULES)
    )
    looked_hz: float = criterion(
        50.0,
        "Hz",
        "at which motions are looked at before they are weighed: at 20 a turn of .3 s was over its bound in between",
        measured("tests/bench/tell_apart_poor.py"),
    )
    checked_hz: float = criterion(200.0, "Hz", "at which the one that is told keeps every bound", judgement(RULES))


MISSING = "docs/decisions/0005-missing-effects.md"


@final
@dataclass(frozen=True)
class Telling:
    """Of findings that are already made."""

    joints: int = criterion(3, "joints", "an effect with one cause on fewer is told joint by joint", judgement(MISSING))
    of_joints: float = criterion(0.5, "1", "of all joints, from which on it is told as one", judgement(MISSING))
    axes: int = criterion(
        4, "axes", "of a sensor's six, from which on an effect with one cause is told as one", judgement(MISSING)
    )
