"""results.json of jobs, read back: written by our own worker, so it may be opened here."""

from __future__ import annotations

import json
from typing import Any

from exogauge.errors import BadInput, Fault
from exogauge.storage.results import RESULTS
from exogauge.storage.store import Store


def content_of(store: Store, job_id: str) -> dict[str, Any]:
    """NotFound where the job has no results, BadInput where it made something else (a what-if, a payload's)."""
    result, job = store.results.of_job(job_id), store.jobs.get(job_id)
    evaluated = {each.name: each.sha256 for each in store.results.artifacts(job_id)}
    if evaluated.get(RESULTS) != result.sha256 or job.study_id is None:
        advice = "Name jobs that evaluate a study."
        detail = f"a job of kind {job.kind} makes no results.json of a study"
        raise BadInput(Fault(detail, "no_results", advice, value=job_id))
    with store.blobs.open(result.sha256) as stream:
        content: dict[str, Any] = json.load(stream)
    return content
