"""Results and artifacts: results.json, report.html, series, tables, the identified URDF.

results.json of jobs, read back: written by our own worker, so it may be opened here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Annotated, Any

from fastapi import Path, Request
from fastapi.responses import FileResponse, Response, StreamingResponse

from exogauge.api.dependencies import Id, Limit, ReaderDep
from exogauge.api.lists import Mark, part
from exogauge.api.routing import Router
from exogauge.api.shapes import ArtifactList, ArtifactOut
from exogauge.api.threads import short
from exogauge.errors import BadInput, Fault
from exogauge.storage.blobs import BlobStore, chunks
from exogauge.storage.jobs import RESULTS
from exogauge.storage.store import Store
from exogauge.studies.results.schema import StudyResults

router = Router(tags=["results"])

NOT_MODIFIED: dict[str, Any] = {"description": "The ETag given in If-None-Match still holds"}
FilePath = Annotated[str, Path(max_length=500, pattern=r"^[^\x00]*$")]
STUDY_FILE: dict[int | str, dict[str, Any]] = {
    200: {"description": "results.json", "model": StudyResults},
    304: NOT_MODIFIED,
}
JOB_FILE: dict[int | str, dict[str, Any]] = {
    200: {"description": "results.json, or what_if.json of a what-if", "model": StudyResults | dict[str, Any]},
    304: NOT_MODIFIED,
}
ANY_FILE: dict[int | str, dict[str, Any]] = {
    200: {"description": "The file", "content": {"*/*": {"schema": {"type": "string", "format": "binary"}}}},
    206: {"description": "The range asked for", "content": {"*/*": {}}},
    304: NOT_MODIFIED,
}
SHOWN = ("text/html", "application/json", "image/png", "image/svg+xml", "text/plain", "text/csv")
# A report is ours, but what it shows came from uploads: it may style itself and hold pictures, and nothing else.
REPORT_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; script-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'; sandbox allow-popups allow-downloads"
)


@router.get("/studies/{study_id}/results", operation_id="getStudyResults", responses=STUDY_FILE)
def get_study_results(study_id: Id, store: ReaderDep, request: Request) -> Response:
    """results.json of the study's latest job that succeeded."""
    store.studies.get(str(study_id))
    result = store.results.of_study(str(study_id))
    return file_response(store.blobs, request, result.sha256, "results.json", "application/json")


@router.get("/jobs/{job_id}/results", operation_id="getJobResults", responses=JOB_FILE)
def get_job_results(job_id: Id, store: ReaderDep, request: Request) -> Response:
    result = store.results.of_job(str(job_id))
    return file_response(store.blobs, request, result.sha256, "results.json", "application/json")


@router.get("/jobs/{job_id}/artifacts", operation_id="listArtifacts")
@short
def list_artifacts(job_id: Id, store: ReaderDep, after: Mark, limit: Limit = 50) -> ArtifactList:
    """By name."""
    items, more = part(store.results.artifacts(str(job_id)), lambda each: (each.name,), after, limit)
    return ArtifactList.model_validate({"items": [ArtifactOut.told(each) for each in items], "next_cursor": more})


@router.get("/jobs/{job_id}/artifacts/{name:path}", operation_id="getArtifact", responses=ANY_FILE)
def get_artifact(job_id: Id, name: FilePath, store: ReaderDep, request: Request) -> Response:
    """One file that the job made; ranges and If-None-Match are honoured."""
    artifact = store.results.artifact(str(job_id), name)
    return file_response(store.blobs, request, artifact.sha256, artifact.name, artifact.media_type)


def file_response(blobs: BlobStore, request: Request, sha256: str, name: str, media_type: str) -> Response:
    """A blob under its media type, never sniffed, never allowed to act: its ETag is its hash."""
    etag = f'"{sha256}"'
    headers = {
        "ETag": etag,
        "Cache-Control": "private, no-cache",
        "Content-Security-Policy": REPORT_POLICY,
    }
    if unchanged(request, etag):
        return Response(status_code=304, headers=headers)
    shown = "inline" if media_type.partition(";")[0] in SHOWN else "attachment"
    path = blobs.path_for(sha256)
    if path is None:
        return StreamingResponse(streamed(blobs, sha256), media_type=media_type, headers=headers)
    last = name.rsplit("/", 1)[-1]
    return FileResponse(path, headers=headers, media_type=media_type, filename=last, content_disposition_type=shown)


def unchanged(request: Request, etag: str) -> bool:
    """Whether who asks has it already."""
    asked = request.headers.get("if-none-match", "")
    return etag in asked or asked.strip() == "*"


def streamed(blobs: BlobStore, sha256: str) -> Iterator[bytes]:
    with blobs.open(sha256) as stream:
        yield from chunks(stream)


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
