"""What arrived by resumable upload becomes a study, a payload or a log, checked like what comes in one request."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, BinaryIO, TypeVar, final
from uuid import UUID

import yaml
from fastapi import Response, UploadFile
from pydantic import BaseModel, ConfigDict, Field

from exogauge.api.dependencies import SettingsDep, StorageDep
from exogauge.api.logs import MAPPING, receive
from exogauge.api.payloads import PayloadOut, keep_payload
from exogauge.api.routing import Router
from exogauge.api.shapes import LogOut, StudyOut
from exogauge.api.studies import keep_study
from exogauge.api.uploads import lay_out, scratch_folder
from exogauge.api.uploads_resumable import FilesDep, remove, whole
from exogauge.errors import BadInput, Fault, NotFound
from exogauge.settings import Settings
from exogauge.storage.files import safe_path
from exogauge.storage.partial_files import PartialFiles
from exogauge.storage.records import UploadRecord
from exogauge.storage.store import Storage

router = Router(tags=["uploads"])
Kept = TypeVar("Kept")
FilePath = Annotated[str, Field(min_length=1, max_length=400)]
MappingGiven = Annotated[dict[str, Any] | str, Field(description="the content of mapping.yaml, as JSON or as its text")]


@final
class StudyFromUpload(BaseModel):
    """One zip, or several files. paths: of each file in the study; default what the upload was called."""

    model_config = ConfigDict(extra="forbid")
    upload_ids: list[UUID] = Field(min_length=1, max_length=1000)
    paths: list[FilePath] | None = Field(default=None, max_length=1000)


@final
class LogFromUpload(BaseModel):
    """robot_id: whose joints and gears the mapping needs."""

    model_config = ConfigDict(extra="forbid")
    upload_id: UUID
    mapping: MappingGiven | None = None
    robot_id: UUID | None = None


@router.post(
    "/studies/from-upload",
    operation_id="createStudyFromUpload",
    status_code=201,
    responses={200: {"model": StudyOut, "description": "The same files were there already"}},
)
def create_study_from_upload(
    wanted: StudyFromUpload, storage: StorageDep, settings: SettingsDep, files: FilesDep, response: Response
) -> StudyOut:
    """Check and store a study of files that were uploaded before; the uploads are used up when it is there."""
    study, new = of_uploads(wanted, storage, settings, files, keep_study)
    response.status_code = 201 if new else 200
    return study


@router.post(
    "/payloads/from-upload",
    operation_id="createPayloadFromUpload",
    status_code=201,
    responses={200: {"model": PayloadOut, "description": "The same files were there already"}},
)
def create_payload_from_upload(
    wanted: StudyFromUpload, storage: StorageDep, settings: SettingsDep, files: FilesDep, response: Response
) -> PayloadOut:
    """Check and store a payload of files that were uploaded before; the uploads are used up when it is there."""
    payload, new = of_uploads(wanted, storage, settings, files, keep_payload)
    response.status_code = 201 if new else 200
    return payload


@router.post(
    "/logs/from-upload",
    operation_id="createLogFromUpload",
    status_code=201,
    responses={200: {"model": LogOut, "description": "The same file was there already"}},
)
def create_log_from_upload(
    wanted: LogFromUpload, storage: StorageDep, settings: SettingsDep, files: FilesDep, response: Response
) -> LogOut:
    """Check and store one log that was uploaded before; the upload is used up when it is there."""
    ((upload, path),) = whole([str(wanted.upload_id)], storage, files)
    name = safe_path(PurePosixPath(upload.name).name)
    text = None if wanted.mapping is None else mapping_text(wanted.mapping)
    mapping = None if text is None else UploadFile(io.BytesIO(text), filename=MAPPING)
    with opened([(upload, path)], [name]) as (part,):
        pinned, rules, summary = receive(name, part, mapping, wanted.robot_id, storage, settings)
    with storage.transaction() as store:
        log, new = store.logs.add(pinned, rules, summary)
        if new:
            store.refuse_bytes(0)
    remove([upload], storage, files)
    response.status_code = 201 if new else 200
    return LogOut.model_validate(log)


def of_uploads(
    wanted: StudyFromUpload,
    storage: Storage,
    settings: Settings,
    files: PartialFiles,
    keep: Callable[[Path, Storage], tuple[Kept, bool]],
) -> tuple[Kept, bool]:
    """What `keep` makes of the folder that the uploads are laid out in; they are removed once it is kept."""
    uploads = whole([str(key) for key in wanted.upload_ids], storage, files)
    with scratch_folder(settings) as scratch:
        with opened(uploads, named(wanted, [upload for upload, _ in uploads])) as parts:
            lay_out(parts, scratch, settings)
        kept = keep(scratch, storage)
    remove([upload for upload, _ in uploads], storage, files)
    return kept


def named(wanted: StudyFromUpload, uploads: Sequence[UploadRecord]) -> list[str]:
    """The path of each upload in the study."""
    if wanted.paths is None:
        return [upload.name for upload in uploads]
    if len(wanted.paths) != len(uploads):
        detail = f"{len(wanted.paths)} paths for {len(uploads)} uploads"
        raise BadInput(Fault(detail, "paths_differ", "Give one path for each upload, or none at all.", column="paths"))
    return wanted.paths


@contextmanager
def opened(uploads: Sequence[tuple[UploadRecord, Path]], names: Sequence[str]) -> Iterator[list[UploadFile]]:
    """The uploads as the files of a form would be."""
    with ExitStack() as stack:
        yield [
            UploadFile(stack.enter_context(still_there(upload, path)), filename=name)
            for (upload, path), name in zip(uploads, names, strict=True)
        ]


def still_there(upload: UploadRecord, path: Path) -> BinaryIO:
    """The file of an upload. NotFound where another request was quicker to use it up."""
    try:
        return path.open("rb")
    except FileNotFoundError as error:
        raise NotFound(f"upload {upload.id} was used up meanwhile") from error


def mapping_text(mapping: dict[str, Any] | str) -> bytes:
    """The bytes of a mapping.yaml."""
    try:
        text = mapping if isinstance(mapping, str) else yaml.safe_dump(mapping, allow_unicode=True, sort_keys=False)
    except RecursionError:
        advice = "A mapping is a few levels deep."
        raise BadInput(Fault("it is nested too deeply", "too_deep", advice, column="mapping")) from None
    return text.encode("utf-8", "backslashreplace")
