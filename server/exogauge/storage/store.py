"""The store: everything that is kept, by noun, inside one transaction.

    storage = open_storage(settings)
    with storage.transaction() as store:        # commits at the end, rolls back on any error
        study = store.studies.get(study_id)
    with storage.reading() as store: ...        # never waits for the writer; must not write

Order of writing: the blob first (durable when `put` returns), the row after. Killed between the two, the store holds a
blob that nobody names, never a row whose bytes are missing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from typing import final

import sqlalchemy as sa
from sqlalchemy.engine import Engine
from sqlalchemy.orm import Session

from exogauge.errors import NotFound
from exogauge.settings import Settings
from exogauge.storage.blobs import BlobStore, FolderBlobs
from exogauge.storage.bundles import DEVICES, PAYLOADS, ROBOTS, STUDIES, Bundles
from exogauge.storage.database import READONLY, database_now, make_engine, serving
from exogauge.storage.jobs import Jobs, Results
from exogauge.storage.keys import Keys
from exogauge.storage.live_streams import LiveStreams
from exogauge.storage.logs import Logs
from exogauge.storage.mappings import Mappings
from exogauge.storage.records import JobRecord, StudyRecord
from exogauge.storage.rows import Lab
from exogauge.storage.tables import WorkerLease
from exogauge.storage.uploads import Uploads


@final
class Store:
    """One lab's things inside one transaction (`session`), and the blobs beside them."""

    def __init__(self, session: Session, blobs: BlobStore, lab_id: str = "local") -> None:
        lab = Lab(session, lab_id)
        self.session = session
        self.blobs = blobs
        self.lab_id = lab_id
        self.robots = Bundles(lab, blobs, ROBOTS)
        self.devices = Bundles(lab, blobs, DEVICES)
        self.logs = Logs(lab)
        self.studies = Bundles(lab, blobs, STUDIES)
        self.payloads = Bundles(lab, blobs, PAYLOADS)
        self.live_streams = LiveStreams(lab)
        self.jobs = Jobs(lab)
        self.results = Results(lab)
        self.keys = Keys(lab)
        self.uploads = Uploads(lab)
        self.mappings = Mappings(lab)

    def study_of(self, job: JobRecord) -> StudyRecord:
        """NotFound for a job of a payload."""
        if job.study_id is None:
            raise NotFound(f"job {job.id} is of a payload, not of a study")
        return self.studies.get(job.study_id)

    def workers_alive(self, within: timedelta = timedelta(seconds=15)) -> int:
        """How many workers have given a sign of life on the database's clock."""
        since = database_now(self.session) - within
        alive = sa.select(sa.func.count()).select_from(WorkerLease).where(WorkerLease.beat_at >= since)
        return self.session.scalar(alive) or 0


@final
@dataclass(frozen=True)
class Storage:
    """The open database and blob store of one process; safe to share between its threads."""

    engine: Engine
    blobs: BlobStore
    lab_id: str = "local"

    @contextmanager
    def transaction(self) -> Iterator[Store]:
        with serving("answer"), Session(self.engine) as session, session.begin():
            yield Store(session, self.blobs, self.lab_id)

    @contextmanager
    def reading(self) -> Iterator[Store]:
        with serving("answer"), Session(self.engine) as session:
            session.connection(execution_options=READONLY)
            yield Store(session, self.blobs, self.lab_id)

    def close(self) -> None:
        self.engine.dispose()


def open_storage(settings: Settings) -> Storage:
    return Storage(make_engine(settings.database_url), FolderBlobs(settings.blobs), settings.lab)
