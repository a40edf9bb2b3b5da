"""Payloads: payload.yaml with its URDF and logs, what was identified of them, and what to record."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self, final

from fastapi import Depends, Query, Request, Response
from fastapi import Path as InPath
from pydantic import BaseModel

from exogauge.api import checking
from exogauge.api.bodies import BundleUpload, bundle_body, bundle_schema
from exogauge.api.bundles import give_files, keep, let_go, listed, shown
from exogauge.api.dependencies import (
    Cursor,
    Id,
    Limit,
    Name,
    ReaderDep,
    Search,
    SettingsDep,
    StorageDep,
    StoreDep,
    encoded_cursor,
)
from exogauge.api.jobs import JobOut, QueueDep, located, told_of
from exogauge.api.results import NOT_MODIFIED, file_response
from exogauge.api.routing import Router
from exogauge.api.shapes import ArtifactOut, Kept, LatestJob, ListOf, Part
from exogauge.api.uploads import lay_out, scratch_folder
from exogauge.jobs import requests
from exogauge.payload.schema import Found, PayloadResults
from exogauge.storage.records import ArtifactRecord
from exogauge.storage.store import Storage, Store


@final
class PayloadOut(Kept):
    """One version of a payload. summary: sensor, pose, logs, what may be planned, the doctor's `findings`.
    content_hash covers every file; files: given when one is asked for."""

    version: int
    latest_job: LatestJob | None = None


@final
class PayloadList(ListOf):
    items: list[PayloadOut]


@final
class PlanRequest(Part):
    """What to plan: postures at rest, or the motion that excites."""

    what: Literal["postures", "excitation"]


@final
class PlanOut(BaseModel):
    """job: that made it; `settings.what` is what is planned. found: what the plan will tell; null until it is made."""

    job: JobOut
    found: Found | None
    files: list[ArtifactOut]

    @classmethod
    def of(cls, job: JobOut, content: bytes, files: Sequence[ArtifactRecord]) -> Self:
        return cls(job=job, found=Found.model_validate_json(content), files=[ArtifactOut.of(file) for file in files])


@final
class PlanList(ListOf):
    """Newest first."""

    items: list[PlanOut]


router = Router(tags=["payloads"])
PAYLOAD = "payload.yaml"
PLANS = "payload_plan"
FORM = bundle_schema("payload.yaml and what it names, under their relative paths, or one zip of them")
RESULTS: dict[int | str, dict[str, Any]] = {
    200: {"description": "results.json", "model": PayloadResults},
    304: NOT_MODIFIED,
}
EXPORT: dict[int | str, dict[str, Any]] = {
    200: {"description": "The file", "content": {"*/*": {"schema": {"type": "string"}}}}
}
Flange = Annotated[
    list[float] | None,
    Query(
        min_length=6,
        max_length=6,
        description="the sensor's pose in the flange: x, y, z [m], roll, pitch, yaw [°], one parameter each; without "
        "it all is in the sensor's frame",
    ),
]


@router.post(
    "/payloads",
    operation_id="createPayload",
    status_code=201,
    responses={200: {"model": PayloadOut, "description": "The same files were there already"}},
    openapi_extra=FORM,
)
def create_payload(
    upload: Annotated[BundleUpload, Depends(bundle_body)],
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
) -> PayloadOut:
    """Check and store a payload; every log is read. Other files under the same name become its next version."""
    with scratch_folder(settings) as scratch:
        lay_out(upload.files, scratch, settings)
        payload, new = keep_payload(scratch, storage)
    response.status_code = 201 if new else 200
    return payload


@router.get("/payloads", operation_id="listPayloads")
def list_payloads(
    store: ReaderDep,
    cursor: Cursor,
    limit: Limit = 50,
    search: Search = "",
    name: Name = None,
) -> PayloadList:
    page = store.payloads.page(cursor, limit, search=search, name=name)
    return listed(store, store.payloads, page, PayloadOut, PayloadList)


@router.get("/payloads/{payload_id}", operation_id="getPayload")
def get_payload(payload_id: Id, store: ReaderDep) -> PayloadOut:
    return shown(store, store.payloads, str(payload_id), PayloadOut)


give_files(router, "payload", "payloads", lambda store: store.payloads)
let_go(
    router,
    "payload",
    "payloads",
    lambda store: store.payloads,
    "Its jobs, results, streams and files go. 409 while a job waits or runs, or a stream is open.",
)


@router.get("/payloads/{payload_id}/results", operation_id="getPayloadResults", responses=RESULTS)
def get_payload_results(payload_id: Id, store: ReaderDep, request: Request) -> Response:
    """results.json of the payload's latest job that succeeded."""
    store.payloads.get(str(payload_id))
    result = store.results.of_payload(str(payload_id))
    return file_response(store.blobs, request, result.sha256, "results.json", "application/json")


@router.get("/payloads/{payload_id}/exports/{format}", operation_id="exportPayload", responses=EXPORT)
def export_payload(
    payload_id: Id,
    format: Annotated[str, InPath(max_length=20, description="json, csv, urdf, sdf, mjcf, ur, kuka or abb")],
    store: ReaderDep,
    flange: Flange = None,
) -> Response:
    """What the latest job identified, for a robot's model or controller; frame and units are said in it."""
    from exogauge.payload.exports.formats import export, format_of, results_from

    store.payloads.get(str(payload_id))
    wanted = format_of(format)
    with store.blobs.open(store.results.of_payload(str(payload_id)).sha256) as stream:
        text = export(results_from(stream.read(), "results.json"), format, flange)
    headers = {"Content-Disposition": f'attachment; filename="payload{wanted.suffix}"'}
    return Response(text, media_type=wanted.media_type, headers=headers)


@router.post(
    "/payloads/{payload_id}/plans", operation_id="planPayload", status_code=202, responses={200: {"model": JobOut}}
)
def plan_payload(
    payload_id: Id, wanted: PlanRequest, request: Request, response: Response, store: StoreDep, queue: QueueDep
) -> JobOut:
    """Plan what to record. 202: a new job. 200: an equal request is queued, running or succeeded already."""
    store.payloads.get(str(payload_id))
    job, new = requests.submit(store, queue, str(payload_id), PLANS, wanted.model_dump())
    return located(JobOut.of(job, store.session), new, request, response)


@router.get("/payloads/{payload_id}/plans", operation_id="listPayloadPlans")
def list_payload_plans(payload_id: Id, store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> PlanList:
    """Newest first; those that are still planned, or failed, have no `found`."""
    store.payloads.get(str(payload_id))
    page = store.jobs.page(cursor, limit, payload_id=str(payload_id), kind=PLANS)
    jobs = (JobOut.model_validate(told) for told in told_of(page.items, store.session))
    items = [plan_of(store, job) for job in jobs]
    return PlanList(items=items, next_cursor=encoded_cursor(page.after))


def plan_of(store: Store, job: JobOut) -> PlanOut:
    if job.state != "succeeded":
        return PlanOut(job=job, found=None, files=[])
    with store.blobs.open(store.results.of_job(job.id).sha256) as stream:
        return PlanOut.of(job, stream.read(), store.results.artifacts(job.id))


def keep_payload(folder: Path, storage: Storage) -> tuple[PayloadOut, bool]:
    """The payload below `folder`, checked and stored, and whether it is new."""
    payload, _, new = keep(folder, PAYLOAD, examined, storage, lambda store: store.payloads)
    with storage.reading() as store:
        return shown(store, store.payloads, payload.id, PayloadOut), new


def examined(folder: Path) -> dict[str, Any]:
    """The summary of a payload that is one, with what the doctor finds in its logs."""
    summary = checking.check_payload(folder)
    return summary | {"findings": checking.examine_payload(folder) if summary["logs"] else []}
