"""The report's table of planned motions and the logs that are of them, in text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from exogauge.studies.words.rounding import significant

SHOWN_JOINTS = 5  # of a log, those that stray farthest; all stand in results.json


@final
@dataclass(frozen=True)
class PlanRow:
    """One joint of one log, in text; head: of the log's first row."""

    plan: str
    log: str
    begins: str
    head: bool
    joint: str
    rms: str
    most: str
    at: str
    later: str
    unit: str


def plan_rows(entries: Sequence[Mapping[str, Any]]) -> list[PlanRow]:
    """entries: `plans` of results.json."""
    rows = []
    for plan in entries:
        for log in plan["logs"]:
            if log["state"] != "follows":
                continue
            for k, each in enumerate(log["joints"][:SHOWN_JOINTS]):
                later = "" if each["later_s"] is None else f"{1e3 * each['later_s']:.0f}"
                rows.append(PlanRow(
                    plan["plan"], log["log"], f"{log['begins_s']:.3f}", k == 0, each["joint"],
                    significant(each["rms"], 2), significant(each["most"], 2), f"{each['at_s']:.2f}", later,
                    each["unit"],
                ))  # fmt: skip
    return rows
