"""Sign-in elsewhere: at the OpenID provider that the settings name.

An account is reached by (issuer, subject) that it was linked with: by its owner, signed in, or by an invitation that
was taken up so. An address that a provider tells links nothing.
"""

from __future__ import annotations

import base64
import json
import logging
from datetime import datetime
from typing import Annotated, Literal, final
from urllib.parse import urlencode

from fastapi import Request, Response
from fastapi.responses import RedirectResponse
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException

from exogauge.api.access import cookie_name, session_key, set_session
from exogauge.api.dependencies import (
    CALLER,
    AccountsOn,
    CallerDep,
    Id,
    InstallationDep,
    Limit,
    PublicAddress,
    SettingsDep,
)
from exogauge.api.lists import Mark, part
from exogauge.api.openid import Flow, Identity, NotSignedIn, Provider
from exogauge.api.routing import Router
from exogauge.api.session import Code, account_of, refuse_open_line
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import Conflict, NotFound
from exogauge.storage.accounts import Accounts, Identities
from exogauge.storage.callers import Caller
from exogauge.storage.store import Installation

router = Router(tags=["accounts"], dependencies=[AccountsOn], asks_anything=True)  # a provider adds to its word
log = logging.getLogger(__name__)
LASTS_S = 600  # of which a browser may take to sign in there
OWN_PATH = r"^/([^/\\\x00-\x1f][^\\\x00-\x1f]{0,500})?$"  # of the page, not of another host
Purpose = Literal["sign-in", "link", "invitation"]


class Begin(BaseModel):
    """purpose `link`: for the account that is signed in; `invitation`: with its code. next: the page after that."""

    purpose: Purpose = "sign-in"
    next: Annotated[str, Field(pattern=OWN_PATH)] = "/studies"
    code: Code | None = None


@final
class Begun(BaseModel):
    """url: where the browser goes."""

    url: str


@final
class Kept(Begin):
    """What the cookie holds until the browser comes back."""

    model_config = ConfigDict(extra="forbid")
    state: str
    nonce: str
    verifier: str


@final
class IdentityOut(Answer):
    """subject: as the provider calls whoever it is."""

    id: str
    issuer: str
    subject: str
    created_at: datetime


@final
class IdentityList(ListOf):
    items: list[IdentityOut]


@router.post("/oidc/begin", operation_id="beginOidc")
def begin(wanted: Begin, request: Request, settings: SettingsDep, address: PublicAddress, response: Response) -> Begun:
    """Go to `url` with this browser, and no other."""
    refuse_open_line(request, settings)
    caller: Caller | None = request.scope[CALLER]
    if wanted.purpose == "link" and (caller is None or caller.session_id is None):
        raise HTTPException(403, "sign in first")
    try:
        url, flow = provider_of(request).begin(redirect_uri(address))
    except NotSignedIn as error:
        log.warning("sign-in elsewhere: %s", error)
        raise HTTPException(502, "the provider does not answer as it should; the server's log says more") from error
    kept = Kept(**wanted.model_dump(), **vars(flow)).model_dump_json().encode()
    response.set_cookie(
        flow_cookie(request), base64.urlsafe_b64encode(kept).decode(), max_age=LASTS_S, path="/",
        secure=request.url.scheme == "https", httponly=True, samesite="lax",
    )  # fmt: skip
    return Begun(url=url)


@router.get("/oidc/callback", operation_id="endOidc", status_code=303, response_class=RedirectResponse)
async def end(request: Request, installation: InstallationDep, address: PublicAddress) -> Response:
    """Where the provider sends the browser back to."""
    return await run_in_threadpool(ended, request, installation, address)


def ended(request: Request, installation: Installation, address: str) -> Response:
    kept = kept_in(request)
    try:
        if kept is None:
            raise NotSignedIn("expired", "this browser has begun nothing, or more than ten minutes ago")
        flow = Flow(kept.state, kept.nonce, kept.verifier)
        identity = provider_of(request).finish(flow, dict(request.query_params), redirect_uri(address))
        with installation.session() as session:
            key = account_for(session, kept, identity, request.scope[CALLER])
            secret = None if kept.purpose == "link" else begun(session, key, request)
        response: Response = RedirectResponse(address + kept.next, 303)
        if secret is not None:
            set_session(response, request, secret)
    except NotSignedIn as error:
        log.warning("sign-in elsewhere: %s", error)
        page = "/account" if kept is not None and kept.purpose == "link" else "/sign-in"
        response = RedirectResponse(f"{address}{page}?{urlencode({'oidc': error.reason})}", 303)
    response.delete_cookie(
        flow_cookie(request), path="/", secure=request.url.scheme == "https", httponly=True, samesite="lax"
    )
    return response


@router.get("/account/identities", operation_id="listIdentities")
def list_identities(caller: CallerDep, installation: InstallationDep, after: Mark, limit: Limit = 50) -> IdentityList:
    """Logins elsewhere by which one's account is reached, oldest first."""
    with installation.reading() as session:
        found = Identities(session).of(account_of(caller))
    items, more = part(found, lambda each: (each.created_at.isoformat(), each.id), after, limit)
    return IdentityList(items=[IdentityOut.model_validate(each) for each in items], next_cursor=more)


@router.delete(
    "/account/identities/{identity_id}", operation_id="unlinkIdentity", status_code=204, response_class=Response
)
def unlink_identity(identity_id: Id, caller: CallerDep, installation: InstallationDep) -> Response:
    """409 for the last way into the account."""
    key = account_of(caller)
    with installation.session() as session:
        identities = Identities(session)
        known = [each.id for each in identities.of(key)]
        only = known == [str(identity_id)]
        if only and Accounts(session).password_hash(key=key) is None:
            raise Conflict("this is the only way into the account; who runs the service can set a password for it")
        identities.unlink(key, str(identity_id))
    return Response(status_code=204)


def account_for(session: Session, kept: Kept, identity: Identity, caller: Caller | None) -> str:
    """Whose it is, or by what it was asked for becomes. NotSignedIn."""
    identities, accounts = Identities(session), Accounts(session)
    known = identities.account(identity.issuer, identity.subject)
    if known is not None and accounts.get(known).disabled_at is not None:
        raise NotSignedIn("locked", f"account {known} is locked")
    if kept.purpose == "link":
        if caller is None or caller.session_id is None:
            raise NotSignedIn("expired", "nobody is signed in any more")
        if known is not None and known != caller.account_id:
            raise NotSignedIn("taken", f"{identity.subject!a} is linked with another account")
        key = account_of(caller)
        if known is None:
            identities.link(key, identity.issuer, identity.subject)
        return key
    if kept.purpose == "invitation" and kept.code is not None:
        return invited(accounts, identities, kept.code, identity, known)
    if known is None:
        raise NotSignedIn("unknown", f"{identity.subject!a} is linked with no account")
    return known


def invited(accounts: Accounts, identities: Identities, code: str, identity: Identity, known: str | None) -> str:
    """The invitation is for whoever has its code; it makes the account that it names, and no other."""
    try:
        invitation = accounts.invitation(code)
        if known is None:
            known = accounts.add(invitation.email, identity.name or invitation.email, None).id
            identities.link(known, identity.issuer, identity.subject)
        accounts.accept(code, known)
    except NotFound as error:
        raise NotSignedIn("invitation", str(error)) from error
    except Conflict as error:
        raise NotSignedIn("other", str(error)) from error
    return known


def begun(session: Session, key: str, request: Request) -> str:
    """A new session, with a new key, whatever this browser had before."""
    accounts, before = Accounts(session), session_key(request)
    if before is not None:
        accounts.end_session(before)
    return accounts.begin_session(key)


def kept_in(request: Request) -> Kept | None:
    try:
        kept = base64.urlsafe_b64decode(request.cookies[flow_cookie(request)].encode("ascii"))
        return Kept.model_validate(json.loads(kept))
    except (KeyError, ValueError, ValidationError):
        return None


def provider_of(request: Request) -> Provider:
    """404 where the settings name none."""
    provider: Provider | None = request.app.state.oidc
    if provider is None:
        raise HTTPException(404, "no OpenID provider is named in EXOGAUGE_OIDC_ISSUER")
    return provider


def redirect_uri(address: str) -> str:
    """What is registered at the provider."""
    return f"{address}/api/v1/oidc/callback"


def flow_cookie(request: Request) -> str:
    return f"{cookie_name(request)}-oidc"
