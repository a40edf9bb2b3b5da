"""What happens to a job, as server-sent events: each is the whole job, its id the job's revision in the database.

A client that comes back with `Last-Event-ID` gets what changed since; the last event is the final state, and it is
sent to whoever asks later, so that nobody waits for an end that has been.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterable
from typing import Annotated

from fastapi import APIRouter, Depends, Header
from fastapi.sse import EventSourceResponse, ServerSentEvent
from starlette.concurrency import run_in_threadpool

from exogauge.api.dependencies import Id, ReaderDep, StorageDep
from exogauge.api.jobs import JobOut
from exogauge.errors import Unavailable
from exogauge.storage.store import Storage

router = APIRouter(tags=["jobs"])

LOOK_EVERY_S = 0.25
ENDED = ("succeeded", "failed", "cancelled")
LastEventId = Annotated[str | None, Header(alias="Last-Event-ID", max_length=100)]


def existing_job(job_id: Id, store: ReaderDep) -> str:
    """404 before the stream begins."""
    return store.jobs.get(str(job_id)).id


@router.get("/jobs/{job_id}/events", operation_id="watchJob", response_class=EventSourceResponse)
async def watch_job(
    key: Annotated[str, Depends(existing_job)], storage: StorageDep, last: LastEventId = None
) -> AsyncIterable[ServerSentEvent]:
    """Ends with the final state."""
    seen = int(last) if last is not None and last.isdecimal() else -1
    place: str | None = None
    while True:
        job = await run_in_threadpool(look, storage, key)
        if job is not None and (job.revision != seen or job.place != place or job.state in ENDED):
            seen, place = job.revision, job.place
            yield ServerSentEvent(event="job", id=str(job.revision), data=job.model_dump(mode="json"))
            if job.state in ENDED:
                return
        await asyncio.sleep(LOOK_EVERY_S)


def look(storage: Storage, job_id: str) -> JobOut | None:
    """The job now; None while the database is away."""
    try:
        with storage.reading() as store:
            return JobOut.of(store.jobs.get(job_id), store.session)
    except Unavailable:
        return None
