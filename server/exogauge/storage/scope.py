"""A database session of one lab: what is found, changed and added in it is that lab's, even where a query forgets to
say so. What has to see all labs (the queue) says that, with `OF_ALL_LABS` or in a session of no lab."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy import event
from sqlalchemy.engine import Engine, Result
from sqlalchemy.orm import ORMExecuteState, Session, with_loader_criteria

from exogauge.storage.blobs import BlobStore
from exogauge.storage.database import LAB, READONLY
from exogauge.storage.orphans import names_a_blob, spare
from exogauge.storage.row_security import ALL, see
from exogauge.storage.tables import Owned

OF_ALL_LABS = {"of_all_labs": True}


@final
class LabSession(Session):
    """Closed as any session; the queue's own statements pass as they are. Rows that name blobs spare them. actor: who
    the audit names."""

    def __init__(self, engine: Engine, lab_id: str, actor: str, blobs: BlobStore, *, readonly: bool = False) -> None:
        super().__init__(engine.execution_options(**{LAB: lab_id, READONLY: readonly}), expire_on_commit=False)
        self.lab_id, self.actor, self.blobs = lab_id, actor, blobs


@final
class AllLabsSession(Session):
    """For the queue, for sweeping and for finding out who asks."""

    def __init__(self, engine: Engine, *, readonly: bool = False) -> None:
        super().__init__(engine.execution_options(**{LAB: ALL, READONLY: readonly}), expire_on_commit=False)


@event.listens_for(LabSession, "do_orm_execute")
def look_within_lab(state: ORMExecuteState) -> Result[Any] | None:
    if state.execution_options.get("of_all_labs"):
        return beyond_lab(state)
    if not state.is_orm_statement:
        return None
    lab_id = lab_of(state.session)
    mine = with_loader_criteria(Owned, lambda table: table.lab_id == lab_id, include_aliases=True)
    state.statement = state.statement.options(mine)
    return None


def beyond_lab(state: ORMExecuteState) -> Result[Any]:
    """One statement; its rows are all there when it returns."""
    connection = state.session.connection()
    see(connection, ALL)
    found = state.invoke_statement()
    see(connection, lab_of(state.session))
    return found


@event.listens_for(LabSession, "before_flush")
def add_within_lab(session: Session, *_: Any) -> None:
    lab_id = lab_of(session)
    for row in session.new:
        if isinstance(row, Owned):
            if row.lab_id not in (None, lab_id):
                raise ValueError(f"a row of lab {row.lab_id!a} in a session of lab {lab_id!a}")
            row.lab_id = lab_id


@event.listens_for(LabSession, "before_flush")
def spare_what_is_named(session: Session, *_: Any) -> None:
    keys = {row: sa.inspect(type(row)).column_attrs.keys() for row in session.new}
    named = (getattr(row, key) for row in keys for key in keys[row] if names_a_blob(key))
    spare_blobs(session, {name for name in named if name is not None})


def spare_blobs(session: Session, names: Collection[str]) -> None:
    """For an UPDATE that names blobs; rows that are added do it themselves."""
    assert isinstance(session, LabSession)
    if names:
        spare(session, session.blobs, names)


def lab_of(session: Session) -> str:
    assert isinstance(session, LabSession)
    return session.lab_id


def actor_of(session: Session) -> str:
    assert isinstance(session, LabSession)
    return session.actor
