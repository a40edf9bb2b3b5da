"""Before anything else is sought: what a log's own low-pass has done looks like several effects."""

from __future__ import annotations

from dataclasses import replace

from exogauge.detect.so_far import SoFar
from exogauge.detect.stored_filter.limit import band_limits
from exogauge.search.may_be_named import refused


def stored_filter(so_far: SoFar) -> SoFar:
    """With both sides filtered alike from here on."""
    limited = band_limits(so_far.current, so_far.recordings, so_far.identified, so_far.question.progress)
    if limited is None or refused(limited.finding, so_far.criteria.judging):
        return so_far
    models, recordings = (limited.before, limited.identification), limited.recordings
    return replace(so_far, recordings=recordings, whole=recordings, models=models).having([limited.finding])
