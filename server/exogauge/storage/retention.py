"""What goes because it is old, where who runs the installation has said so. Results and what they came of stay, unless
their lab is named with an age; what is published stays whatever its age.

What is removed for good is found in a session of all labs, and removed in one of its lab, whose audit tells it.
What will
go of one lab, and when, its admin is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any, Literal, final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, NotFound
from exogauge.settings import Settings
from exogauge.storage.account_tables import LabRow
from exogauge.storage.database import database_now
from exogauge.storage.job_tables import ENDED
from exogauge.storage.orphans import batches
from exogauge.storage.rows import record
from exogauge.storage.store import Installation
from exogauge.storage.tables import (
    AuditEntry,
    Delivery,
    IdempotencyKey,
    Job,
    Log,
    PayloadFile,
    Plan,
    Publication,
    Study,
    StudyFile,
)

ACTOR = "housekeeping"
AT_ONCE = 500  # judgement: rows in one transaction, as of `orphans`: short enough to hold up nobody
MOST = 20_000  # judgement: rows of a table in one go, so that a lease does not end meanwhile; the next hour's goes on
QUIET = {"synchronize_session": False}
Which = sa.ColumnElement[bool]


@final
@dataclass(frozen=True)
class Ages:
    """After which what goes; None: never. studies: by lab."""

    unused_logs: timedelta | None = None
    job_logs: timedelta | None = None
    deliveries: timedelta | None = None
    studies: Mapping[str, timedelta] = field(default_factory=dict)

    @staticmethod
    def of(settings: Settings) -> Ages:
        def days(said: float) -> timedelta | None:
            return timedelta(days=said) if said else None

        studies = {lab: timedelta(days=said) for lab, said in settings.studies_kept_days.items()}
        return Ages(
            unused_logs=days(settings.unused_logs_kept_days),
            job_logs=days(settings.job_logs_kept_days),
            deliveries=days(settings.deliveries_kept_days),
            studies=studies,
        )


@final
@dataclass(frozen=True)
class Retired:
    """logs: handed in and never used. job_logs: jobs whose log and steps went. deliveries: of webhooks. keys: of
    repeated requests. studies: with their jobs and results; studies_needed: old enough, but something needs them."""

    logs: int = 0
    job_logs: int = 0
    deliveries: int = 0
    keys: int = 0
    studies: int = 0
    studies_needed: int = 0

    def as_json(self) -> dict[str, int]:
        return asdict(self)


def nothing_more() -> None:
    pass


def retire(
    installation: Installation, ages: Ages, still: Callable[[], None] = nothing_more, *, dry: bool = False
) -> Retired:
    """dry: do the same, undo each transaction, and so say what would go. still: called now and then; raises to stop."""
    with installation.reading() as session:
        now = database_now(session)
        due = {table: rows_of(session, table, which) for table, which in which_is_due(ages, now).items()}
        studies = [key for lab, age in ages.studies.items() for key in old_studies(session, lab, now - age)]
    still()
    removing = Removing(installation, still, dry)
    logs = sum(1 for lab, key in due.get(Log, ()) if removing.deleted("logs", lab, key))
    jobs = sum(removing.forget_logs(some) for some in pieces(due.get(Job, ()), still))
    deliveries, keys = (
        sum(removing.remove(table, [key for _, key in some]) for some in pieces(due.get(table, ()), still))
        for table in (Delivery, IdempotencyKey)
    )
    gone = sum(1 for lab, key in studies if removing.deleted("studies", lab, key))
    return Retired(logs, jobs, deliveries, keys, gone, len(studies) - gone)


def no_labs(session: Session, named: Iterable[str], own: str) -> list[str]:
    """Which of the names is no lab's id: an age that was meant for one, and holds for none. own: of a server without
    accounts."""
    return sorted({*named} - {own, *session.scalars(sa.select(LabRow.id))})


def which_is_due(ages: Ages, now: datetime) -> dict[Any, Which]:
    found: dict[Any, Which] = {IdempotencyKey: IdempotencyKey.expires_at <= now}
    if ages.unused_logs is not None:
        used = (
            sa.exists().where(file.lab_id == Log.lab_id, file.sha256 == Log.sha256) for file in (StudyFile, PayloadFile)
        )
        found[Log] = sa.and_(Log.created_at <= now - ages.unused_logs, *(~each for each in used))
    if ages.job_logs is not None:
        old = Job.finished_at <= now - ages.job_logs
        found[Job] = sa.and_(Job.state.in_(ENDED), old, sa.or_(Job.log != "", Job.steps.is_not(None)))
    if ages.deliveries is not None:
        found[Delivery] = Delivery.ended_at <= now - ages.deliveries
    return found


def rows_of(session: Session, table: Any, which: Which) -> list[tuple[str, str]]:
    """Lab and id, of one lab after the other, the oldest first."""
    query = sa.select(table.lab_id, table.id).where(which).order_by(table.lab_id, table.created_at).limit(MOST)
    return [(lab, key) for lab, key in session.execute(query)]


def old_studies(session: Session, lab: str, before: datetime) -> list[tuple[str, str]]:
    """Handed in, and worked with the last time, before then; not those of which something is published."""
    later = sa.exists().where(Job.lab_id == Study.lab_id, Job.study_id == Study.id, Job.finished_at > before)
    kept = (later, *in_use())
    return rows_of(session, Study, sa.and_(Study.lab_id == lab, Study.created_at <= before, *(~each for each in kept)))


def in_use() -> tuple[Any, Any]:
    """Of a study, whatever its age: a job of it has not ended; something of it is published."""
    running = sa.exists().where(Job.lab_id == Study.lab_id, Job.study_id == Study.id, Job.finished_at.is_(None))
    return running, sa.exists().where(Publication.study_id == Study.id, Publication.revoked_at.is_(None))


def pieces(due: Any, still: Callable[[], None]) -> Iterator[list[tuple[str, str]]]:
    for some in batches(due, AT_ONCE):
        still()
        yield some


class Undone(Exception):
    """Ends a transaction that was only tried."""


@final
@dataclass(frozen=True)
class Removing:
    """Removes, or with `dry` tries to."""

    installation: Installation
    still: Callable[[], None]
    dry: bool

    def deleted(self, what: str, lab: str, key: str) -> bool:
        """As whoever is of the lab would: False where something needs it, or it is gone already."""
        self.still()
        try:
            with suppress(Undone), self.installation.of_lab(lab, ACTOR).transaction() as store:
                getattr(store, what).delete(key)
                self._undo()
        except (Conflict, NotFound):
            return False
        return True

    def forget_logs(self, due: list[tuple[str, str]]) -> int:
        """Their words and steps; how they ended, and of what, stays. Listeners are told nothing: revisions stay too."""
        nothing, count = {"log": "", "steps": None, "revision": Job.revision}, 0
        with suppress(Undone), self.installation.session() as session:
            keys = [key for _, key in due]
            mine = sa.update(Job).where(Job.id.in_(keys), Job.state.in_(ENDED)).values(**nothing)
            count = session.execute(mine, execution_options=QUIET).rowcount  # type: ignore[attr-defined]
            for lab in dict.fromkeys(lab for lab, _ in due):
                said = f"logs of {sum(1 for each, _ in due if each == lab)} ended jobs"
                record(session, lab, ACTOR, "forget", "lab", lab[:36], said=said)
            self._undo()
        return int(count)

    def remove(self, table: Any, keys: list[str]) -> int:
        count = 0
        with suppress(Undone), self.installation.session() as session:
            gone = sa.delete(table).where(table.id.in_(keys))
            count = session.execute(gone, execution_options=QUIET).rowcount  # type: ignore[attr-defined]
            self._undo()
        return int(count)

    def _undo(self) -> None:
        if self.dry:
            raise Undone


What = Literal["studies", "unused_logs", "job_logs", "deliveries", "audit"]
NOTHING, EVER = timedelta(0), datetime(9999, 1, 1, tzinfo=UTC)  # an age that all have, and when


@final
@dataclass(frozen=True)
class Outlook:
    """of: how many there are that age alone keeps. stay: that something else keeps, whatever their age. kept: None for
    good. next_at: when the first of them goes."""

    what: What
    of: int
    stay: int
    kept: timedelta | None
    next_at: datetime | None


@final
@dataclass(frozen=True)
class OldStudy:
    """goes_at: when its age is reached."""

    id: str
    name: str
    goes_at: datetime


def outlook(session: Session, lab: str, ages: Ages, audit: timedelta) -> list[Outlook]:
    """audit: the age from which on entries may be put into a file and removed."""
    ever = which_is_due(Ages(unused_logs=NOTHING, job_logs=NOTHING, deliveries=NOTHING), EVER)
    sorts: tuple[tuple[What, Any, Any, timedelta | None], ...] = (
        ("unused_logs", Log, Log.created_at, ages.unused_logs),
        ("job_logs", Job, Job.finished_at, ages.job_logs),
        ("deliveries", Delivery, Delivery.ended_at, ages.deliveries),
        ("audit", AuditEntry, AuditEntry.created_at, audit),
    )
    studies, found = only_aged(lab).subquery(), list[Outlook]()
    counted = sa.select(sa.func.count(), sa.func.min(studies.c.since))
    every = sa.select(sa.func.count(Study.id)).where(Study.lab_id == lab)
    found.append(_told(session, "studies", counted, every, ages.studies.get(lab)))
    for what, table, since, age in sorts:
        aged = ever.get(table, sa.true())
        counted = sa.select(sa.func.count(), sa.func.min(since)).where(table.lab_id == lab, aged)
        every = sa.select(sa.func.count(table.id)).where(table.lab_id == lab)
        found.append(_told(session, what, counted, every, age))
    return found


def _told(session: Session, what: What, counted: Any, every: Any, age: timedelta | None) -> Outlook:
    of, first = session.execute(counted).one()
    stay = (session.scalar(every) or 0) - of
    return Outlook(what, of, stay, age, None if age is None or first is None else first + age)


def next_studies(session: Session, lab: str, age: timedelta, most: int) -> list[OldStudy]:
    """Those that go next, in order."""
    each = only_aged(lab).order_by(sa.text("since"), Study.id).limit(most)
    return [OldStudy(key, name, since + age) for key, name, since in session.execute(each)]


def only_aged(lab: str) -> sa.Select[Any]:
    """id, name and `since` of the lab's studies that nothing but their age keeps: since when nobody works with them."""
    theirs = Job.lab_id == Study.lab_id, Job.study_id == Study.id
    ended = sa.select(sa.func.max(Job.finished_at)).where(*theirs).correlate(Study).scalar_subquery()
    since = sa.case((ended > Study.created_at, ended), else_=Study.created_at).label("since")
    keep = (*in_use(), sa.exists().where(Plan.lab_id == Study.lab_id, Plan.study_id == Study.id))
    return sa.select(Study.id, Study.name, since).where(Study.lab_id == lab, *(~each for each in keep))
