"""What is told together, and how well a planned motion has to tell two effects apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, judgement

MISSING = "docs/decisions/0005-missing-effects.md"
RULES = "docs/decisions/0011-rules-of-single-effects.md, the motion that would tell"


@final
@dataclass(frozen=True)
class Telling:
    """Of findings that are already made."""

    joints: int = criterion(3, "joints", "an effect with one cause on fewer is told joint by joint", judgement(MISSING))
    of_joints: float = criterion(0.5, "1", "of all joints, from which on it is told as one", judgement(MISSING))
    axes: int = criterion(
        4, "axes", "of a sensor's six, from which on an effect with one cause is told as one", judgement(MISSING)
    )
