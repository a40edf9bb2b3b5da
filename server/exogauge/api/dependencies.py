"""What endpoints ask for: the store inside one transaction, settings, a page of a list, an id."""

from __future__ import annotations

import base64
import binascii
import json
from datetime import UTC, datetime
from typing import Annotated
from uuid import UUID

from fastapi import Depends, Header, Path, Query, Request
from fastapi.exceptions import RequestValidationError
from fastapi.requests import HTTPConnection
from pydantic import AfterValidator
from starlette.exceptions import HTTPException

from exogauge.errors import Conflict
from exogauge.settings import Settings
from exogauge.storage.callers import Caller
from exogauge.storage.store import Installation, Storage, Store

CALLER = "exogauge.caller"  # in a request's scope: who asks, None for nobody
LONGEST_PAGE = 200
NO_NUL = r"^[^\x00]*$"  # PostgreSQL has no text with it


async def get_settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


async def get_installation(request: Request) -> Installation:
    """What no lab owns: how many workers live, what is to be swept."""
    installation: Installation = request.app.state.installation
    return installation


def caller_of(connection: HTTPConnection) -> Caller:
    """Who asks. `api.access` has seen that they may; what is open to all has no caller, and is not to ask for one."""
    caller: Caller | None = connection.scope[CALLER]
    if caller is None:
        raise HTTPException(401, "sign in")
    return caller


def storage_of(connection: HTTPConnection) -> Storage:
    """What the lab of this request or stream has: that of the session or token, or of the settings where there are no
    accounts. The one place that says which lab it is."""
    caller = caller_of(connection)
    if caller.lab_id is None:
        raise HTTPException(403, "you are of no lab")
    installation: Installation = connection.app.state.installation
    return installation.of_lab(caller.lab_id, caller.actor)


async def get_caller(request: Request) -> Caller:
    return caller_of(request)


def refuse_changed(if_match: str | None, etag: str, what: str) -> None:
    """412 where whoever asks has seen another state than the present one."""
    if if_match is not None and etag not in [part.strip() for part in if_match.split(",")] and if_match.strip() != "*":
        raise HTTPException(412, f"{what} has been changed meanwhile; read it again")


async def public_address(request: Request) -> str:
    """Of the page, without a slash at its end, as others find it."""
    settings = await get_settings(request)
    return settings.public_url or str(request.base_url).rstrip("/")


async def accounts_are_on(request: Request) -> None:
    """409 where there are none."""
    if not request.app.state.accounts:
        raise Conflict(
            "there are no accounts here: whoever reaches this server may do all. EXOGAUGE_ACCOUNTS=1 has them"
        )


async def get_storage(request: Request) -> Storage:
    """The request's lab, for what must happen outside a transaction (writing blobs)."""
    return storage_of(request)


async def get_store(request: Request) -> Store:
    """What an endpoint of `api.routing` reads and writes in one transaction: it has committed before the answer."""
    return storage_of(request).store()


async def get_reader(request: Request) -> Store:
    """The same for reading only; it never waits for a writer."""
    return storage_of(request).store(readonly=True)


async def decoded_cursor(
    cursor: Annotated[str | None, Query(max_length=500, description="`next_cursor` of the page before")] = None,
) -> tuple[datetime, str] | None:
    """Where a list continues."""
    if cursor is None:
        return None
    try:
        when, key = json.loads(base64.urlsafe_b64decode(cursor.encode("ascii")))
        return datetime.fromisoformat(when).astimezone(UTC), str(UUID(key))
    except (ValueError, TypeError, AttributeError, OverflowError, binascii.Error) as error:
        fault = {"type": "cursor_invalid", "loc": ("query", "cursor"), "msg": "not a cursor of this service"}
        raise RequestValidationError([fault]) from error


def encoded_cursor(after: tuple[datetime, str] | None) -> str | None:
    """Opaque to callers; they hand it back as it is."""
    if after is None:
        return None
    return base64.urlsafe_b64encode(json.dumps([after[0].isoformat(), after[1]]).encode()).decode()


def as_id(text: str | None) -> str | None:
    """In small letters, as in a path."""
    try:
        return text and str(UUID(text))
    except ValueError:
        return text  # of nothing, then


Id = Annotated[UUID, Path(description="id of the thing")]
Cursor = Annotated[tuple[datetime, str] | None, Depends(decoded_cursor)]
Limit = Annotated[int, Query(ge=1, le=LONGEST_PAGE, description="most items of one page")]
Search = Annotated[
    str,
    Query(
        max_length=200,
        pattern=NO_NUL,
        description="words that all are in the name, or in the robot's or a device's name; case does not matter. "
        "A word may also begin an id or a content hash",
    ),
]
Name = Annotated[
    str | None, Query(max_length=200, pattern=NO_NUL, description="only those with this name: its versions")
]
Key = Annotated[
    str | None,
    Query(max_length=64, pattern=NO_NUL, description="only those of this one, by its id"),
    AfterValidator(as_id),
]
SettingsDep = Annotated[Settings, Depends(get_settings)]
InstallationDep = Annotated[Installation, Depends(get_installation)]
CallerDep = Annotated[Caller, Depends(get_caller)]
StorageDep = Annotated[Storage, Depends(get_storage)]
StoreDep = Annotated[Store, Depends(get_store)]
ReaderDep = Annotated[Store, Depends(get_reader)]
PublicAddress = Annotated[str, Depends(public_address)]
IfMatch = Annotated[str | None, Header(alias="If-Match", max_length=100, description="ETag of what is replaced")]
AccountsOn = Depends(accounts_are_on)
