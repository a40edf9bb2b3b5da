"""What of one lab goes because it is old, and when: what `retention` will do, for the lab's admin."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, Literal, final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.storage.retention import Ages, in_use, which_is_due
from exogauge.storage.tables import AuditEntry, Delivery, Job, Log, Plan, Study

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
