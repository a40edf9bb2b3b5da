"""What is worth a name: it matters beside the sensors' noise, and is no part of what was named at its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.criteria.searching import Searching
from exogauge.findings.objection import Objection, Why


def gone(before: float, after: float) -> float:
    """RMS that goes with an effect; before, after: RMSE without and with it."""
    return float(np.sqrt(max(before**2 - after**2, 0.0)))


@final
@dataclass(frozen=True)
class Named:
    """An effect at the same place, and the RMS that it took off. same_curve: it depends on the same coordinate."""

    effect: str
    took: float
    same_curve: bool


def not_worth(size: float, floor: float, named: Sequence[Named], criteria: Searching) -> Objection | None:
    """Why an effect that takes this much off the held-out error is not worth a name. floor: of the same channel."""
    if size < criteria.matters * floor:
        return Objection(Why.TOO_SMALL, size, floor)
    for each in named:
        if size < (criteria.of_the_curve if each.same_curve else criteria.remainder) * each.took:
            return Objection(Why.SMALL_BESIDE, of=(each.effect,))
    return None
