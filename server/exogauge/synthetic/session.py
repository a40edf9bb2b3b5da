"""The session in which all logs were recorded, one after the other: when each began, and how warm the drives were."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.log_plans import LogPlan

Array = NDArray[np.float64]

PAUSE_S = 45.0  # from one log to the next
DONNING_S = 120.0  # the same, where the suit is put on for it
WARM_UP_S = 1200.0  # time constant of a drive's windings and grease


@final
@dataclass(frozen=True)
class Session:
    """start_s: when each log began, by its name. end_s: of the last. reference: warmth in the identification logs."""

    start_s: Mapping[str, float]
    end_s: float
    reference: float

    def warmth(self, time_s: Array | float) -> Array:
        """0 when the session begins, 1 when it ends; first order. time_s: from its beginning."""
        return np.asarray(np.expm1(-np.asarray(time_s) / WARM_UP_S) / np.expm1(-self.end_s / WARM_UP_S))

    def warmer(self, time_s: Array | float) -> Array:
        """Warmth above that of the identification logs: parameters are what they were there, on the average."""
        return self.warmth(time_s) - self.reference


def session(plans: Sequence[LogPlan]) -> Session:
    """Logs in the order in which they are listed."""
    start_s, now = {}, 0.0
    for plan in plans:
        now += DONNING_S if plan.suit else PAUSE_S
        start_s[plan.name] = now
        now += plan.duration_s
    cold = Session(start_s, max(now, 1.0), 0.0)
    fitted = [plan for plan in plans if plan.role == "identification"]
    middles = np.array([start_s[plan.name] + plan.duration_s / 2 for plan in fitted])
    weights = np.array([plan.duration_s for plan in fitted])
    reference = float(np.average(cold.warmth(middles), weights=weights)) if fitted else 0.0
    return Session(start_s, cold.end_s, reference)
