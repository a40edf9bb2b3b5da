"""The store: everything that is kept, by noun, inside one transaction.

    installation = open_installation(settings)
    storage = installation.of_lab(lab_id)
    with storage.transaction() as store:        # commits at the end, rolls back on any error
        study = store.studies.get(study_id)
    with storage.reading() as store: ...        # never waits for the writer; must not write

Order of writing: the blob first (durable when `put` returns), the row after. Killed between the two, the store holds a
blob that nobody names, never a row whose bytes are missing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Engine
from sqlalchemy.orm import Session

from exogauge.errors import NotFound
from exogauge.settings import Settings
from exogauge.storage.blobs import BlobStore, FolderBlobs
from exogauge.storage.bundles import DEVICES, MOTIONS, PAYLOADS, PLANS, ROBOTS, STUDIES, Bundles
from exogauge.storage.database import LAB, READONLY, database_now, make_engine, serving
from exogauge.storage.held_files import own_folder
from exogauge.storage.jobs import Jobs, Results
from exogauge.storage.keys import Keys
from exogauge.storage.live_streams import LiveStreams
from exogauge.storage.logs import Logs
from exogauge.storage.members import Audit, Invitations, Members, Tokens
from exogauge.storage.publications import Publications
from exogauge.storage.quotas import NO_LIMIT, Quotas, refuse_bytes
from exogauge.storage.records import JobRecord, StudyRecord
from exogauge.storage.remembered import Mappings, contacts_of, maps_of
from exogauge.storage.row_security import ALL
from exogauge.storage.rows import Lab
from exogauge.storage.scope import AllLabsSession, LabSession
from exogauge.storage.shares import Shares
from exogauge.storage.tables import WorkerLease, owner_of
from exogauge.storage.uploads import Uploads
from exogauge.storage.webhooks import Webhooks

LOCAL = "local"  # who does what where there are no accounts


@final
class Store:
    """One lab's things inside one transaction (`session`), and the blobs beside them."""

    def __init__(self, session: Session, blobs: BlobStore, lab_id: str, quotas: Quotas) -> None:
        lab = Lab(session, lab_id)
        self.lab, self.quotas = lab, quotas
        self.session = session
        self.blobs = blobs
        self.lab_id = lab_id
        self.robots = Bundles(lab, blobs, ROBOTS)
        self.devices = Bundles(lab, blobs, DEVICES)
        self.logs = Logs(lab)
        self.studies = Bundles(lab, blobs, STUDIES)
        self.payloads = Bundles(lab, blobs, PAYLOADS)
        self.motions = Bundles(lab, blobs, MOTIONS)
        self.contacts, self.maps = contacts_of(lab), maps_of(lab)
        self.plans = Bundles(lab, blobs, PLANS)
        self.live_streams = LiveStreams(lab)
        self.jobs = Jobs(lab)
        self.results = Results(lab)
        self.keys = Keys(lab)
        self.uploads = Uploads(lab)
        self.mappings = Mappings(lab)
        self.members = Members(lab)
        self.invitations = Invitations(lab)
        self.tokens = Tokens(lab)
        self.audit = Audit(lab)
        self.shares = Shares(lab)
        self.publications = Publications(lab)
        self.webhooks = Webhooks(lab)

    def refuse_bytes(self, more: int, *, coming: bool = False) -> None:
        """QuotaFull where the lab would keep more than it may. coming: as an upload, beside those on their way. What
        this transaction has added counts: who adds asks once more, for nothing more, as others may have added too."""
        refuse_bytes(self.lab, self.quotas, more, coming=coming)

    def owners(self, noun: str) -> Bundles[Any]:
        """All of a sort that jobs can be of: one of `tables.OWNERS`."""
        of: dict[str, Bundles[Any]] = {
            "study": self.studies, "payload": self.payloads, "motion": self.motions, "plan": self.plans,
        }  # fmt: skip
        return of[noun]

    def study_of(self, job: JobRecord) -> StudyRecord:
        """NotFound for a job of anything else."""
        if job.study_id is None:
            raise NotFound(f"job {job.id} is of a {owner_of(job)[0]}, not of a study")
        return self.studies.get(job.study_id)


@contextmanager
def whole(store: Store) -> Iterator[Store]:
    """The store's one transaction: commits at the end, rolls back on any error. Reading ends with a commit too: at a
    rollback PostgreSQL's driver forgets what it has prepared."""
    with serving("answer"), store.session as session:
        yield store
        session.commit()


@final
@dataclass(frozen=True)
class Storage:
    """What one lab has of an installation; safe to share between threads, and cheap to make. actor: who does what is
    done with it, for the audit."""

    engine: Engine
    blobs: BlobStore
    lab_id: str
    actor: str = LOCAL
    quotas: Quotas = NO_LIMIT

    def store(self, *, readonly: bool = False) -> Store:
        """For `whole`: its transaction begins with its first statement."""
        session = LabSession(self.engine, self.lab_id, self.actor, self.blobs, readonly=readonly)
        return Store(session, self.blobs, self.lab_id, self.quotas)

    def transaction(self) -> AbstractContextManager[Store]:
        return whole(self.store())

    def reading(self) -> AbstractContextManager[Store]:
        return whole(self.store(readonly=True))


@final
@dataclass(frozen=True)
class Installation:
    """The open database and blob store of one process, of all labs; safe to share between its threads.

    Whoever serves a request or a job asks for its lab's storage: this one has no lab of its own.
    """

    engine: Engine
    blobs: BlobStore
    quotas: Quotas = NO_LIMIT

    def of_lab(self, lab_id: str, actor: str = LOCAL) -> Storage:
        return Storage(self.engine, self.blobs, lab_id, actor, self.quotas)

    @contextmanager
    def session(self) -> Iterator[Session]:
        """One transaction that sees all labs: for the queue, for sweeping, and for nothing that a request names."""
        with serving("answer"), AllLabsSession(self.engine) as session, session.begin():
            yield session

    @contextmanager
    def reading(self) -> Iterator[Session]:
        """The same for reading only; it never waits for the writer."""
        with serving("answer"), AllLabsSession(self.engine, readonly=True) as session:
            yield session
            session.commit()

    @contextmanager
    def looking(self) -> Iterator[Connection]:
        """The same for statements alone: no mapper is at hand, which costs more than a short one."""
        with serving("answer"), self.engine.connect() as connection:
            connection.execution_options(**{LAB: ALL, READONLY: True})
            yield connection
            connection.commit()

    def workers_alive(self, within: timedelta = timedelta(seconds=15)) -> int:
        """How many workers have given a sign of life on the database's clock; they serve all labs."""
        with self.reading() as session:
            since = database_now(session) - within
            alive = sa.select(sa.func.count()).select_from(WorkerLease).where(WorkerLease.beat_at >= since)
            return session.scalar(alive) or 0

    def close(self) -> None:
        """Connections that a thread still uses are closed when it gives them back."""
        pool = self.engine.pool
        self.engine.dispose()
        sa.event.listen(pool, "checkin", lambda _, record: record.invalidate())


def open_installation(settings: Settings, *, migrating: bool = False) -> Installation:
    """migrating: as the tables' owner, at whatever revision, and with the rows of all labs: for backups."""
    engine = make_engine(settings.database_url, migrating=migrating)
    return Installation(engine, blobs_of(settings), Quotas.of(settings))


def blobs_of(settings: Settings) -> BlobStore:
    """Where `settings` say that bytes are kept."""
    if not settings.blob_url:
        return FolderBlobs(settings.blobs)
    from exogauge.storage.objects import ObjectBlobs, store_of

    sending = own_folder(settings.scratch)
    return ObjectBlobs(store_of(settings), settings.blob_copies, settings.blob_copies_bytes, sending)
