"""Logs: kept byte for byte, read once in a child process to say what is in them or where they are broken."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Annotated, Any
from uuid import UUID

from fastapi import File, Form, Response, UploadFile

from exogauge.api import checking
from exogauge.api.bundles import let_go
from exogauge.api.dependencies import Cursor, Id, Limit, ReaderDep, SettingsDep, StorageDep, encoded_cursor
from exogauge.api.routing import Router
from exogauge.api.shapes import LogList, LogOut
from exogauge.api.uploads import Allowance, scratch_folder, write
from exogauge.settings import Settings
from exogauge.storage.blobs import copy_out
from exogauge.storage.files import PinnedFile, safe_path
from exogauge.storage.store import Storage

router = Router(tags=["logs"])
MAPPING = "mapping.yaml"


@router.post(
    "/logs",
    operation_id="createLog",
    status_code=201,
    responses={200: {"model": LogOut, "description": "The same file was there already"}},
)
def create_log(
    file: Annotated[UploadFile, File(description="CSV, Parquet or any table that the mapping reads")],
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
    mapping: Annotated[
        UploadFile | None, File(description="mapping.yaml, for other columns than the contract's")
    ] = None,
    robot_id: Annotated[UUID | None, Form(description="robot whose joints and gears the mapping needs")] = None,
) -> LogOut:
    """Check and store one log."""
    name = safe_path(PurePosixPath((file.filename or "").replace("\\", "/")).name)
    pinned, rules, summary = receive(name, file, mapping, robot_id, storage, settings)
    with storage.transaction() as store:
        log, new = store.logs.add(pinned, rules, summary)
        if new:
            store.refuse_bytes(0)
    response.status_code = 201 if new else 200
    return LogOut.model_validate(log)


@router.get("/logs", operation_id="listLogs")
def list_logs(store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> LogList:
    page = store.logs.page(cursor, limit)
    return LogList(items=[LogOut.model_validate(log) for log in page.items], next_cursor=encoded_cursor(page.after))


@router.get("/logs/{log_id}", operation_id="getLog")
def get_log(log_id: Id, store: ReaderDep) -> LogOut:
    return LogOut.model_validate(store.logs.get(str(log_id)))


let_go(router, "log", "logs", lambda store: store.logs, "Studies that were put together with it keep their own file.")


def receive(
    name: str, file: UploadFile, mapping: UploadFile | None, robot_id: UUID | None, storage: Storage, settings: Settings
) -> tuple[PinnedFile, PinnedFile | None, dict[str, Any]]:
    """Lay the files out, have them read, and keep them: the log, its mapping, and what the reading found."""
    with scratch_folder(settings) as scratch:
        robot = None if robot_id is None else lay_out_robot(str(robot_id), storage, scratch)
        allowance = Allowance.of(settings)
        write(file.file, scratch / name, allowance)
        if mapping is not None:
            write(mapping.file, scratch / MAPPING, Allowance(settings.max_description_bytes, 1))
        summary = checking.check_log(scratch, name, None if mapping is None else MAPPING, robot)
        with storage.reading() as store:
            store.refuse_bytes((scratch / name).stat().st_size)
        return (
            PinnedFile(name, storage.blobs.put(scratch / name), (scratch / name).stat().st_size),
            None if mapping is None else pinned_mapping(storage, scratch / MAPPING),
            summary,
        )


def pinned_mapping(storage: Storage, path: Any) -> PinnedFile:
    return PinnedFile(MAPPING, storage.blobs.put(path), path.stat().st_size)


def lay_out_robot(robot_id: str, storage: Storage, folder: Any) -> str:
    """Write a stored robot's files below `folder`; returns the name of its description."""
    with storage.reading() as store:
        store.robots.get(robot_id)
        files = store.robots.files(robot_id)
    for file in files:
        copy_out(storage.blobs, file.sha256, folder / file.path)
    return "robot.yaml"
