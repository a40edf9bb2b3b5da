"""Versions of a study's model: what each evaluation identified, and the effects that were added to it, one by one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime
from hashlib import sha256
from typing import Any, final

from pydantic import BaseModel

from exogauge.api.dependencies import Cursor, Id, Limit, ReaderDep, encoded_cursor
from exogauge.api.results import content_of
from exogauge.api.routing import Router
from exogauge.api.shapes import ListOf
from exogauge.storage.jobs import RESULTS
from exogauge.storage.records import ListedJobRecord

router = Router(tags=["models"])


@final
class ModelVersionOut(BaseModel):
    """version: of the model, among those of its job; parent: what it grew from, null for the first. added: effect and
    place. data: content hash of the study. settings_hash: of the settings in force. rmse: on held-out logs, of the
    channels in question, with the floor that noise sets, in `unit` (`floors`: as multiples of it)."""

    version: str
    parent: str | None
    added: str
    job_id: str
    created_at: datetime
    data: str
    settings_hash: str
    code_version: str
    rmse: float | None
    noise_floor: float | None
    unit: str | None


@final
class ModelVersionList(ListOf):
    items: list[ModelVersionOut]


@router.get("/studies/{study_id}/models", operation_id="listModelVersions")
def list_model_versions(study_id: Id, store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> ModelVersionList:
    """Of the study's jobs that succeeded and searched for missing effects: newest job first, first model first. limit:
    jobs, of which those of other kinds have no model."""
    study = store.studies.get(str(study_id))
    page = store.jobs.page(cursor, limit, study_id=study.id, state="succeeded")
    evaluated = [job for job in page.items if any(each.name == RESULTS for each in store.results.artifacts(job.id))]
    items = [each for job in evaluated for each in versions(job, study.content_hash, content_of(store, job.id))]
    return ModelVersionList(items=items, next_cursor=encoded_cursor(page.after))


def versions(job: ListedJobRecord, data: str, content: Mapping[str, Any]) -> list[ModelVersionOut]:
    found = content.get("discrepancy") or {}
    lineage, chain = found.get("lineage", []), found.get("chain", [])
    links = chain[len(chain) - len(lineage) :] if len(chain) >= len(lineage) else [{}] * len(lineage)
    settings = json.dumps(content.get("settings"), sort_keys=True)
    return [
        ModelVersionOut(
            **{key: entry[key] for key in ("version", "parent", "added")},
            **{key: link.get(key) for key in ("rmse", "noise_floor", "unit")},
            job_id=job.id,
            created_at=job.created_at,
            data=data,
            settings_hash=sha256(settings.encode()).hexdigest(),
            code_version=job.code_version or "",
        )
        for entry, link in zip(lineage, links, strict=True)
    ]
