"""Motions: what was captured of a person, how it is read, and when its feet stand."""

from __future__ import annotations

import json
import os
from datetime import datetime
from hashlib import sha256
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Literal, Self, final

import yaml
from fastapi import Depends, Query, Request, Response
from fastapi.responses import StreamingResponse
from pydantic import BaseModel, Field, ValidationError

from exogauge.api.bodies import BundleUpload, bundle_body, bundle_schema
from exogauge.api.bundles import give_files, keep, let_go, listed, shown
from exogauge.api.dependencies import (
    NO_NUL,
    Cursor,
    Id,
    IfMatch,
    Limit,
    Name,
    ReaderDep,
    Search,
    SettingsDep,
    StorageDep,
    StoreDep,
    refuse_changed,
)
from exogauge.api.lists import Mark, part
from exogauge.api.raw_series import opened, shelf_of
from exogauge.api.routing import Router
from exogauge.api.scenes import hashed
from exogauge.api.series import (
    FILE,
    NEVER_CHANGES,
    Channels,
    End,
    SeriesOut,
    Start,
    TilesOut,
    Width,
    described,
    tiled,
    windowed,
)
from exogauge.api.shapes import Kept, LatestJob, ListOf, Part
from exogauge.api.uploads import lay_out, scratch_folder
from exogauge.errors import BadMotion, Fault
from exogauge.jobs.recipes import as_fault
from exogauge.motion.contract import Angle, Axis, CaptureFile, ContactsEntry, Unit
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.storage.records import MapRecord
from exogauge.storage.store import Storage, Store

router = Router(tags=["motions"])
MOTION = "motion.yaml"
CHILD = "exogauge.api.opening_capture"
CAPTURES, SKELETON = (".c3d", ".trc", ".tsv", ".csv", ".mvnx", ".mot", ".sto", ".bvh", ".amc"), ".asf"
CONTACTS, NOBODY_SAID = "when the feet stand", '"none"'  # what was changed; the ETag while the capture alone says it
SERIES, VERSION = "motion.parquet", "1"
TEXT = {"type": "string", "maxLength": 200}
FORM = bundle_schema(
    "the capture (C3D, TRC, TSV, CSV, MVNX, MOT, STO, BVH, or AMC with its ASF), a static trial; or motion.yaml with "
    "what it names",
    also={
        "up": {**TEXT, "description": "x, y, z, -x, -y, -z, where the file is silent or wrong"},
        "unit": {**TEXT, "description": "m, cm, mm, in, cmu, where the file is silent or wrong"},
        "angle": {**TEXT, "description": "deg, rad, of turns, where the file is silent or wrong"},
        "subject": {**TEXT, "description": "prefix of one of several people"},
        "static": {**TEXT, "description": "which of the files is the static trial"},
        "map": {**TEXT, "description": "name of a map that is kept: what own labels are called elsewhere"},
    },
)


@final
class MotionOut(Kept):
    """One version of a motion. content_hash covers every file. files, capture, and of the summary labels and contacts:
    given when one is asked for."""

    long = ("labels", "contacts")
    version: int
    latest_job: LatestJob | None = None
    capture: CaptureFile | None = None


@final
class MotionList(ListOf):
    items: list[MotionOut]


@final
class Restated(Part):
    """How a motion is to be read from now on; what is not given is as the file says. map: that is kept."""

    name: str | None = Field(default=None, min_length=1, max_length=200)
    up: Axis | None = None
    unit: Unit | None = None
    angle: Angle | None = None
    subject: str | None = Field(default=None, max_length=200)
    map: str | None = Field(default=None, max_length=200, pattern=NO_NUL)
    names: dict[str, str] | None = Field(default=None, max_length=1000)


@final
class ContactsOut(BaseModel):
    """said: by hand, null where nobody has; read: from the capture, null where the feet are not known."""

    said: ContactsEntry | None
    read: ContactsEntry | None
    seconds: float


@final
class MapIn(Part):
    """names: own label or bone -> the name it is known by."""

    name: str = Field(min_length=1, max_length=200, pattern=NO_NUL)
    names: dict[str, str] = Field(min_length=1, max_length=1000)


@final
class MapOut(BaseModel):
    id: str
    name: str
    names: dict[str, str]
    changed_at: datetime

    @classmethod
    def of(cls, kept: MapRecord) -> Self:
        return cls(id=kept.id, name=kept.name, names=dict(kept.content), changed_at=kept.changed_at)


@final
class MapList(ListOf):
    items: list[MapOut]


@router.post(
    "/motions",
    operation_id="createMotion",
    status_code=201,
    responses={200: {"model": MotionOut, "description": "The same files were there already"}},
    openapi_extra=FORM,
)
def create_motion(
    upload: Annotated[BundleUpload, Depends(bundle_body)],
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
) -> MotionOut:
    """Read and store a capture. Other files under the same name, or read otherwise, become its next version."""
    with scratch_folder(settings) as scratch:
        lay_out(upload.files, scratch, settings)
        if not any(scratch.rglob(MOTION)):
            write_description(described_by(scratch, upload, storage), scratch)
        motion, new = keep_motion(scratch, storage, upload.name)
    response.status_code = 201 if new else 200
    return motion


@router.get("/motions", operation_id="listMotions")
def list_motions(
    store: ReaderDep,
    cursor: Cursor,
    limit: Limit = 50,
    search: Search = "",
    name: Name = None,
) -> MotionList:
    page = store.motions.page(cursor, limit, search=search, name=name)
    return listed(store, store.motions, page, MotionOut, MotionList)


@router.get("/motions/{motion_id}", operation_id="getMotion")
def get_motion(motion_id: Id, store: ReaderDep) -> MotionOut:
    return with_capture(store, str(motion_id))


@router.post(
    "/motions/{motion_id}/versions",
    operation_id="restateMotion",
    status_code=201,
    responses={200: {"model": MotionOut, "description": "It is read like this already"}},
)
def restate_motion(
    motion_id: Id, wanted: Restated, storage: StorageDep, settings: SettingsDep, response: Response
) -> MotionOut:
    """The same files read otherwise: its next version."""
    with scratch_folder(settings) as scratch:
        with storage.reading() as store:
            motion = store.motions.write_to(str(motion_id), scratch)
            names = wanted.names if wanted.map is None else dict(store.maps.get(wanted.map).content)
        said = yaml.safe_load((scratch / MOTION).read_bytes())
        kept = {key: said[key] for key in ("file", "skeleton", "static") if said.get(key) is not None}
        stated = wanted.model_dump(exclude={"map", "names"}, exclude_none=True)
        (scratch / MOTION).unlink()
        write_description(CaptureFile(**{"name": motion.name, **kept, **stated, "names": names or {}}), scratch)
        again, new = keep_motion(scratch, storage, wanted.name or motion.name)
    response.status_code = 201 if new else 200
    return again


give_files(router, "motion", "motions", lambda store: store.motions)
let_go(
    router,
    "motion",
    "motions",
    lambda store: store.motions,
    "Its jobs, results, contacts and files go. 409 while a job waits or runs, or a plan is made of it.",
)


@router.get("/motions/{motion_id}/contacts", operation_id="getMotionContacts")
def get_contacts(motion_id: Id, store: ReaderDep, response: Response) -> ContactsOut:
    """When each foot stands."""
    return contacts_of(store, str(motion_id), response)


@router.put("/motions/{motion_id}/contacts", operation_id="putMotionContacts")
def put_contacts(
    motion_id: Id, wanted: ContactsEntry, store: StoreDep, response: Response, if_match: IfMatch = None
) -> ContactsOut:
    """Say when each foot stands, until the last frame at most; plans that are asked from now on take it so."""
    key, content = str(motion_id), wanted.model_dump()
    summary = store.motions.get(key).summary
    wanted.within(float(summary.get("seconds", 0.0)), float(summary["rate_hz"]))
    if store.contacts.find(key) is None:
        refuse_changed(if_match, NOBODY_SAID, CONTACTS)
    store.contacts.keep(key, content, hash_of(content), lambda old: refuse_changed(if_match, f'"{old}"', CONTACTS))
    return contacts_of(store, key, response)


@router.delete("/motions/{motion_id}/contacts", operation_id="deleteMotionContacts")
def delete_contacts(motion_id: Id, store: StoreDep, response: Response, if_match: IfMatch = None) -> ContactsOut:
    """Take them as they were read."""
    store.motions.get(str(motion_id))
    store.contacts.forget(str(motion_id), lambda old: refuse_changed(if_match, f'"{old}"', CONTACTS))
    return contacts_of(store, str(motion_id), response)


@router.get("/motion-maps", operation_id="listMotionMaps")
def list_maps(store: ReaderDep, after: Mark, limit: Limit = 50) -> MapList:
    """All that the lab keeps, by name."""
    items, more = part(store.maps.all(), lambda kept: (kept.name,), after, limit)
    return MapList(items=[MapOut.of(kept) for kept in items], next_cursor=more)


@router.post("/motion-maps", operation_id="keepMotionMap")
def keep_map(wanted: MapIn, store: StoreDep) -> MapOut:
    """Keep what own labels or bones are called elsewhere, in place of what is kept under this name."""
    return MapOut.of(store.maps.keep(wanted.name, wanted.names, hash_of(wanted.names))[0])


@router.delete("/motion-maps/{map_id}", operation_id="deleteMotionMap", status_code=204, response_class=Response)
def delete_map(map_id: Id, store: StoreDep) -> Response:
    """Motions that were read with it stay as they are."""
    store.maps.forget(store.maps.by_id(str(map_id)).name)
    return Response(status_code=204)


def series_file(motion_id: Id, request: Request, storage: StorageDep, settings: SettingsDep) -> Path:
    """The capture as a series file, read now where it is not kept."""
    with storage.reading() as store:
        motion = store.motions.get(str(motion_id))

    def read(path: Path) -> None:
        with scratch_folder(settings) as scratch:
            folder, own = scratch / "motion", scratch / "own"
            own.mkdir()
            with storage.reading() as store:
                store.motions.write_to(motion.id, folder)
            asked("series", folder, own)
            os.replace(own / SERIES, path)

    return shelf_of(request, settings).filled(hashed("motion", motion.content_hash, VERSION), read)


SeriesPath = Annotated[Path, Depends(series_file)]


@router.get("/motions/{motion_id}/series", operation_id="getMotionSeries")
def get_series(motion_id: Id, path: SeriesPath, response: Response) -> SeriesOut:
    """What the capture holds, by the names of its channels: `marker.LASI.x`, `bone.lowerback.z`, `stands.left`."""
    response.headers["Cache-Control"] = NEVER_CHANGES
    return described("motion", opened(path))


@router.get("/motions/{motion_id}/series/tiles", operation_id="getMotionSeriesTiles")
def get_series_tiles(
    motion_id: Id,
    path: SeriesPath,
    channels: Channels,
    request: Request,
    response: Response,
    start: Start = None,
    end: End = None,
    width: Width = 1200,
) -> TilesOut:
    """As the tiles of a job's series."""
    response.headers["Cache-Control"] = NEVER_CHANGES
    return tiled(opened(path), path.name, channels, start, end, width, request)


@router.get(
    "/motions/{motion_id}/series/window", operation_id="exportMotionSeries", responses=FILE, response_class=Response
)
def export_series(
    motion_id: Id,
    path: SeriesPath,
    channels: Channels = (),
    start: Start = None,
    end: End = None,
    form: Annotated[Literal["csv", "parquet"], Query(alias="format")] = "csv",
) -> StreamingResponse:
    """Every sample of the window as a file; all channels where none is named."""
    return windowed(opened(path), "motion", channels, start, end, form)


def with_capture(store: Store, motion_id: str) -> MotionOut:
    answer = shown(store, store.motions, motion_id, MotionOut)
    with store.blobs.open(store.motions.file(motion_id, MOTION).sha256) as stream:
        answer.capture = CaptureFile.model_validate(yaml.safe_load(stream.read()))
    return answer


def contacts_of(store: Store, motion_id: str, response: Response) -> ContactsOut:
    summary = store.motions.get(motion_id).summary
    kept, read = store.contacts.find(motion_id), summary.get("contacts")
    response.headers["ETag"] = NOBODY_SAID if kept is None else f'"{kept.content_hash}"'
    return ContactsOut(
        said=None if kept is None else ContactsEntry.model_validate(dict(kept.content)),
        read=None if read is None else ContactsEntry.model_validate(read),
        seconds=float(summary.get("seconds", 0.0)),
    )


def described_by(folder: Path, upload: BundleUpload, storage: Storage) -> CaptureFile:
    """motion.yaml of files that came without one. Raises BadMotion, NotFound."""
    paths = [path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*")) if path.is_file()]
    static = upload.said.get("static")
    kinds = {path: PurePosixPath(path).suffix.lower() for path in paths}
    captures = [path for path, kind in kinds.items() if kind in CAPTURES and path != static]
    bones = [path for path, kind in kinds.items() if kind == SKELETON]
    if len(captures) != 1 or len(bones) > 1:
        found = ", ".join(captures) or "none"
        advice = (
            "Hand in one capture at a time, with its skeleton; name a static trial as `static`, or add motion.yaml."
        )
        detail = f"{len(captures)} captures and {len(bones)} skeletons are there"
        raise BadMotion(Fault(detail, "which_capture", advice, None, None, "files", found))
    stated = ("up", "unit", "angle", "subject", "static")
    said: dict[str, Any] = {key: upload.said[key] for key in stated if key in upload.said}
    if "map" in upload.said:
        with storage.reading() as store:
            said["names"] = dict(store.maps.get(upload.said["map"]).content)
    try:
        return CaptureFile(name=upload.name or PurePosixPath(captures[0]).stem, file=captures[0],
                           skeleton=next(iter(bones), None), **said)  # fmt: skip
    except ValidationError as error:
        raise BadMotion([as_fault(each["loc"], each["msg"], each["type"]) for each in error.errors()]) from error


def write_description(file: CaptureFile, folder: Path) -> None:
    content = file.model_dump(exclude_none=True, exclude_defaults=True)
    (folder / MOTION).write_text(yaml.safe_dump({"version": 1, **content}, allow_unicode=True, sort_keys=False))


def keep_motion(folder: Path, storage: Storage, name: str | None) -> tuple[MotionOut, bool]:
    """The motion below `folder`, read and stored, and whether it is new."""
    motion, _, new = keep(folder, MOTION, examined, storage, lambda store: store.motions, name)
    with storage.reading() as store:
        return with_capture(store, motion.id), new


def examined(folder: Path) -> dict[str, Any]:
    with TemporaryDirectory(prefix="exogauge-") as own:
        return asked("capture", folder, Path(own))


def asked(task: str, folder: Path, own: Path, **options: Any) -> dict[str, Any]:
    """What the child says of the motion in `folder`; files that it leaves are in `own`. Raises BadInput."""
    limits = Limits.for_bytes(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
    return ask(CHILD, task, {"folder": str(folder), **options}, own, limits, BadMotion, what="motion")


def hash_of(content: Any) -> str:
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
