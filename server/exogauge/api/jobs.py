"""Jobs: ask for one, watch it, stop it, ask again."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from datetime import datetime
from typing import Annotated, Any, Self, final

from fastapi import Depends, Request, Response
from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from sqlalchemy.orm import Session

from exogauge.api.dependencies import (
    Cursor,
    Id,
    InstallationDep,
    Key,
    Limit,
    ReaderDep,
    StoreDep,
    as_id,
    encoded_cursor,
)
from exogauge.api.problems import Problem, of_failure
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer, ListOf, State
from exogauge.api.threads import short
from exogauge.errors import BadInput, Fault
from exogauge.jobs import requests
from exogauge.jobs.engine import JobQueue
from exogauge.jobs.recipes import recipe_for
from exogauge.progress import Stage
from exogauge.storage.records import JobRecord, ListedJobRecord

router = Router(tags=["jobs"])
CREATING = threading.Lock()


def get_queue(request: Request, installation: InstallationDep) -> JobQueue:
    """The queue of this process, made when it is first needed."""
    with CREATING:
        if not hasattr(request.app.state, "job_queue"):
            request.app.state.job_queue = JobQueue(installation.engine)
    queue: JobQueue = request.app.state.job_queue
    return queue


QueueDep = Annotated[JobQueue, Depends(get_queue)]


OwnerId = Annotated[str | None, Field(min_length=1, max_length=64), AfterValidator(as_id)]


@final
class JobRequest(BaseModel):
    """What to do with a study, payload, motion or plan, whichever the kind is of. settings: override those of its
    study.yaml or payload.yaml."""

    model_config = ConfigDict(extra="forbid")
    study_id: OwnerId = None
    payload_id: OwnerId = None
    motion_id: OwnerId = None
    plan_id: OwnerId = None
    kind: str = Field(default="evaluate", min_length=1, max_length=64)
    settings: dict[str, Any] = Field(default_factory=dict)

    @property
    def owner_id(self) -> str:
        """Of what the kind is of. BadInput where that is not named, or something else too."""
        of = recipe_for(self.kind).of
        named = {"study": self.study_id, "payload": self.payload_id, "motion": self.motion_id, "plan": self.plan_id}
        owner = named.pop(of)
        if owner is None or any(named.values()):
            detail, advice = f"a job of this kind is of a {of}", f"Give {of}_id, and no other."
            raise BadInput(Fault(detail, "wrong_owner", advice, column="kind", value=self.kind))
        return owner


@final
class JobStep(BaseModel):
    """Something that the present attempt did or does. progress: of the whole job when it began, 0..1. stage: of an
    evaluation or identification, where it belongs. seconds: how long it took; null while it goes on."""

    message: str
    progress: float
    stage: Stage | None
    started_at: datetime
    seconds: float | None


@final
class JobOut(Answer):
    """study_id, payload_id, motion_id, plan_id: one of them says what it is of. progress: 0..1. message: what it does
    now; stage: where in an evaluation or identification that belongs; steps: what it did before, with times, and log:
    given when one job is asked for. place: where in the queue it is, in words; ahead: how many start before it. reason:
    why it did not succeed; problem: the same with file, row, column, value and advice, where what was handed in is to
    blame; defect: exogauge itself is to blame. code_version: the code that computes or computed it, null while no
    worker has taken it; requested_code_version: the code that took the request, which a worker of another version does
    not share. cpu_s: CPU seconds that it took. revision: grows with every change and is the id of its events."""

    id: str
    study_id: str | None
    payload_id: str | None
    motion_id: str | None
    plan_id: str | None
    kind: str
    settings: dict[str, Any]
    state: State
    progress: float
    message: str
    stage: Stage | None
    place: str | None = None
    ahead: int | None = None
    steps: list[JobStep] = Field(default_factory=list)
    reason: str | None
    problem: Problem | None = None
    defect: bool = False
    attempts: int
    cpu_s: float
    cancel_requested: bool
    code_version: str | None
    requested_code_version: str
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    revision: int
    log: str | None = None

    @classmethod
    def of(cls, job: JobRecord, session: Session, *, with_log: bool = False) -> Self:
        (told,) = told_of([job], session)
        return cls.model_validate({**told, "steps": steps_of(job), "log": job.log if with_log else None})


def told_of(jobs: Sequence[ListedJobRecord], session: Session) -> list[dict[str, Any]]:
    """What each of them answers (`JobOut`), but for its steps and its log."""
    places = requests.places(session, jobs)
    told = []
    for job in jobs:
        said = {**vars(job), "log": None, "steps": ()}
        if (place := places.get(job.id)) is not None:
            said |= {"place": place.words, "ahead": place.ahead}
        if job.failure is not None:
            said |= {"problem": of_failure(job.failure, job.reason), "defect": bool(job.failure.get("defect"))}
        told.append(said)
    return told


def steps_of(job: JobRecord) -> list[dict[str, Any]]:
    """Each (`JobStep`) ends where the next begins, the last with the job."""
    steps = job.steps or ()
    begun = [datetime.fromisoformat(step["at"]) for step in steps]
    return [
        {**step, "started_at": start, "seconds": None if end is None else max((end - start).total_seconds(), 0.0)}
        for step, start, end in zip(steps, begun, [*begun[1:], job.finished_at], strict=False)
    ]


@final
class JobList(ListOf):
    items: list[JobOut]


@router.post("/jobs", status_code=202, operation_id="submitJob", responses={200: {"model": JobOut}})
def submit_job(wanted: JobRequest, request: Request, response: Response, store: StoreDep, queue: QueueDep) -> JobOut:
    """202: a new job. 200: an equal request is queued, running or succeeded already; this is its job."""
    job, new = requests.submit(store, queue, wanted.owner_id, wanted.kind, wanted.settings)
    return located(JobOut.of(job, store.session), new, request, response)


@router.get("/jobs", operation_id="listJobs")
@short
def list_jobs(
    store: ReaderDep,
    cursor: Cursor,
    limit: Limit = 50,
    study_id: Key = None,
    payload_id: Key = None,
    motion_id: Key = None,
    plan_id: Key = None,
    state: State | None = None,
) -> JobList:
    """Newest first."""
    of = {"study_id": study_id, "payload_id": payload_id, "motion_id": motion_id, "plan_id": plan_id}
    page = store.jobs.page(cursor, limit, state=state, **of)
    items = told_of(page.items, store.session)
    return JobList.model_validate({"items": items, "next_cursor": encoded_cursor(page.after)})


@router.get("/jobs/{job_id}", operation_id="getJob")
@short
def get_job(job_id: Id, store: ReaderDep) -> JobOut:
    """With its log."""
    return JobOut.of(store.jobs.get(str(job_id)), store.session, with_log=True)


@router.post("/jobs/{job_id}/cancel", operation_id="cancelJob")
def cancel_job(job_id: Id, store: StoreDep) -> JobOut:
    """A queued job ends at once, a running one within a second, an ended one stays as it is."""
    return JobOut.of(requests.cancel(store, str(job_id)), store.session)


@router.post("/jobs/{job_id}/retry", status_code=202, operation_id="retryJob", responses={200: {"model": JobOut}})
def retry_job(job_id: Id, request: Request, response: Response, store: StoreDep, queue: QueueDep) -> JobOut:
    """A new job with the request of a failed or cancelled one."""
    job, new = requests.try_again(store, queue, str(job_id))
    return located(JobOut.of(job, store.session), new, request, response)


def located(job: JobOut, new: bool, request: Request, response: Response) -> JobOut:
    """Say where the job is to be found, and whether it is new."""
    response.headers["Location"] = request.url_for("get_job", job_id=job.id).path
    response.status_code = 202 if new else 200
    return job
