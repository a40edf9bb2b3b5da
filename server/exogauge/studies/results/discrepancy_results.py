"""What the search for missing effects found, as results.json holds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from exogauge.devices.result import Estimate
from exogauge.findings.result import Alternative, Discrepancy, Evidence, Finding, Link, Place
from exogauge.studies.results.planned_motions import apart_entries, planned_entries
from exogauge.studies.results.support_results import number
from exogauge.studies.words.discrepancy_sentences import left_sentence, step_words, verdict_sentence
from exogauge.studies.words.effect_words import at_place, parameter_words


def discrepancy_entry(found: Discrepancy | None) -> dict[str, Any] | None:
    """`discrepancy`: None where the step was skipped; `steps[]` then says why."""
    if found is None:
        return None
    entry = {
        **asdict(found.decision),
        "findings": [
            _finding(each, 1 + sum(len(before.plans) for before in found.findings[:number]))
            for number, each in enumerate(found.findings)
        ],
        "chain": [_link(each) for each in found.chain],
        "wear_chain": [_link(each) for each in found.wear_chain],
        "located": [asdict(each) for each in found.located],
        "unexplained": [asdict(each) for each in found.unexplained],
        "rejected": [_alternative(each) for each in found.rejected],
        "lineage": [asdict(each) for each in found.lineage],
        "candidates": found.candidates,
        "notes": list(found.notes),
        "before_after": {
            quantity: {"before": number(before), "after": number(after)}
            for quantity, (before, after) in found.before_after.items()
        },
    }
    return entry | {"sentence": verdict_sentence(entry), "left_sentence": left_sentence(entry)}


def _finding(finding: Finding, first_plan: int) -> dict[str, Any]:
    return {
        "rank": finding.rank,
        "effect": finding.effect,
        "where": where(finding.place),
        "title": at_place(finding.effect, finding.place.kind, finding.place.name, finding.place.part),
        "parameters": numbers(finding.parameters),
        "parameter_words": {
            name: said for name in finding.parameters if (said := parameter_words(finding.effect, name))
        },
        "held_out": asdict(finding.held_out),
        "score": finding.score,
        "evidence": finding.sentence,
        "alternatives": [_alternative(each) for each in finding.alternatives],
        "also_possible": [_alternative(each) for each in finding.also_possible],
        "motion": finding.motion,
        "apart": apart_entries(finding),
        "planned": planned_entries(finding, first_plan),
        "curve": _curve(finding.evidence, finding.held_out.unit),
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
    place = where(step.place) if step.place else None
    return asdict(link) | {"step": step_words(step), "what": step.what, "effect": step.effect or None, "where": place}


def _alternative(other: Alternative) -> dict[str, Any]:
    return {
        "effect": other.effect,
        "where": where(other.place),
        "title": at_place(other.effect, other.place.kind, other.place.name, other.place.part),
        "score": other.score,
        "reason": other.reason,
    }


def _curve(evidence: Evidence, unit: str) -> dict[str, Any]:
    """What the report draws as evidence: mean residuals over the coordinate that the effect depends on."""
    return {
        "coordinate": {"name": evidence.coordinate, "unit": evidence.unit, "values": evidence.at},
        "unit": unit,
        **{name: getattr(evidence, name) for name in ("before", "after", "spread", "model", "along_motion")},
    }
