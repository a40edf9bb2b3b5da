"""What decides whether a log is of a planned motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

RULE = "docs/motion.md, a log that is known again"


@final
@dataclass(frozen=True)
class Following:
    """Of a log against the plans that a study, or its lab, has."""

    moves: float = criterion(
        0.02, "rad or m", "that a joint of a plan moves at least to be compared: more than creeping", judgement(RULE)
    )
    covered: float = criterion(
        0.8, "1", "share of a plan that a log holds at least: a log may begin late or end early", judgement(RULE)
    )
    follows: float = criterion(
        0.05,
        "1",
        "of the plan's own motion (rms about its means) by which a log that follows it may stray (rms)",
        measured("docs/motion.md: runs of the sample stray by 2 to 3 %, from another plan of the same capture by 9 %"),
    )
    perhaps: float = criterion(
        0.2, "1", "the same, up to which it is left undecided: twice as far as plans of one capture", judgement(RULE)
    )
    nearer: float = criterion(
        2.0,
        "1",
        "times as far as from the nearest plan that a log is from the next; below, it may be of either",
        derived("nearer to one point than half their distance to another is at most half as far from the first"),
    )
    search_hz: float = criterion(
        10.0,
        "Hz",
        "at which the place of a plan in a log is looked for: motions of a trunk end at 5 Hz",
        judgement(RULE),
    )
