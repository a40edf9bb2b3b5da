"""Labs that are closed: nobody comes in any more, and after a while all that they have goes.

What they published stays, for whoever has cited it, and so does their audit. In a session of all labs.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from datetime import timedelta

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, NotFound
from exogauge.storage.account_tables import LabRow, SessionRow
from exogauge.storage.database import database_now
from exogauge.storage.records import LabRecord
from exogauge.storage.retention import Undone, nothing_more
from exogauge.storage.rows import as_record, record
from exogauge.storage.secrets import hashed
from exogauge.storage.store import Installation
from exogauge.storage.tables import Base, Job

STAYS = ("audit", "publications", "publication_files")
QUIET = {"synchronize_session": False}


def all_labs(session: Session) -> list[LabRecord]:
    """By name, also those that are closed."""
    return [as_record(LabRecord, row) for row in session.scalars(sa.select(LabRow).order_by(LabRow.name))]


def close_lab(session: Session, key: str, actor: str) -> LabRecord:
    """Its members and tokens come in no more, its jobs are asked to stop, what it shares is read no more."""
    lab = session.get(LabRow, key)
    if lab is None:
        raise NotFound(f"there is no lab {key[:64]!a}")
    if lab.closed_at is None:
        now = database_now(session)
        lab.closed_at = now
        mine = sa.update(Job).where(Job.lab_id == key)
        ended = {"state": "cancelled", "reason": "its lab was closed", "finished_at": now, "cancel_requested": True}
        session.execute(mine.where(Job.state == "queued").values(**ended), execution_options=QUIET)
        session.execute(mine.where(Job.state == "running").values(cancel_requested=True), execution_options=QUIET)
        session.execute(sa.update(SessionRow).where(SessionRow.at_lab == key).values(at_lab=None))
        record(session, key, actor, "close", "lab", key, before=hashed(lab.name), said=lab.name)
        session.flush()
    return as_record(LabRecord, lab)


def reopen_lab(session: Session, name: str, actor: str) -> LabRecord:
    lab = session.scalars(sa.select(LabRow).where(LabRow.name == name)).first()
    if lab is None:
        raise NotFound(f"there is no lab {name!a}; what was closed goes for good after a while")
    if lab.closed_at is None:
        raise Conflict(f"the lab {name!a} is open")
    lab.closed_at = None
    record(session, lab.id, actor, "reopen", "lab", lab.id, after=hashed(lab.name), said=lab.name)
    session.flush()
    return as_record(LabRecord, lab)


def due_labs(session: Session, kept: timedelta) -> list[str]:
    """Closed so long ago that all of theirs goes now."""
    return list(session.scalars(sa.select(LabRow.id).where(LabRow.closed_at <= database_now(session) - kept)))


def remove_due(
    installation: Installation, kept: timedelta, still: Callable[[], None] = nothing_more, *, dry: bool = False
) -> dict[str, int]:
    """Labs that were closed so long ago, each in a transaction of its own: how many, and how many rows went. Their
    blobs go with a later sweep. dry: undo each transaction, and so say what would go. still: called before each; raises
    to stop."""
    with installation.reading() as session:
        due = due_labs(session, kept)
    labs = rows = 0
    for key in due:
        still()
        with suppress(Undone), installation.session() as session:
            gone = remove_lab(session, key)
            labs, rows = labs + (gone is not None), rows + (gone or 0)
            if dry:
                raise Undone
    return {"labs": labs, "rows": rows}


def remove_lab(session: Session, key: str) -> int | None:
    """All that it has but what stays; its blobs are swept, where nobody else needs them. How many rows went; None where
    it is open, or gone already."""
    lab, gone = session.get(LabRow, key, with_for_update=True), 0
    if lab is None or lab.closed_at is None:
        return None
    for table in reversed(Base.metadata.sorted_tables):
        if "lab_id" in table.columns and table.name not in STAYS:
            done = session.execute(sa.delete(table).where(table.c.lab_id == key))
            gone += int(getattr(done, "rowcount", 0))
    record(session, key, "housekeeping", "remove", "lab", key, before=hashed(lab.name), said=f"{lab.name}: {gone} rows")
    session.flush()
    session.execute(sa.delete(LabRow).where(LabRow.id == key), execution_options=QUIET)
    return gone
