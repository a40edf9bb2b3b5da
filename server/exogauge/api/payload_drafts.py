"""A payload while it is put together: what its files hold, whether it is one by now, and the keeping of it.

Its files are those of a stored payload that are taken over, and uploads, which are used up once it is kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import final

from fastapi import Response

from exogauge.api import checking
from exogauge.api.dependencies import SettingsDep, StorageDep
from exogauge.api.payload_draft_shapes import PayloadDraft, PayloadFindingOut, PayloadLookOut, PayloadVerdictOut
from exogauge.api.payloads import PAYLOAD, PayloadOut, keep_payload
from exogauge.api.problems import of_fault
from exogauge.api.routing import Router
from exogauge.api.uploads import Allowance, free_path, scratch_folder, write
from exogauge.api.uploads_resumable import FilesDep, remove, whole
from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.settings import Settings
from exogauge.storage.blobs import copy_out
from exogauge.storage.partial_files import PartialFiles
from exogauge.storage.records import UploadRecord
from exogauge.storage.store import Storage

router = Router(tags=["payloads"])
OF_ROBOTS = (".urdf", ".xml")
OF_MESHES = (".stl", ".dae", ".obj", ".ply")


@final
@dataclass(frozen=True)
class LaidOut:
    """folder: with the draft's files and payload.yaml, where it has a text. paths: of the others."""

    folder: Path
    paths: tuple[str, ...]
    uploads: tuple[UploadRecord, ...]


@router.post("/payloads/look", operation_id="lookAtPayload")
def look_at_payload(draft: PayloadDraft, storage: StorageDep, settings: SettingsDep, files: FilesDep) -> PayloadLookOut:
    """What the files hold: joints and frames of a URDF, columns of a log and what they may be."""
    with laid_out(draft, storage, settings, files) as here:
        kinds = {path: PurePosixPath(path).suffix.lower() for path in here.paths}
        robots = [path for path, kind in kinds.items() if kind in OF_ROBOTS]
        logs = [path for path, kind in kinds.items() if kind not in (*OF_ROBOTS, *OF_MESHES)]
        seen = checking.look_at_payload(here.folder, robots, logs)
    errors = [of_fault(Fault(**fault)) for fault in seen.pop("faults")]
    return PayloadLookOut(**seen, errors=errors)


@router.post("/payloads/check", operation_id="checkPayload")
def check_payload(
    draft: PayloadDraft, storage: StorageDep, settings: SettingsDep, files: FilesDep, doctor: bool = False
) -> PayloadVerdictOut:
    """Whether it is a payload by now: every log is read, the plan's robot tried at home. doctor: ask it as well."""
    with laid_out(draft, storage, settings, files) as here:
        try:
            summary = checking.check_payload(here.folder)
        except BadInput as bad:
            return PayloadVerdictOut(errors=[of_fault(fault) for fault in bad.faults], summary=None, findings=None)
        asked = doctor and bool(summary["logs"])
        found = [PayloadFindingOut(**each) for each in checking.examine_payload(here.folder)] if asked else None
    return PayloadVerdictOut(errors=[], summary=summary, findings=found)


@router.post(
    "/payloads/from-draft",
    operation_id="createPayloadFromDraft",
    status_code=201,
    responses={200: {"model": PayloadOut, "description": "The same files were there already"}},
)
def create_payload_from_draft(
    draft: PayloadDraft, storage: StorageDep, settings: SettingsDep, files: FilesDep, response: Response
) -> PayloadOut:
    """Check and store it; the uploads are used up when it is there."""
    with laid_out(draft, storage, settings, files) as here:
        payload, new = keep_payload(here.folder, storage)
    remove(here.uploads, storage, files)
    response.status_code = 201 if new else 200
    return payload


@contextmanager
def laid_out(draft: PayloadDraft, storage: Storage, settings: Settings, files: PartialFiles) -> Iterator[LaidOut]:
    """The draft's files in a folder that is gone at the end. Raises NotFound, BadInput."""
    uploads = whole([str(key) for key in draft.upload_ids], storage, files) if draft.upload_ids else []
    allowance, taken = Allowance.of(settings), {PAYLOAD}
    with scratch_folder(settings) as scratch:
        if draft.base_id is not None:
            with storage.reading() as store:
                base = str(draft.base_id)
                kept = [store.payloads.file(base, path) for path in dict.fromkeys(draft.keep)]
            for file in kept:
                allowance.file()
                allowance.take(file.size)
                copy_out(storage.blobs, file.sha256, scratch / free_path(file.path, taken))
        elif draft.keep:
            raise BadStudy(Fault("files are kept of no payload", "no_base", "Give `base_id`.", column="keep"))
        for (_, source), name in zip(uploads, draft.paths, strict=True):
            allowance.file()
            with source.open("rb") as stream:
                write(stream, scratch / free_path(name, taken), allowance)
        if draft.text is not None:
            (scratch / PAYLOAD).write_text(draft.text, encoding="utf-8", errors="backslashreplace")
        names = tuple(path.relative_to(scratch).as_posix() for path in sorted(scratch.rglob("*")) if path.is_file())
        yield LaidOut(scratch, tuple(name for name in names if name != PAYLOAD), tuple(each for each, _ in uploads))
