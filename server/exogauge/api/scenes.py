"""The 3D view of a job: which logs can be looked at, each as one recording, and the page that plays them."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, final

from fastapi import Path as InPath
from fastapi import Request
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from exogauge.api.dependencies import Id, Limit, ReaderDep, SettingsDep, StorageDep
from exogauge.api.lists import Mark, part
from exogauge.api.logs import lay_out_robot
from exogauge.api.results import unchanged
from exogauge.api.routing import Router
from exogauge.api.series import opened, series_of
from exogauge.api.shapes import ListOf, Role
from exogauge.api.uploads import scratch_folder
from exogauge.api.what_if import lay_out
from exogauge.errors import NotFound
from exogauge.scene.drawing import draw_at_rest, draw_captured, draw_log, draw_payload, draw_played
from exogauge.scene.frames import Frames
from exogauge.scene.stage import POLICY, made_for, player_page
from exogauge.settings import Settings
from exogauge.storage.blobs import copy_out
from exogauge.storage.records import StudyRecord
from exogauge.storage.shelf import Shelf
from exogauge.storage.store import Storage, Store

if TYPE_CHECKING:
    from exogauge.studies.series.file import SeriesFile

router = Router(tags=["scenes"])
CREATING = threading.Lock()
KEPT_BYTES = 512 << 20
MEDIA_TYPE = "application/gzip"
MOTION_VIEW = "1"  # of what is drawn of motions and plans
MOST_PLANS = 50  # looked through for the newest postures
RECORDING: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "The packed scene",
        "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
    },
    206: {"description": "The range asked for", "content": {MEDIA_TYPE: {}}},
    304: {"description": "The ETag given in If-None-Match still holds"},
}
PAGE: dict[int | str, dict[str, Any]] = {
    200: {"description": "HTML", "content": {"text/html": {"schema": {"type": "string"}}}}
}


@final
class SceneOut(BaseModel):
    """One log that can be looked at. Frame k of its recording is at `start` + k / `fps`, in the log's own time."""

    name: str
    log: str
    role: Role | None
    motion: str | None
    start: float = Field(description="[s]")
    end: float = Field(description="[s]")
    fps: float = Field(description="frames per second of log time")
    frames: int
    samples: int = Field(description="of the log")


@final
class SceneList(ListOf):
    items: list[SceneOut]


@router.get("/jobs/{job_id}/scenes", operation_id="listScenes")
def list_scenes(job_id: Id, store: ReaderDep, after: Mark, limit: Limit = 50) -> SceneList:
    """The logs that this job evaluated, in the study's order. A recording is drawn when it is first asked for."""
    job = store.jobs.get(str(job_id))
    study = store.study_of(job)
    series = series_of(store, job.id)
    logs = [log for log in study.summary.get("logs", []) if log["name"] in series]
    shown, more = part(enumerate(logs), lambda each: (each[0],), after, limit)
    items = [scene_of(log, opened(store.blobs, series[log["name"]])) for _, log in shown]
    return SceneList(items=items, next_cursor=more)


@router.get("/jobs/{job_id}/scenes/{name}.scene", operation_id="getScene", responses=RECORDING)
def get_scene(
    job_id: Id,
    name: Annotated[str, InPath(max_length=200, pattern=r"^[^\x00/]*$")],
    request: Request,
    storage: StorageDep,
    settings: SettingsDep,
) -> Response:
    """One log drawn: for the page under `/scenes/player`, which takes it from the page that shows it."""
    with storage.reading() as store:
        job = store.jobs.get(str(job_id))
        study = store.study_of(job)
        series, result = series_of(store, job.id), store.results.of_job(job.id)
    if name not in series or name not in {log["name"] for log in study.summary.get("logs", [])}:
        raise NotFound(f"job {job_id} has evaluated no log of this name")
    key = hashed(study.content_hash, result.sha256, series[name], name, made_for())
    return kept(
        key, lambda: drawn_now(study, name, series[name], result.sha256, storage, settings), name, request, settings
    )


@router.get("/robots/{robot_id}/scene", operation_id="getRobotScene", responses=RECORDING)
def get_robot_scene(robot_id: Id, request: Request, storage: StorageDep, settings: SettingsDep) -> Response:
    """The robot with all joints at zero."""
    with storage.reading() as store:
        robot = store.robots.get(str(robot_id))
    key = hashed(robot.content_hash, made_for())

    def draw() -> bytes:
        with scratch_folder(settings) as scratch:
            lay_out_robot(robot.id, storage, scratch / "robot")
            return draw_at_rest(scratch, "robot", None)

    return kept(key, draw, robot.name, request, settings)


@router.get("/devices/{device_id}/scene", operation_id="getDeviceScene", responses=RECORDING)
def get_device_scene(device_id: Id, request: Request, storage: StorageDep, settings: SettingsDep) -> Response:
    """The device on its robot, all joints at zero; in the player its via points can be dragged."""
    with storage.reading() as store:
        device = store.devices.get(str(device_id))
        robot = store.robots.get(device.robot_id)
        files = store.devices.files(device.id)
    key = hashed(robot.content_hash, device.content_hash, made_for())

    def draw() -> bytes:
        with scratch_folder(settings) as scratch:
            lay_out_robot(robot.id, storage, scratch / "robot")
            for file in files:
                copy_out(storage.blobs, file.sha256, scratch / "device" / file.path)
            return draw_at_rest(scratch, "robot", "device")

    return kept(key, draw, device.name, request, settings)


@router.get("/payloads/{payload_id}/scene", operation_id="getPayloadScene", responses=RECORDING)
def get_payload_scene(payload_id: Id, request: Request, storage: StorageDep, settings: SettingsDep) -> Response:
    """The payload on its robot at home, with what its latest jobs identified and planned."""
    with storage.reading() as store:
        payload = store.payloads.get(str(payload_id))
        found, planned = latest_of(store, payload.id)
    if payload.summary["pose"] != "joints":
        raise NotFound(f"payload {payload.id} names no robot to draw: its pose was logged")
    key = hashed(payload.content_hash, found or "", planned or "", made_for())

    def draw() -> bytes:
        with scratch_folder(settings) as scratch, storage.reading() as store:
            store.payloads.write_to(payload.id, scratch / "payload")
            laid = [scratch / "results.json" if found else None, scratch / "postures.csv" if planned else None]
            for sha256, path in zip((found, planned), laid, strict=True):
                if sha256 is not None and path is not None:
                    copy_out(storage.blobs, sha256, path)
            return draw_payload(scratch / "payload", *laid)

    return kept(key, draw, payload.name, request, settings)


@router.get("/plans/{plan_id}/scene", operation_id="getPlanScene", responses=RECORDING)
def get_plan_scene(plan_id: Id, request: Request, storage: StorageDep, settings: SettingsDep) -> Response:
    """The robot that does what was planned, beside the person whose motion it was."""
    with storage.reading() as store:
        plan = store.plans.get(str(plan_id))
        robot = store.robots.get(plan.robot_id)
        made = {
            each.name: each.sha256 for each in store.results.artifacts(store.results.newest("plan", plan.id).job_id)
        }
    key = hashed(robot.content_hash, made["played.npz"], made.get("human.npz", ""), made_for(), MOTION_VIEW)

    def draw() -> bytes:
        with scratch_folder(settings) as scratch:
            lay_out_robot(robot.id, storage, scratch / "robot")
            laid = {name: scratch / name for name in ("played.npz", "human.npz") if name in made}
            for name, path in laid.items():
                copy_out(storage.blobs, made[name], path)
            return draw_played(scratch / "robot", laid["played.npz"], laid.get("human.npz"))

    return kept(key, draw, plan.name, request, settings)


@router.get("/motions/{motion_id}/scene", operation_id="getMotionScene", responses=RECORDING)
def get_motion_scene(motion_id: Id, request: Request, storage: StorageDep, settings: SettingsDep) -> Response:
    """The person as it was captured; with the body that was fitted to it, once one was."""
    with storage.reading() as store:
        motion = store.motions.get(str(motion_id))
        try:
            job = store.results.newest("motion", motion.id).job_id
            figure: str | None = store.results.artifact(job, "human.npz").sha256
        except NotFound:
            figure = None
    key = hashed(motion.content_hash, figure or "", made_for(), MOTION_VIEW)

    def draw() -> bytes:
        with scratch_folder(settings) as scratch:
            with storage.reading() as store:
                store.motions.write_to(motion.id, scratch / "motion")
            path = None if figure is None else scratch / "human.npz"
            if figure is not None and path is not None:
                copy_out(storage.blobs, figure, path)
            return draw_captured(scratch / "motion", path)

    return kept(key, draw, motion.name, request, settings)


def latest_of(store: Store, payload_id: str) -> tuple[str | None, str | None]:
    """SHA-256 of results.json and of postures.csv of the newest jobs that made them."""
    try:
        found: str | None = store.results.of_payload(payload_id).sha256
    except NotFound:
        found = None
    plans = store.jobs.page(None, MOST_PLANS, payload_id=payload_id, kind="payload_plan", state="succeeded").items
    tables = (each.sha256 for job in plans for each in store.results.artifacts(job.id) if each.name == "postures.csv")
    return found, next(tables, None)


@router.get("/scenes/player", operation_id="getScenePlayer", responses=PAGE)
def get_scene_player() -> Response:
    """The page that shows a scene in a frame (`sandbox="allow-scripts"`). It requests nothing: the page around it hands
    it the scene, and says what time to show, by `postMessage`."""
    return Response(player_page(), media_type="text/html", headers={"Content-Security-Policy": POLICY})


def scene_of(log: Mapping[str, Any], series: SeriesFile) -> SceneOut:
    frames = Frames.of(*series.span(), series.samples)
    return SceneOut(
        name=log["name"],
        log=log["name"],
        role=log.get("role"),
        motion=log.get("motion"),
        start=frames.start,
        end=frames.end,
        fps=frames.fps,
        frames=frames.count,
        samples=series.samples,
    )


def hashed(*parts: str) -> str:
    """A key that is the same for as long as the picture is the same."""
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def kept(key: str, draw: Callable[[], bytes], name: str, request: Request, settings: Settings) -> Response:
    """The scene of this key, drawn now where there is none yet."""
    headers = {"ETag": f'"{key}"', "Cache-Control": "private, no-cache"}
    if unchanged(request, headers["ETag"]):
        return Response(status_code=304, headers=headers)
    path = shelf_of(request, settings).get(key, draw)
    return FileResponse(path, headers=headers, media_type=MEDIA_TYPE, filename=f"{name}.scene")


def shelf_of(request: Request, settings: Settings) -> Shelf:
    with CREATING:
        if not hasattr(request.app.state, "scene_shelf"):
            request.app.state.scene_shelf = Shelf(settings.data_dir / "scenes", KEPT_BYTES, ".scene")
    shelf: Shelf = request.app.state.scene_shelf
    return shelf


def drawn_now(study: StudyRecord, log: str, series: str, result: str, storage: Storage, settings: Settings) -> bytes:
    with storage.reading() as store:
        files = store.studies.files(study.id)
    with scratch_folder(settings) as scratch:
        lay_out(study, files, log, storage, scratch / "study")
        copy_out(storage.blobs, series, scratch / "series.parquet")
        copy_out(storage.blobs, result, scratch / "results.json")
        return draw_log(scratch / "study", log, scratch / "series.parquet", scratch / "results.json")
