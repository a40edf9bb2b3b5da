"""Numbers of the maker that a free parameter absorbs: looked for once all that leaves a residual is in the model."""

from __future__ import annotations

from dataclasses import replace

from exogauge.detect.nominal.contradicted import contradicted
from exogauge.detect.nominal.finding import name_contradiction
from exogauge.detect.so_far import SoFar
from exogauge.search.may_be_named import told


def nominal_values(so_far: SoFar) -> SoFar:
    """With what the data contradict beside the models, which hold the change already."""
    recordings = so_far.searched.recordings if so_far.searched else so_far.recordings
    current, first = so_far.current, len(so_far.findings) + 1
    odd = contradicted(current.model, [each.log for each in recordings if not each.held_out])
    settings = so_far.question.settings
    findings = [name_contradiction(n, current, recordings, settings, each) for n, each in enumerate(odd, first)]
    named, doubtful = told(findings, so_far.criteria.judging)
    return replace(so_far, beside=named, doubtful=doubtful)
