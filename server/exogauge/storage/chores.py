"""What is done for the whole installation now and then, by one process at a time, on however many machines.

A chore is a row. Whoever finds it due takes it for a while, on the database's clock, puts its end off while it works,
and says when it is due again and what came of it. A process that was killed holds it no longer than its lease.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import timedelta
from typing import Any, cast

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from exogauge.storage.database import database_now
from exogauge.storage.tables import Chore

LEASE = timedelta(minutes=5)
QUIET = {"synchronize_session": False}


def take(session: Session, name: str, holder: str, *, now_due: bool = False) -> bool:
    """Whether it is due (or is to be done all the same) and nobody has it; it is this holder's then."""
    now = database_now(session)
    if session.get(Chore, name) is None:
        try:
            with session.begin_nested():
                session.add(Chore(name=name, due_at=now))
        except IntegrityError:  # another process was quicker
            pass
    free = Chore.held_until.is_(None) | (Chore.held_until <= now)
    due = sa.true() if now_due else Chore.due_at <= now
    mine = sa.update(Chore).where(Chore.name == name, free, due).values(holder=holder, held_until=now + LEASE)
    return _changed(session, mine)


def hold_on(session: Session, name: str, holder: str) -> bool:
    """Put the end of the lease off; False where it is another's by now."""
    mine = sa.update(Chore).where(Chore.name == name, Chore.holder == holder)
    return _changed(session, mine.values(held_until=database_now(session) + LEASE))


def done(session: Session, name: str, holder: str, again_in: timedelta, outcome: Mapping[str, Any] | None) -> bool:
    """outcome: None where it failed; the last one stays."""
    said: dict[str, Any] = {"holder": None, "held_until": None, "due_at": database_now(session) + again_in}
    if outcome is not None:
        said["outcome"] = dict(outcome)
    return _changed(session, sa.update(Chore).where(Chore.name == name, Chore.holder == holder).values(**said))


def outcomes(session: Session) -> dict[str, Mapping[str, Any]]:
    """Name -> what came of it last."""
    return {row.name: row.outcome for row in session.scalars(sa.select(Chore)) if row.outcome is not None}


def _changed(session: Session, statement: sa.Update) -> bool:
    return cast("sa.CursorResult[Any]", session.execute(statement, execution_options=QUIET)).rowcount == 1
