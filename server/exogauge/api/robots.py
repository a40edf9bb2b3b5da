"""Robots: robot.yaml and its URDF, handed in as files or as a zip."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Response

from exogauge.api import checking
from exogauge.api.bodies import BundleUpload, bundle_body, bundle_schema
from exogauge.api.bundles import give_files, keep, let_go, listed, shown
from exogauge.api.dependencies import Cursor, Id, Limit, ReaderDep, Search, SettingsDep, StorageDep
from exogauge.api.routing import Router
from exogauge.api.shapes import RobotList, RobotOut
from exogauge.api.uploads import lay_out, scratch_folder

router = Router(tags=["robots"])
FORM = bundle_schema("robot.yaml and its URDF, under their relative paths, or one zip of them")


@router.post(
    "/robots",
    operation_id="createRobot",
    status_code=201,
    responses={200: {"model": RobotOut, "description": "The same files were there already"}},
    openapi_extra=FORM,
)
def create_robot(
    upload: Annotated[BundleUpload, Depends(bundle_body)],
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
) -> RobotOut:
    """Check and store a robot. Other files under the same name become its next version."""
    with scratch_folder(settings) as scratch:
        lay_out(upload.files, scratch, settings)
        robot, files, new = keep(
            scratch, "robot.yaml", checking.check_robot, storage, lambda store: store.robots, upload.name
        )
    response.status_code = 201 if new else 200
    return RobotOut.of(robot, files=files)


@router.get("/robots", operation_id="listRobots")
def list_robots(store: ReaderDep, cursor: Cursor, limit: Limit = 50, search: Search = "") -> RobotList:
    return listed(store, store.robots, store.robots.page(cursor, limit, search=search), RobotOut, RobotList)


@router.get("/robots/{robot_id}", operation_id="getRobot")
def get_robot(robot_id: Id, store: ReaderDep) -> RobotOut:
    return shown(store, store.robots, str(robot_id), RobotOut)


give_files(router, "robot", "robots", lambda store: store.robots)
let_go(
    router,
    "robot",
    "robots",
    lambda store: store.robots,
    "Its files and remembered mapping go. 409 while a device is of it. Studies keep their own files.",
)
