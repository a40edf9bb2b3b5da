"""`criteria` in results.json: every number that decided, with its reason and its source."""

from __future__ import annotations

from typing import Any

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.criterion import listed


def criteria_entries(criteria: Criteria) -> list[dict[str, Any]]:
    return [
        {
            "name": each.name,
            "value": list(each.value) if isinstance(each.value, tuple) else each.value,
            "unit": each.unit,
            "why": each.why,
            "source": each.source.kind,
            "where": each.source.where,
        }
        for each in listed(criteria)
    ]
