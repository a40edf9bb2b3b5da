"""Findings with the motions that would tell them from what else they may be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from exogauge.experiment.design import tell_apart
from exogauge.findings.result import Finding
from exogauge.logs.model import Log
from exogauge.search.ambiguity import Undecided


def with_motions(findings: Iterable[Finding], logs: Sequence[Log]) -> tuple[Finding, ...]:
    """logs: that were fitted. Where none can be planned, what the effect needs stays in words."""
    return tuple(_with_motions(each, logs) for each in findings)


def _with_motions(finding: Finding, logs: Sequence[Log]) -> Finding:
    doubt = finding.undecided
    found = tell_apart(doubt, logs) if isinstance(doubt, Undecided) and finding.also_possible else None
    if found is None:
        return replace(finding, undecided=None)
    return replace(finding, undecided=None, motion=found.sentence, apart=found.pairs, plans=found.motions)
