"""Which logs a case has, what each is for, and which show the same motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

DURATION_S = 25.0


@final
@dataclass(frozen=True)
class LogPlan:
    """path: logs of one path show the same motion. motion: its name, where logs are compared by it."""

    name: str
    role: str
    path: int
    motion: str | None = None

    @property
    def worn(self) -> bool:
        return self.role == "with_device"


PLAIN = (
    *(LogPlan(f"id_{n + 1}", "identification", n) for n in range(4)),
    *(LogPlan(f"val_{n + 1}", "validation", 4 + n) for n in range(2)),
)
WITH_DEVICE = (  # in the order in which they were recorded
    *(LogPlan(f"id_{n + 1}", "identification", n) for n in range(3)),
    LogPlan("val_1", "validation", 3),
    LogPlan("reach_plain", "without_device", 4, "reach"),
    LogPlan("reach_worn_1", "with_device", 4, "reach"),
    LogPlan("reach_worn_2", "with_device", 4, "reach"),
    LogPlan("sway_plain", "without_device", 5, "sway"),
    LogPlan("sway_worn", "with_device", 5, "sway"),
)
