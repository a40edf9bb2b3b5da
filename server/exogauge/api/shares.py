"""Who else may read a study: named labs, or every lab of the installation. Without a share it is the lab's alone."""

from __future__ import annotations

from datetime import datetime
from typing import final

from fastapi import Response
from pydantic import BaseModel

from exogauge.api.dependencies import (
    AccountsOn,
    CallerDep,
    Cursor,
    Id,
    InstallationDep,
    Limit,
    ReaderDep,
    StoreDep,
    encoded_cursor,
)
from exogauge.api.lists import Mark, part
from exogauge.api.routing import Router
from exogauge.api.session import Name
from exogauge.api.shapes import Answer, ListOf
from exogauge.storage.shares import shared_with

router = Router(tags=["accounts"], dependencies=[AccountsOn])


@final
class ShareOut(Answer):
    """lab: who may read; null: every lab."""

    id: str
    created_at: datetime
    lab: str | None


@final
class ShareList(ListOf):
    items: list[ShareOut]


@final
class NewShare(BaseModel):
    """lab: its name; null: every lab of this installation, also those to come."""

    lab: Name | None


@final
class SharedOut(Answer):
    """lab: whose it is."""

    study_id: str
    name: str
    lab: str
    since: datetime


@final
class SharedList(ListOf):
    items: list[SharedOut]


@router.get("/studies/{study_id}/shares", operation_id="listShares")
def list_shares(study_id: Id, store: ReaderDep, after: Mark, limit: Limit = 50) -> ShareList:
    """Oldest first."""
    found = store.shares.of(str(study_id))
    items, more = part(found, lambda each: (each.created_at.isoformat(), each.id), after, limit)
    return ShareList(items=[ShareOut.model_validate(each) for each in items], next_cursor=more)


@router.post("/studies/{study_id}/shares", operation_id="shareStudy", status_code=201)
def share_study(study_id: Id, wanted: NewShare, store: StoreDep) -> ShareOut:
    """Its members may read the study, its jobs, results and plots; they change nothing, and find nothing else."""
    return ShareOut.model_validate(store.shares.add(str(study_id), wanted.lab))


@router.delete(
    "/studies/{study_id}/shares/{share_id}", operation_id="endShare", status_code=204, response_class=Response
)
def end_share(study_id: Id, share_id: Id, store: StoreDep) -> Response:
    """At once; who reads its events is cut off within seconds."""
    store.shares.end(str(study_id), str(share_id))
    return Response(status_code=204)


@router.get("/shared", operation_id="listShared")
def list_shared(caller: CallerDep, installation: InstallationDep, cursor: Cursor, limit: Limit = 50) -> SharedList:
    """Studies that other labs let this one read, newest first."""
    with installation.reading() as session:
        page = shared_with(session, caller.lab_id or "", cursor, limit)
    items = [SharedOut.model_validate(each) for each in page.items]
    return SharedList(items=items, next_cursor=encoded_cursor(page.after))
