"""One device in several labs: what counts as agreement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import convention, criterion, derived

ISO = "ISO 5725-2:2019, 6.3.4: at least eight laboratories"


@final
@dataclass(frozen=True)
class BetweenLabs:
    by_chance: float = criterion(
        0.05, "1", "probability of Cochran's Q by chance below which labs are said to differ", convention("5 % test")
    )
    interval: float = criterion(
        0.95, "1", "that the interval of the standard deviation between labs holds", convention("95 % interval")
    )
    fewest: int = criterion(2, "labs", "below which nothing is said", derived("Q has labs - 1 degrees of freedom"))
    settled: int = criterion(8, "labs", "below which what is said is provisional", convention(ISO))


USUAL = BetweenLabs()
