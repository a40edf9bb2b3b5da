"""What is missing beside a rigid payload behind an ideal sensor: what a name has to hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

PAYLOAD = "docs/payload.md"


@final
@dataclass(frozen=True)
class Carrying:
    """evidence: log likelihood, less half the logarithm of the samples for every number, less that of all tried."""

    worth: float = criterion(
        6.0, "log odds", "odds of four hundred to one beyond the number of candidates", derived("exp 6 = 403")
    )
    rival: float = criterion(10.0, "log odds", "a lead of less leaves another explanation as good", judgement(PAYLOAD))
    most: int = criterion(4, "effects", "more of one payload are a model that does not hold", judgement(PAYLOAD))
    judged: int = criterion(
        8, "candidates", "best of a round that are held against what was not fitted", judgement(PAYLOAD)
    )
    slow_s: float = criterion(
        0.2,
        "s",
        "means over it hold the motion and hardly the errors of smoothed accelerations, which are faster",
        measured(f"{PAYLOAD}: the sample's arm, whose smoother errs at 5 to 8 Hz"),
    )
