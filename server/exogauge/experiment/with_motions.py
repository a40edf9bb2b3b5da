"""Findings with the motions that would tell them from what else they may be."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from exogauge.experiment.design import tell_apart
from exogauge.findings.result import Finding, Place
from exogauge.logs.model import Log
from exogauge.search.ambiguity import Undecided


def with_motions(
    findings: Iterable[Finding], undecided: Mapping[tuple[str, Place], Undecided], logs: Sequence[Log]
) -> tuple[Finding, ...]:
    """undecided: what tells the finding of an effect at a place from what it may be, too. logs: that were fitted. Some
    motions cannot be planned; what the effect needs is known in words."""
    return tuple(_with_motions(each, undecided.get((each.effect, each.named_at)), logs) for each in findings)


def _with_motions(finding: Finding, doubt: Undecided | None, logs: Sequence[Log]) -> Finding:
    found = tell_apart(doubt, logs) if doubt is not None and finding.also_possible else None
    return finding if found is None else replace(finding, apart=found.pairs, plans=found.motions)
