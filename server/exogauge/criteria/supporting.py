"""Supporting torque: which estimate a headline number comes from, and when two estimates contradict each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement

RULES = "docs/decisions/0004-supporting-torque.md"


@final
@dataclass(frozen=True)
class Supporting:
    """z: difference over its standard deviation, of the logarithms of two RMS."""

    peak_s: float = criterion(
        0.2, "s", "over which a peak is a mean: the largest of many noisy samples is too large", judgement(RULES)
    )
    memory_s: float = criterion(
        1.0,
        "s",
        "how long an error lasts that is not of the robot's parameters: means over less do not average it out",
        judgement(RULES),
    )
    equal: float = criterion(
        2.0,
        "z",
        "a smaller difference of two null tests leaves open which estimate is better",
        derived("normal distribution, 95.4 %"),
    )
    known: float = criterion(
        0.5,
        "1",
        "std over the value (over the largest stretch, for a length) up to which the data decide it, and cross-checks "
        "compare it",
        judgement(RULES),
    )
    false_alarms: float = criterion(
        0.01,
        "1",
        "probability that any of a device's cross-checks fails by chance; each has its share of it, both sides",
        derived("normal distribution, Bonferroni"),
    )
