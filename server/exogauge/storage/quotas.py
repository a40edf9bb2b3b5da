"""What a lab has and uses: bytes, jobs that wait or run, CPU seconds of a day; and whether it may have more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta
from typing import final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import QuotaFull, TooMany
from exogauge.settings import Settings
from exogauge.storage.database import database_now
from exogauge.storage.rows import Lab
from exogauge.storage.tables import Base, Job, Upload

DAY = timedelta(days=1)
JOB_WAIT_S = 60.0  # after which one of many jobs may have ended
CPU_WAIT_S = 3600.0


@final
@dataclass(frozen=True)
class Quotas:
    """Most of each; 0: no limit. bytes: of all files handed in and made."""

    bytes: int = 0
    jobs: int = 0
    cpu_s_per_day: float = 0.0

    @classmethod
    def of(cls, settings: Settings) -> Quotas:
        return cls(settings.lab_bytes, settings.lab_jobs, settings.lab_cpu_s_per_day)


NO_LIMIT = Quotas()


def bytes_of(lab: Lab) -> int:
    """A file counts as often as it was handed in: what a lab has says nothing of others."""
    parts = [
        sa.select(sa.func.coalesce(sa.func.sum(table.c.size), 0)).where(table.c.lab_id == lab.lab_id).scalar_subquery()
        for table in Base.metadata.sorted_tables
        if "size" in table.c and "lab_id" in table.c and table is not Upload.__table__
    ]
    return int(lab.session.scalar(sa.select(sum(parts[1:], parts[0]))) or 0)


def bytes_on_their_way(lab: Lab) -> int:
    """What uploads that began will have; once used they are what was handed in."""
    coming = sa.select(sa.func.sum(Upload.size)).where(Upload.lab_id == lab.lab_id)
    return int(lab.session.scalar(coming) or 0)


def in_turn(lab: Lab) -> None:
    """Until the transaction's end, whoever else counts what the lab has waits, and then sees what came of this one.
    SQLite's writers take turns by themselves."""
    if lab.session.get_bind().dialect.name == "postgresql":
        lab.session.execute(sa.select(sa.func.pg_advisory_xact_lock(sa.func.hashtextextended(lab.lab_id, 0))))


def refuse_bytes(lab: Lab, quotas: Quotas, more: int, *, coming: bool = False) -> None:
    """QuotaFull where the lab would have more than it may. coming: beside what is on its way."""
    if quotas.bytes == 0:
        return
    in_turn(lab)
    more += bytes_on_their_way(lab) if coming else 0
    if (have := bytes_of(lab)) + more > quotas.bytes:
        raise QuotaFull(
            f"the lab keeps {have} of {quotas.bytes} bytes, and {more} more do not fit; delete what is not needed"
        )


def refuse_jobs(lab: Lab, quotas: Quotas) -> None:
    """TooMany where the lab may have no further job now."""
    if quotas.jobs or quotas.cpu_s_per_day:
        in_turn(lab)
    if quotas.jobs and (have := count(lab.session, lab, ("queued", "running"))) >= quotas.jobs:
        raise TooMany(f"{have} jobs of the lab wait or run, as many as may; try again when one has ended", JOB_WAIT_S)
    if quotas.cpu_s_per_day and (used := cpu_s_of(lab)) >= quotas.cpu_s_per_day:
        detail = f"the lab has used {used:.0f} of {quotas.cpu_s_per_day:.0f} CPU seconds in 24 hours; try again later"
        raise TooMany(detail, CPU_WAIT_S)


def count(session: Session, lab: Lab, states: Sequence[str]) -> int:
    mine = sa.select(sa.func.count(Job.id)).where(Job.lab_id == lab.lab_id, Job.state.in_(states))
    return session.scalar(mine) or 0


def cpu_s_of(lab: Lab) -> float:
    """What its jobs that began or ended in the last day have computed."""
    since = database_now(lab.session) - DAY
    recent = sa.or_(Job.started_at >= since, Job.finished_at >= since, Job.state == "running")
    used = sa.select(sa.func.sum(Job.cpu_s)).where(Job.lab_id == lab.lab_id, recent)
    return float(lab.session.scalar(used) or 0.0)
