"""Plans: motions that are asked for of a robot, what became of them, and the files that robots play."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import yaml
from fastapi import Path as InPath
from fastapi import Query, Request, Response

from exogauge.api.bundles import give_files, let_go
from exogauge.api.dependencies import (
    Cursor,
    Id,
    Key,
    Limit,
    ReaderDep,
    Search,
    SettingsDep,
    StorageDep,
    StoreDep,
    encoded_cursor,
)
from exogauge.api.jobs import QueueDep
from exogauge.api.lists import Mark
from exogauge.api.motions import asked
from exogauge.api.opening_capture import EXPORT
from exogauge.api.plan_shapes import MotionPlanList, MotionPlanOut, PlanAsked, PlanFound
from exogauge.api.results import file_response
from exogauge.api.routing import Router
from exogauge.api.series import SeriesList, page_of, series_of
from exogauge.api.shapes import ArtifactOut, FileOut, State
from exogauge.api.uploads import scratch_folder
from exogauge.errors import BadMotion, BadRobot, Fault, NotFound
from exogauge.jobs import requests
from exogauge.motion.contract import ContactsEntry, PlanFile
from exogauge.storage.blobs import copy_out
from exogauge.storage.bundles import PLANNED
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import ResultRecord, RobotRecord
from exogauge.storage.store import Store

router = Router(tags=["plans"])
PLAN = "plan.yaml"
FORMATS = "csv, hrpsys, mc_rtc, ros2-yaml, ros2-mcap, mujoco or mot"
ZIP: dict[int | str, dict[str, Any]] = {
    200: {"description": "A zip of the files and of what tells of them; csv as it was planned is the table itself",
          "content": {"application/zip": {"schema": {"type": "string", "format": "binary"}}}},
}  # fmt: skip


@router.post(
    "/plans",
    operation_id="createPlan",
    status_code=202,
    responses={200: {"model": MotionPlanOut, "description": "The same was asked for, and is planned or was"}},
)
def create_plan(
    wanted: PlanAsked, request: Request, response: Response, store: StoreDep, queue: QueueDep
) -> MotionPlanOut:
    """Ask for a motion of a robot. An equal request is the same plan; one that failed is tried again."""
    kind = wanted.kind
    robot = store.robots.get(wanted.robot_id)
    motion = None if wanted.motion_id is None else store.motions.get(wanted.motion_id)
    study = None if wanted.study_id is None else store.studies.get(wanted.study_id)
    refuse_unready(robot, kind)
    if motion is not None and motion.summary.get("holds") == "angles":
        advice = "Hand in the markers or the skeleton."
        raise BadMotion(
            Fault("joint angles of another program are not retargeted", "no_skeleton", advice, column="motion_id")
        )
    said = None if motion is None else store.contacts.find(motion.id)
    file = PlanFile(
        robot=robot.content_hash,
        motion=motion and motion.content_hash,
        study=study and study.content_hash,
        contacts=None if said is None else ContactsEntry.model_validate(dict(said.content)),
        retarget=wanted.retarget,
        excite=wanted.excite,
    )
    text = yaml.safe_dump(file.model_dump(exclude_none=True), sort_keys=False).encode()
    pinned = PinnedFile(PLAN, store.blobs.put(text), len(text))
    name = wanted.name or (f"{motion.name} on {robot.name}" if motion is not None else f"{robot.name} excited")
    entry: Any = getattr(file, kind)
    summary = {"kind": kind, "robot": robot.name, "motion": motion and motion.name, "request": entry.model_dump()}
    plan, _ = store.plans.add(
        name[:200], [pinned], summary, robot_id=robot.id, motion_id=motion and motion.id, study_id=study and study.id
    )
    _, new = requests.submit(store, queue, plan.id, kind, {})
    response.headers["Location"] = request.url_for("get_plan", plan_id=plan.id).path
    response.status_code = 202 if new else 200
    return whole(store, plan.id)


@router.get("/plans", operation_id="listPlans")
def list_plans(
    store: ReaderDep,
    cursor: Cursor,
    limit: Limit = 50,
    search: Search = "",
    robot_id: Key = None,
    motion_id: Key = None,
    state: State | None = None,
) -> MotionPlanList:
    """Newest first."""
    page = store.plans.page(cursor, limit, search=search, robot_id=robot_id, motion_id=motion_id, state=state)
    jobs = store.jobs.latest("plan", [plan.id for plan in page.items])
    items = [MotionPlanOut.of(plan, jobs.get(plan.id)) for plan in page.items]
    return MotionPlanList(items=items, next_cursor=encoded_cursor(page.after))


@router.get("/plans/{plan_id}", operation_id="getPlan")
def get_plan(plan_id: Id, store: ReaderDep) -> MotionPlanOut:
    return whole(store, str(plan_id))


give_files(router, "plan", "plans", lambda store: store.plans)
let_go(router, "plan", "plans", lambda store: store.plans, "Its jobs, results and files go. 409 while a job runs.")


@router.get("/plans/{plan_id}/series", operation_id="listPlanSeries")
def list_series(plan_id: Id, store: ReaderDep, after: Mark, limit: Limit = 50) -> SeriesList:
    """Of the newest job that succeeded; their tiles are that job's (`found_job_id`). Empty until there is one."""
    store.plans.get(str(plan_id))
    found = result_of(store, str(plan_id))
    return page_of(store, {} if found is None else series_of(store, found.job_id), after, limit)


@router.get("/plans/{plan_id}/exports/{format}", operation_id="exportPlan", responses=ZIP, response_class=Response)
def export_plan(
    plan_id: Id,
    format: Annotated[str, InPath(max_length=20, description=FORMATS)],
    request: Request,
    storage: StorageDep,
    settings: SettingsDep,
    rate_hz: Annotated[float | None, Query(ge=20.0, le=2000.0, description="of the samples; judged at it")] = None,
    despite: Annotated[bool, Query(description="although a bound is broken; the files are marked")] = False,
) -> Response:
    """The motion for a robot or simulator. 422 where it breaks a bound, unless `despite`."""
    with storage.reading() as store:
        plan = store.plans.get(str(plan_id))
        found = result_of(store, plan.id)
        if found is None:
            raise NotFound(f"plan {plan.id} has no motion yet")
        document = PlanFound.model_validate_json(bytes_of(store, found.sha256))
        table = store.results.artifact(found.job_id, PLANNED)
        robot = store.robots.get(plan.robot_id)
        refuse_broken(document.broken, despite)
        if format == "csv" and rate_hz is None:
            return file_response(store.blobs, request, table.sha256, f"{safe(plan.name)}.csv", table.media_type)
    with scratch_folder(settings) as scratch, TemporaryDirectory(prefix="exogauge-") as own:
        with storage.reading() as store:
            store.robots.write_to(robot.id, scratch / "robot")
        copy_out(storage.blobs, table.sha256, scratch / PLANNED)
        how = {"motion": str(scratch / PLANNED), "name": safe(plan.name), "form": format, "rate_hz": rate_hz}
        told = asked("export", scratch / "robot", Path(own), broken=document.broken, **how)
        refuse_broken(told["broken"], despite)
        content = (Path(own) / EXPORT).read_bytes()
    headers = {"Content-Disposition": f'attachment; filename="{safe(plan.name)}-{safe(format)}.zip"'}
    return Response(content, media_type="application/zip", headers=headers)


def whole(store: Store, plan_id: str) -> MotionPlanOut:
    plan = store.plans.get(plan_id)
    answer = MotionPlanOut.of(plan, store.jobs.latest("plan", [plan_id]).get(plan_id))
    answer.files = [FileOut.model_validate(file) for file in store.plans.files(plan_id)]
    if (found := result_of(store, plan_id)) is not None:
        answer.found = PlanFound.model_validate_json(bytes_of(store, found.sha256))
        answer.found_job_id = found.job_id
        answer.artifacts = [ArtifactOut.of(each) for each in store.results.artifacts(found.job_id)]
    return answer


def result_of(store: Store, plan_id: str) -> ResultRecord | None:
    try:
        return store.results.newest("plan", plan_id)
    except NotFound:
        return None


def bytes_of(store: Store, sha256: str) -> bytes:
    with store.blobs.open(sha256) as stream:
        return stream.read()


def refuse_unready(robot: RobotRecord, kind: str) -> None:
    """BadRobot with what robot.yaml lacks, where its summary tells; of a robot kept before it did, the job finds it."""
    told: dict[str, Any] | None = robot.summary.get("motion")
    if told is None:
        return
    floating, lacking = robot.summary.get("base") == "floating", list[tuple[str, str]]()
    if floating and told["soles"] < 2:
        lacking.append(("soles", "what its two feet stand on"))
    if kind == "retarget" and not floating:
        lacking.append(("base", "a base that floats: motions of people are for robots on two feet"))
    if kind == "retarget" and not {"pelvis", "thorax"} <= set(told["human_map"]):
        lacking.append(("human_map", "which links stand for pelvis and thorax"))
    if lacking:
        advice = "docs/motion.md shows what to add; hand the robot in again."
        said = [(f"robot.yaml does not say {what}", f"no_{key}", key) for key, what in lacking]
        raise BadRobot([Fault(detail, rule, advice, "robot.yaml", None, key) for detail, rule, key in said])


def refuse_broken(broken: list[str], despite: bool) -> None:
    if broken and not despite:
        advice = "Plan it slower or with a smaller share, or ask with `despite=true`: the files are marked then."
        raise BadMotion([Fault(line, "broken", advice, column="despite") for line in broken])


def safe(name: str) -> str:
    """A file's name."""
    return "".join(sign if sign.isascii() and (sign.isalnum() or sign in "-_.") else "_" for sign in name)[:100]
