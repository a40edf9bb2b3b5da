"""Resumable uploads by the tus protocol 1.0.0: a file arrives in pieces, and goes on where it was if the line breaks.

Creation, termination, checksum and expiration are spoken. How far a file has come is how long it is on disk, or
in the object store where there is one, so a client that asks after a crash of either side gets the truth, from
whichever server it asks. No body is read before everything about the request has
been found right. What arrived is used by `createStudyFromUpload`, `createLogFromUpload` or `previewLog`.
"""

from __future__ import annotations

import base64
import hashlib
import os
import shutil
from collections.abc import Sequence
from contextlib import ExitStack
from datetime import datetime, timedelta
from email.utils import format_datetime
from pathlib import Path
from typing import Annotated, Any, BinaryIO, final

from fastapi import Depends, Header, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exogauge.api.dependencies import Id, InstallationDep, SettingsDep, StorageDep
from exogauge.api.problems import problem_response
from exogauge.api.routing import Router
from exogauge.errors import Conflict, DiskFull, Fault, TooLarge
from exogauge.settings import Settings
from exogauge.storage.blobs import InUse
from exogauge.storage.files import safe_path
from exogauge.storage.partial_files import PartialFiles, copy_piece, sync, write_all
from exogauge.storage.records import UploadRecord
from exogauge.storage.store import Storage
from exogauge.storage.tables import new_id

router = Router(tags=["uploads"])
VERSION = "1.0.0"
EXTENSIONS = "creation,termination,checksum,expiration"
PIECE = "application/offset+octet-stream"
ALGORITHMS = ("sha1", "sha256")
NOT_SPOKEN = {
    "Upload-Concat": "files are not joined here; send one, or name several uploads where they are used",
    "Upload-Defer-Length": "say Upload-Length; how long a file becomes is known from the start",
}
OVERRIDDEN = ("PATCH", "DELETE", "HEAD")  # by a POST; tus 1.0.0, X-HTTP-Method-Override
AT_ONCE = 1 << 20  # bytes gathered before they are written
MISMATCH = 460  # tus: the checksum does not fit
BODY = {"requestBody": {"required": True, "content": {PIECE: {"schema": {"type": "string", "format": "binary"}}}}}
NUMBER = r"^[0-9]{1,15}$"


@final
class UploadOut(BaseModel):
    """offset: bytes that have arrived, of `size`. Untouched until expires_at, it is removed."""

    id: str
    name: str
    size: int
    offset: int
    expires_at: datetime


@final
class Tus:
    """ASGI middleware: every answer below `prefix` tells the version, refusals too. A client whose network lets only
    POST through says in a header what it means, before anybody asks whether it may."""

    def __init__(self, app: ASGIApp, prefix: str) -> None:
        self.app, self.prefix = app, prefix

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def told(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)["Tus-Resumable"] = VERSION
            await send(message)

        mine = scope["type"] == "http" and scope["path"].removeprefix(scope.get("root_path", "")).startswith(
            self.prefix
        )
        if mine and scope["method"] == "POST":
            meant = Headers(scope=scope).get("x-http-method-override", "POST").upper()
            scope = {**scope, "method": meant if meant in OVERRIDDEN else "POST"}
        await self.app(scope, receive, told if mine else send)


def spoken(
    version: Annotated[str, Header(alias="Tus-Resumable", json_schema_extra={"const": VERSION})] = "",
) -> None:
    """412 for a client that speaks another version, or no tus."""
    if version != VERSION:
        detail = f"say `Tus-Resumable: {VERSION}`, the version that is spoken here"
        raise HTTPException(412, detail, {"Tus-Version": VERSION})


async def partial_files(settings: SettingsDep, installation: InstallationDep) -> PartialFiles:
    return PartialFiles(settings.uploads, installation.blobs.pieces)


def plain(request: Request) -> None:
    """422 for what clients of other servers say when they create an upload, and would take for understood."""
    for name, advice in NOT_SPOKEN.items():
        if name in request.headers:
            place = ("header", name)
            raise RequestValidationError([{"type": "not_spoken", "loc": place, "msg": f"{advice}"}])


Spoken, Plain = Depends(spoken), Depends(plain)
FilesDep = Annotated[PartialFiles, Depends(partial_files)]
Length = Annotated[str, Header(alias="Upload-Length", pattern=NUMBER, description="bytes of the whole file")]
Offset = Annotated[str, Header(alias="Upload-Offset", pattern=NUMBER, description="bytes that came before this piece")]
Metadata = Annotated[
    str | None,
    Header(alias="Upload-Metadata", max_length=8000, description="`filename` and its base64, as tus has it"),
]
Checksum = Annotated[
    str | None,
    Header(alias="Upload-Checksum", max_length=200, description="`sha256` or `sha1`, a blank, base64 of the piece's"),
]


@router.options("/uploads", operation_id="getUploadCaps", status_code=204, response_class=Response)
def get_upload_caps(settings: SettingsDep) -> Response:
    """What is spoken here, and how large a file may be (`Tus-Max-Size`)."""
    headers = {
        "Tus-Version": VERSION,
        "Tus-Extension": EXTENSIONS,
        "Tus-Checksum-Algorithm": ",".join(ALGORITHMS),
        "Tus-Max-Size": str(settings.max_bundle_bytes),
    }
    return Response(status_code=204, headers=headers)


@router.post("/uploads", operation_id="createUpload", status_code=201, dependencies=[Spoken, Plain])
def create_upload(
    length: Length,
    storage: StorageDep,
    settings: SettingsDep,
    files: FilesDep,
    request: Request,
    response: Response,
    metadata: Metadata = None,
) -> UploadOut:
    """Begin a file; `Location` says where its pieces go."""
    size, name, key = int(length), name_in(metadata), new_id()
    refuse_too_much(size, settings)
    with storage.reading() as store:
        store.refuse_bytes(size, coming=True)
    files.create(key)
    with storage.transaction() as store:
        upload = store.uploads.add(key, name, size, kept_for(settings))
        store.refuse_bytes(0, coming=True)
    response.headers["Location"] = request.url_for("get_upload_offset", upload_id=key).path
    response.headers["Upload-Expires"] = http_date(upload)
    response.headers["Upload-Offset"] = "0"  # for whoever sent the first piece along: it comes once more
    return UploadOut(**shown(upload), offset=0)


@router.head("/uploads/{upload_id}", operation_id="getUploadOffset", response_class=Response, dependencies=[Spoken])
def get_upload_offset(upload_id: Id, storage: StorageDep, files: FilesDep) -> Response:
    """How much has arrived: `Upload-Offset` of `Upload-Length`."""
    upload = find(str(upload_id), storage)
    return Response(status_code=200, headers=told(upload, files.offset(upload.id)) | {"Cache-Control": "no-store"})


@router.patch(
    "/uploads/{upload_id}",
    operation_id="appendUpload",
    status_code=204,
    response_class=Response,
    dependencies=[Spoken],
    openapi_extra=BODY,
)
async def append_upload(
    upload_id: Id,
    offset: Offset,
    request: Request,
    storage: StorageDep,
    settings: SettingsDep,
    files: FilesDep,
    checksum: Checksum = None,
) -> Response:
    """The next piece. What arrived before a line broke is kept; of a piece with a checksum, all or nothing."""
    if request.headers.get("content-type", "").partition(";")[0].strip().lower() != PIECE:
        raise HTTPException(415, f"a piece is sent as {PIECE}")
    digest = digest_of(checksum)
    upload = await run_in_threadpool(find, str(upload_id), storage)
    try:
        fits = await receive(request, upload, int(offset), files, digest)
    except InUse:
        raise HTTPException(423, "another request is sending to this upload; ask for its offset again") from None
    except ClientDisconnect:
        fits = True  # nobody hears the answer
    if not fits:
        detail = "the piece is not what its checksum says; it was left out, send it again"
        return problem_response(MISMATCH, "checksum-mismatch", "Checksum mismatch", detail, instance=request.url.path)
    upload = await run_in_threadpool(kept_longer, upload, storage, settings)
    there = await run_in_threadpool(files.offset, upload.id)
    return Response(status_code=204, headers=told(upload, there))


@router.delete(
    "/uploads/{upload_id}",
    operation_id="deleteUpload",
    status_code=204,
    response_class=Response,
    dependencies=[Spoken],
)
def delete_upload(upload_id: Id, storage: StorageDep, files: FilesDep) -> Response:
    """Give it up; what arrived is removed."""
    remove([find(str(upload_id), storage)], storage, files)
    return Response(status_code=204)


async def receive(
    request: Request, upload: UploadRecord, offset: int, files: PartialFiles, digest: tuple[Any, bytes] | None
) -> bool:
    """Append the body; False where its checksum does not fit. Raises InUse, and Conflict at another offset."""
    with ExitStack() as stack:
        file = await run_in_threadpool(stack.enter_context, files.appending(upload.id))
        there = os.fstat(file.fileno()).st_size
        if there != offset:
            raise Conflict(f"upload {upload.id} has {there} bytes, the piece begins at {offset}; ask for its offset")
        try:
            if digest is None:
                await pour(request, file, upload.size - there, None)
                return True
            piece = stack.enter_context(files.checked_piece(upload.id))
            hashed, expected = digest
            await pour(request, piece, upload.size - there, hashed)
            if hashed.digest() == expected:
                await run_in_threadpool(copy_piece, piece, file)
            return bool(hashed.digest() == expected)
        except TooLarge:  # of a piece that goes beyond the end, nothing is left
            await run_in_threadpool(file.truncate, there)
            raise
        finally:
            await run_in_threadpool(sync, file)
            await run_in_threadpool(files.share, upload.id, file, there)


async def pour(request: Request, file: BinaryIO, room: int, hashed: Any) -> None:
    """The body into the file, as it comes; what came before the line broke is written too."""
    gathered = bytearray()
    try:
        async for chunk in request.stream():
            room -= len(chunk)
            if room < 0:
                advice = "Its Upload-Length said less."
                raise TooLarge(Fault("the piece goes beyond the end of the file", "beyond_upload_length", advice))
            gathered += chunk
            if len(gathered) >= AT_ONCE:
                await run_in_threadpool(put, bytes(gathered), file, hashed)
                gathered.clear()
    finally:
        await run_in_threadpool(put, bytes(gathered), file, hashed)


def put(data: bytes, file: BinaryIO, hashed: Any) -> None:
    write_all(file, data)
    if hashed is not None:
        hashed.update(data)


def digest_of(checksum: str | None) -> tuple[Any, bytes] | None:
    """A new hash of the algorithm, and what it must come to."""
    if checksum is None:
        return None
    algorithm, _, text = checksum.partition(" ")
    try:
        expected = base64.b64decode(text, validate=True)
    except ValueError:  # letters beyond ASCII, too
        expected = b""
    if algorithm not in ALGORITHMS or len(expected) != hashlib.new(algorithm).digest_size:
        raise HTTPException(400, f"Upload-Checksum is one of {', '.join(ALGORITHMS)}, a blank and its base64")
    return hashlib.new(algorithm), expected


def name_in(metadata: str | None) -> str:
    """The path or name that the client gave the file, made safe."""
    given = dict[str, str]()
    for entry in (metadata or "").split(","):
        key, _, text = entry.strip().partition(" ")
        try:
            given[key] = base64.b64decode(text, validate=True).decode()
        except ValueError:
            raise HTTPException(400, f"Upload-Metadata: {key[:80]!a} is no UTF-8 in base64") from None
    found = (given[key] for key in ("relativePath", "filename", "name") if given.get(key) not in (None, "", "null"))
    return safe_path(next(found, "upload"))


def refuse_too_much(size: int, settings: Settings) -> None:
    if size > settings.max_bundle_bytes:
        detail = f"the file has {size} bytes, at most {settings.max_bundle_bytes} are taken"
        raise TooLarge(Fault(detail, "file_too_large", "Leave out what is not needed, or ask for more room."))
    folder = settings.uploads if settings.uploads.is_dir() else settings.data_dir
    if shutil.disk_usage(folder).free < size:
        raise DiskFull(f"the disk has no room for {size} bytes more")


def find(key: str, storage: Storage) -> UploadRecord:
    with storage.reading() as store:
        return store.uploads.get(key)


def kept_longer(upload: UploadRecord, storage: Storage, settings: Settings) -> UploadRecord:
    with storage.transaction() as store:
        store.uploads.wait_longer(upload.id, kept_for(settings))
        return store.uploads.get(upload.id)


def whole(keys: Sequence[str], storage: Storage, files: PartialFiles) -> list[tuple[UploadRecord, Path]]:
    """Uploads that have arrived, with where they lie. Conflict where one has not."""
    found = []
    for key in keys:
        upload = find(key, storage)
        try:
            path, there = files.whole(key)
        except InUse:
            raise Conflict(f"another request sends to upload {key}, or uses it; try again") from None
        if there != upload.size:
            raise Conflict(f"upload {key} ({upload.name}) has {there} of {upload.size} bytes; send the rest first")
        found.append((upload, path))
    return found


def remove(uploads: Sequence[UploadRecord], storage: Storage, files: PartialFiles) -> None:
    with storage.transaction() as store:
        for upload in uploads:
            store.uploads.delete(upload.id)
    for upload in uploads:
        files.remove(upload.id)


def kept_for(settings: Settings) -> timedelta:
    return timedelta(hours=settings.upload_kept_hours)


def http_date(upload: UploadRecord) -> str:
    return format_datetime(upload.expires_at, usegmt=True)


def told(upload: UploadRecord, offset: int) -> dict[str, str]:
    return {"Upload-Offset": str(offset), "Upload-Length": str(upload.size), "Upload-Expires": http_date(upload)}


def shown(upload: UploadRecord) -> dict[str, Any]:
    return {key: getattr(upload, key) for key in ("id", "name", "size", "expires_at")}
