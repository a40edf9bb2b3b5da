"""What the search for missing effects found, as results.json holds it.

Planned motions as results.json and their tables hold them: one file each, to be moved along as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType
from typing import Any

import numpy as np

from exogauge.devices.result import Estimate
from exogauge.findings.basis import OfBand
from exogauge.findings.planned_motion import Apart, PlannedMotion
from exogauge.findings.result import Alternative, Discrepancy, Evidence, Excess, Finding, Lineage, Link, Place
from exogauge.findings.verdict import Objection
from exogauge.studies.csv_table import csv_table
from exogauge.studies.results.support_results import number
from exogauge.studies.words.discrepancy_sentences import left_sentence, moves, verdict_sentence
from exogauge.studies.words.finding_sentences import consequence_words, finding_sentence, where_words
from exogauge.studies.words.motion_sentences import motion_words, planned_sentence
from exogauge.studies.words.names import added_words, capital, channel, parameter_words, step_words, titled
from exogauge.studies.words.reason_sentences import note_words, objection_words, reason_words

NOTHING: Mapping[int, str] = MappingProxyType({})


def discrepancy_entry(found: Discrepancy | None, taken_over: Mapping[int, str] = NOTHING) -> dict[str, Any] | None:
    """`discrepancy`: None where the step was skipped; `steps[]` then says why. taken_over: rank of a
    finding -> file."""
    if found is None:
        return None
    return {
        "verdict": found.verdict,
        "left": found.decision.left,
        "reason": reason_words(found.decision.reason),
        "sentence": verdict_sentence(found),
        "left_sentence": left_sentence(found),
        "findings": [
            _finding(each, 1 + sum(len(before.plans) for before in found.findings[:number]))
            | ({"taken_over": taken_over[each.rank]} if each.rank in taken_over else {})
            for number, each in enumerate(found.findings)
        ],
        "chain": [_link(each) for each in found.chain],
        "wear_chain": [_link(each) for each in found.wear_chain],
        "located": [_excess(each) for each in found.located],
        "unexplained": [_excess(each) for each in found.unexplained],
        "within_declared": [_excess(each) for each in found.declared.channels],
        "rejected": [_alternative(each) for each in found.rejected],
        "lineage": [_version(each, found.findings) for each in found.lineage],
        "candidates": found.candidates,
        "notes": [note_words(each) for each in found.notes],
        "before_after": {
            consequence_words(each): {
                "before": number(each.before),
                "after": number(each.after),
                "moves": moves(each.before, each.after),
            }
            for each in found.before_after
        },
    }


def _finding(finding: Finding, first_plan: int) -> dict[str, Any]:
    return {
        "rank": finding.rank,
        "effect": finding.effect,
        "where": where(finding.place),
        "title": titled(finding.effect, finding.place),
        "parameters": numbers(finding.parameters),
        "parameter_words": {
            name: said for name in finding.parameters if (said := parameter_words(finding.effect, name))
        },
        "held_out": asdict(finding.held_out) | {"channel_words": channel(finding.held_out.channel)},
        "score": finding.score,
        "evidence": finding_sentence(finding),
        "alternatives": [_alternative(each) for each in finding.alternatives],
        "also_possible": [_alternative(each) for each in finding.also_possible],
        "motion": motion_words(finding),
        "apart": [_apart(each) for each in finding.apart],
        "planned": planned_entries(finding, first_plan),
        "curve": _curve(finding.evidence, finding.held_out.unit),
    } | ({"device": finding.basis.device} if isinstance(finding.basis, OfBand) and finding.basis.device else {})


def _apart(apart: Apart) -> dict[str, Any]:
    """Without the criteria that it was judged by: they stand with the others."""
    return {name: value for name, value in asdict(apart).items() if name not in ("enough", "longest")}


def _excess(excess: Excess) -> dict[str, Any]:
    return asdict(excess) | {"where": where_words(excess), "channel_words": channel(excess.channel)}


def _version(version: Lineage, findings: Sequence[Finding]) -> dict[str, Any]:
    """finding: rank of the one that made the version."""
    step = version.added
    made = next((each for each in findings if step and step.what == "effect" and each.effect == step.effect
                 and step.place in (each.place, *each.alike)), None)  # fmt: skip
    return {
        "version": version.version,
        "parent": version.parent,
        "added": step.identifier if step else "",
        "title": capital(added_words(step)) if step else "",
        "finding": made.rank if made else None,
    }


def where(place: Place) -> dict[str, str | bool]:
    """`{"joint": "torso_pitch"}`, `{"sensor": "wrist", "axis": "fx"}`, `{"base": true}`."""
    if place.kind == "base":
        return {"base": True}
    part: dict[str, str | bool] = {"axis": place.part} if place.part else {}
    return {place.kind: place.name} | part


def numbers(found: Mapping[str, Estimate]) -> dict[str, dict[str, Any]]:
    return {name: number(each) for name, each in found.items()}


def _link(link: Link) -> dict[str, Any]:
    step = link.step
    return asdict(link) | {
        "step": step_words(step),
        "what": step.what,
        "effect": step.effect or None,
        "where": where(step.place) if step.place else None,
        "worst_words": channel(link.worst),
    }


def _alternative(other: Alternative) -> dict[str, Any]:
    return {
        "effect": other.effect,
        "where": where(other.place),
        "title": titled(other.effect, other.place),
        "score": other.score,
        "reason": objection_words(other.objection),
        "objection": _objection(other.objection),
    }


def _objection(found: Objection) -> dict[str, Any]:
    sizes = numbers(found.sizes)
    return {"why": found.why.value, "value": found.value, "beside": found.beside, "of": list(found.of), "sizes": sizes}


def _curve(evidence: Evidence, unit: str) -> dict[str, Any]:
    """What the report draws as evidence: mean residuals over the coordinate that the effect depends on."""
    return {
        "coordinate": {"name": evidence.coordinate, "unit": evidence.unit, "values": evidence.at},
        "unit": unit,
        **{name: getattr(evidence, name) for name in ("before", "after", "spread", "model", "along_motion")},
    }


PLANNED = "planned_motion_*.csv"
PLACES = 5  # decimals: 10 µrad


def planned_files(found: Discrepancy | None) -> Iterator[tuple[str, PlannedMotion]]:
    """`planned_motion_1` …, in the order of the findings."""
    plans = [plan for finding in (found.findings if found else ()) for plan in finding.plans]
    for index, plan in enumerate(plans, 1):
        yield f"planned_motion_{index}", plan


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
        "kind": "drawn" if sweep is None else sweep.kind,
        "amplitude": None if sweep is None else sweep.amplitude,
        "offset": None if sweep is None else sweep.offset,
        "slowest": None if sweep is None else sweep.slowest,
        "fastest": None if sweep is None else sweep.fastest,
        "period_s": None if sweep is None else sweep.period or None,
        "unit": plan.unit,
        "companion": {"joint": plan.companion, "range": list(plan.companion_range)} if plan.companion else None,
        "others": list(plan.others),
        "kept": list(plan.kept),
        "unknown": list(plan.unknown),
        "repeats": plan.repeats,
        "duration_s": plan.duration,
        "tells_from": [each.rival for each in plan.pairs],
        "sentence": planned_sentence(plan),
    }
