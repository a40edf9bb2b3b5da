"""When logs are said to have been low-passed before they were stored, and how that filter is sought."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, judgement

RULES = "docs/decisions/0011-rules-of-single-effects.md, stored low-passes"


@final
@dataclass(frozen=True)
class StoredFilter:
    """What is asked of held-out logs is in `Judging`."""

    most: float = criterion(
        0.5,
        "1",
        "of the middle joint's square error: little else takes that from all joints, and `judging.sure` will do",
        judgement(f"{RULES}: made on 18 cases"),
    )
    joints: float = criterion(
        0.75,
        "1",
        "of the joints have to gain: every joint passes a stored low-pass, presliding is one's own",
        judgement(RULES),
    )
    alike: float = criterion(1.5, "1", "ratio of the edges of logs that were stored alike", judgement(RULES))
    widths: float = criterion(
        3.0, "1", "factor around the usual shape's cut-off in which that of another shape is sought", judgement(RULES)
    )
    above_edge: float = criterion(4.0, "edges", "the highest cut-off that is tried", judgement(RULES))
    lowest_hz: float = criterion(
        0.5,
        "Hz",
        "the lowest that is tried: a gentle low-pass begins far below where its fall is seen",
        judgement(RULES),
    )
    coarse: float = criterion(1.25, "1", "factor from one cut-off that is tried first to the next", judgement(RULES))
    fine: int = criterion(9, "cut-offs", "tried around the best of them", judgement(RULES))
    near: float = criterion(1.2, "1", "factor to either side within which these lie", judgement(RULES))
    turn_s: float = criterion(0.1, "s", "a joint that turns round at once is at rest for no longer", judgement(RULES))
    forgotten_s: float = criterion(
        0.5, "s", "after a rest, and before one: by then a low-pass holds nothing of it", judgement(RULES)
    )
    least_s: float = criterion(
        2.0, "s", "of turns and motion; a joint with less is looked at as a whole", judgement(RULES)
    )
