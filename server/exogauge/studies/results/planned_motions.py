"""Planned motions as results.json and their tables hold them: one file each, to be moved along as it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from exogauge.findings.planned_motion import PlannedMotion
from exogauge.findings.result import Discrepancy, Finding
from exogauge.studies.csv_table import csv_table
from exogauge.studies.words.finding_sentences import planned_sentence

PLANNED = "planned_motion_*.csv"
PLACES = 5  # decimals: 10 µrad


def planned_files(found: Discrepancy | None) -> Iterator[tuple[str, PlannedMotion]]:
    """`planned_motion_1` …, in the order of the findings."""
    plans = [plan for finding in (found.findings if found else ()) for plan in finding.plans]
    for number, plan in enumerate(plans, 1):
        yield f"planned_motion_{number}", plan


def file_name(name: str) -> str:
    return f"{name}.csv"


def planned_entries(finding: Finding, first: int) -> list[dict[str, Any]]:
    """`planned[]` of a finding; first: number of its first file."""
    return [_entry(plan, file_name(f"planned_motion_{number}")) for number, plan in enumerate(finding.plans, first)]


def motion_table(plan: PlannedMotion) -> bytes:
    """One repeat. t [s], then `q.<joint>` [rad, or m of a prismatic joint] of every joint, moved or not."""
    columns = ("t", *(f"q.{name}" for name in plan.joints))
    rows: Sequence[Sequence[float]] = np.round(np.column_stack([plan.time, plan.q]), PLACES).tolist()
    return csv_table(columns, rows)


def _entry(plan: PlannedMotion, file: str) -> dict[str, Any]:
    sweep = plan.sweep
    return {
        "file": file,
        "joint": plan.joint,
        "kind": sweep.kind,
        "amplitude": sweep.amplitude,
        "offset": sweep.offset,
        "slowest": sweep.slowest,
        "fastest": sweep.fastest,
        "period_s": sweep.period or None,
        "unit": plan.unit,
        "companion": {"joint": plan.companion, "range": list(plan.companion_range)} if plan.companion else None,
        "repeats": plan.repeats,
        "duration_s": plan.duration,
        "tells_from": [each.rival for each in plan.pairs],
        "sentence": planned_sentence(plan),
    }
