"""What happens to a job, as server-sent events: each is the whole job, its id the job's revision in the database.

A client that comes back with `Last-Event-ID` gets what changed since; the last event is the final state, and it is
sent to whoever asks later, so that nobody waits for an end that has been. One task of the server looks for all who
listen, at revisions and places alone; a job is read again by those who listen to it when one of these has changed.
"""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from collections.abc import AsyncIterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, final

import sqlalchemy as sa
from fastapi import Depends, Header, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent
from starlette.concurrency import run_in_threadpool

from exogauge.api.dependencies import Id, StorageDep
from exogauge.api.jobs import JobOut
from exogauge.api.routing import Router
from exogauge.errors import NotFound, Unavailable
from exogauge.jobs import requests
from exogauge.storage.job_tables import ENDED
from exogauge.storage.store import Installation, Storage
from exogauge.storage.tables import Job

log = logging.getLogger(__name__)
router = Router(tags=["jobs"])

LOOK_EVERY_S = 0.25
AT_ONCE = 500  # jobs in one statement
LastEventId = Annotated[str | None, Header(alias="Last-Event-ID", max_length=100)]
Seen = tuple[int, requests.Place | None]  # revision, place in the queue
GONE: Seen = (-1, None)
SEEN = sa.select(Job.id, Job.revision, Job.state).where(Job.id.in_(sa.bindparam("keys", expanding=True)))


@final
class Watch:
    """Looks at the jobs that anybody listens to, for as long as anybody does. Belongs to the event loop."""

    def __init__(self, installation: Installation) -> None:
        self._installation = installation
        self._listeners = Counter[str]()
        self._seen = dict[str, Seen]()
        self._news = asyncio.Condition()
        self._task: asyncio.Task[None] | None = None

    @contextmanager
    def of(self, job_id: str) -> Iterator[None]:
        self._listeners[job_id] += 1
        if self._task is None or self._task.done():
            self._task = asyncio.get_running_loop().create_task(self._look())
        try:
            yield
        finally:
            self._listeners[job_id] -= 1
            if not self._listeners[job_id]:
                del self._listeners[job_id]
                self._seen.pop(job_id, None)

    async def change(self, job_id: str, seen: Seen | None) -> Seen:
        """What is to be seen of the job, as soon as it is something else."""
        async with self._news:
            await self._news.wait_for(lambda: self._seen.get(job_id, seen) != seen)
            return self._seen[job_id]

    async def _look(self) -> None:
        while self._listeners:
            try:
                found = await run_in_threadpool(seen_of, self._installation, list(self._listeners))
            except Unavailable as error:
                log.warning("nobody is told of jobs now: %s", error)
            else:
                async with self._news:
                    if found.items() - self._seen.items():
                        self._seen |= {key: value for key, value in found.items() if key in self._listeners}
                        self._news.notify_all()
            await asyncio.sleep(LOOK_EVERY_S)


def seen_of(installation: Installation, job_ids: Sequence[str]) -> dict[str, Seen]:
    """Of jobs of any lab: who listens was let in before."""
    found = dict[str, Seen]()
    with installation.looking() as connection:
        for start in range(0, len(job_ids), AT_ONCE):
            some = job_ids[start : start + AT_ONCE]
            rows = connection.execute(SEEN, {"keys": some}).all()
            places = requests.places_of(connection, [row.id for row in rows if row.state == "queued"])
            found |= dict.fromkeys(some, GONE) | {row.id: (row.revision, places.get(row.id)) for row in rows}
    return found


def existing_job(job_id: Id, storage: StorageDep) -> str:
    """404 before the stream begins. A reader of the request's would keep its connection for as long as the stream."""
    with storage.reading() as store:
        return store.jobs.get(str(job_id)).id


def watch_of(request: Request) -> Watch:
    watch: Watch = request.app.state.watch
    return watch


@router.get("/jobs/{job_id}/events", operation_id="watchJob", response_class=EventSourceResponse)
async def watch_job(
    key: Annotated[str, Depends(existing_job)],
    storage: StorageDep,
    watch: Annotated[Watch, Depends(watch_of)],
    last: LastEventId = None,
) -> AsyncIterable[ServerSentEvent]:
    """Ends with the final state, or where the job was deleted."""
    told = int(last) if last is not None and last.isdecimal() else -1
    place: str | None = None
    seen: Seen | None = None
    with watch.of(key):
        while True:
            seen = await watch.change(key, seen)
            if seen == GONE:
                return
            job = await run_in_threadpool(look, storage, key)
            if job is None:
                seen = None
                await asyncio.sleep(LOOK_EVERY_S)
                continue
            if job.revision != told or job.place != place or job.state in ENDED:
                told, place = job.revision, job.place
                yield ServerSentEvent(event="job", id=str(job.revision), data=job.model_dump(mode="json"))
                if job.state in ENDED:
                    return


def look(storage: Storage, job_id: str) -> JobOut | None:
    """The job now; None while the database is away, or where it was deleted just now: the next look says so."""
    try:
        with storage.reading() as store:
            return JobOut.of(store.jobs.get(job_id), store.session)
    except (Unavailable, NotFound):
        return None
