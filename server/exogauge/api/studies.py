"""Studies: a folder of files handed in at once, or put together from a robot and logs uploaded before."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal
from uuid import UUID

import yaml
from fastapi import Depends, Query, Response

from exogauge.api import checking
from exogauge.api.bodies import BundleUpload, bundle_schema, study_body
from exogauge.api.bundles import give_files, keep, let_go, listed, shown
from exogauge.api.dependencies import (
    CallerDep,
    Cursor,
    Id,
    Limit,
    ReaderDep,
    Search,
    SettingsDep,
    StorageDep,
)
from exogauge.api.devices import lay_out_device
from exogauge.api.logs import lay_out_robot
from exogauge.api.routing import Router
from exogauge.api.shapes import State, StudyFromParts, StudyList, StudyOut
from exogauge.api.threads import short
from exogauge.api.uploads import lay_out, scratch_folder
from exogauge.errors import BadStudy, Fault
from exogauge.storage.accounts import Accounts
from exogauge.storage.blobs import copy_out
from exogauge.storage.store import Storage

router = Router(tags=["studies"])
STUDY = "study.yaml"
LOGS = "logs"
BODY = bundle_schema("study.yaml and what it names, under their relative paths, or one zip of them", StudyFromParts)


@router.post(
    "/studies",
    operation_id="createStudy",
    status_code=201,
    responses={200: {"model": StudyOut, "description": "The same files were there already"}},
    openapi_extra=BODY,
)
def create_study(
    body: Annotated[BundleUpload | StudyFromParts, Depends(study_body)],
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
) -> StudyOut:
    """Check and store a study; every file is pinned by its hash."""
    with scratch_folder(settings) as scratch:
        if isinstance(body, StudyFromParts):
            put_together(body, storage, scratch)
        else:
            lay_out(body.files, scratch, settings)
        study, new = keep_study(scratch, storage)
    response.status_code = 201 if new else 200
    return study


@router.get("/studies", operation_id="listStudies")
@short
def list_studies(
    store: ReaderDep,
    cursor: Cursor,
    limit: Limit = 50,
    search: Search = "",
    state: Annotated[State | Literal["none"] | None, Query(description="of the latest job; none: has no job")] = None,
    robot_id: Annotated[
        UUID | Literal["none"] | None,
        Query(description="with the robot.yaml and URDF of this robot, byte for byte; none: of no robot in the list"),
    ] = None,
    plan_id: Annotated[UUID | None, Query(description="with the motion of this plan, byte for byte")] = None,
) -> StudyList:
    if isinstance(robot_id, UUID):
        store.robots.get(str(robot_id))
    if plan_id is not None:
        store.plans.get(str(plan_id))
    robot = None if robot_id is None else str(robot_id)
    page = store.studies.page(
        cursor, limit, search=search, state=state, robot_id=robot, plan_id=None if plan_id is None else str(plan_id)
    )
    return listed(store, store.studies, page, StudyOut, StudyList)


@router.get("/studies/{study_id}", operation_id="getStudy")
@short
def get_study(study_id: Id, store: ReaderDep, caller: CallerDep) -> StudyOut:
    answer = shown(store, store.studies, str(study_id), StudyOut)
    answer.shared_by = Accounts(store.session).lab(store.lab_id).name if caller.guest else None
    return answer


give_files(router, "study", "studies", lambda store: store.studies)
let_go(
    router,
    "study",
    "studies",
    lambda store: store.studies,
    "Its jobs, results and files go. 409 while a job waits or runs. Robots, devices and logs stay.",
)


def keep_study(folder: Path, storage: Storage) -> tuple[StudyOut, bool]:
    """The study below `folder`, checked and stored, and whether it is new."""
    study, _, new = keep(folder, STUDY, checking.check_study, storage, lambda store: store.studies)
    with storage.reading() as store:
        return shown(store, store.studies, study.id, StudyOut), new


def put_together(parts: StudyFromParts, storage: Storage, folder: Path) -> None:
    """Lay out a study's folder from what was uploaded before, and write its study.yaml."""
    lay_out_robot(parts.robot_id, storage, folder)
    devices = {key: lay_out_device(key, k, storage, folder) for k, key in enumerate(parts.device_ids)}
    if (folder / LOGS).exists():
        detail = f"the bundle of the robot or a device holds {LOGS!r}, where the logs go"
        raise BadStudy(Fault(detail, "path_clash", "Rename it."))
    with storage.reading() as store:
        logs = [store.logs.get(part.log_id) for part in parts.logs]
    names = []
    for k, log in enumerate(logs):
        files = {"file": f"{LOGS}/{k}/{log.name}"}
        copy_out(storage.blobs, log.sha256, folder / files["file"])
        if log.mapping_sha256 is not None:
            files["mapping"] = f"{LOGS}/{k}/mapping.yaml"
            copy_out(storage.blobs, log.mapping_sha256, folder / files["mapping"])
        names.append(files)
    (folder / STUDY).write_text(yaml.safe_dump(parts.study_yaml(names, devices), allow_unicode=True, sort_keys=False))
