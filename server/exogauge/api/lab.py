"""A lab: its members and their roles, invitations, tokens of people and robots, and what all of them did."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Annotated, Literal, final

from fastapi import Query, Request, Response
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException

from exogauge.api import passwords
from exogauge.api.dependencies import (
    CALLER,
    AccountsOn,
    CallerDep,
    Cursor,
    Id,
    IfMatch,
    InstallationDep,
    Limit,
    ReaderDep,
    Search,
    SettingsDep,
    StoreDep,
    encoded_cursor,
    refuse_changed,
)
from exogauge.api.lists import Mark, part
from exogauge.api.routing import Router
from exogauge.api.session import (
    Code,
    Email,
    LabOut,
    Name,
    NewLab,
    Password,
    RoleName,
    begun,
    refuse_open_line,
)
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import Conflict, NotFound
from exogauge.storage.accounts import Accounts
from exogauge.storage.callers import RANK, Caller
from exogauge.storage.closing import close_lab
from exogauge.storage.retention import Ages, What, next_studies, outlook
from exogauge.storage.rows import record
from exogauge.storage.secrets import hashed
from exogauge.storage.store import Store
from exogauge.storage.tables import utc_now

router = Router(tags=["accounts"], dependencies=[AccountsOn])
LONGEST_DAYS = 3650  # that a token may hold: ten years, as long as a robot is in use; it can be revoked at any time


@final
class MemberOut(Answer):
    """since: when it became one. disabled_at: who runs the installation has locked the account."""

    account_id: str
    email: str
    name: str
    role: RoleName
    since: datetime
    disabled_at: datetime | None


@final
class MemberList(ListOf):
    items: list[MemberOut]


@final
class NewRole(BaseModel):
    role: RoleName


@final
class InvitationOut(Answer):
    """Open until one of the three times."""

    id: str
    created_at: datetime
    email: str
    role: RoleName
    expires_at: datetime
    accepted_at: datetime | None
    revoked_at: datetime | None


@final
class InvitationList(ListOf):
    items: list[InvitationOut]


@final
class NewInvitation(BaseModel):
    email: Email
    role: RoleName


@final
class Invited(BaseModel):
    """code: shown this once; the page `/invited#CODE` takes it."""

    invitation: InvitationOut
    code: str


@final
class CodeIn(BaseModel):
    code: Code


@final
class InvitedTo(BaseModel):
    """has_account: whoever is invited signs in first, and needs no new password."""

    lab: str
    email: str
    role: RoleName
    has_account: bool
    expires_at: datetime


@final
class Accept(BaseModel):
    """name, password: of a new account; without them, of whoever is signed in."""

    code: Code
    name: Name | None = None
    password: Password | None = None


@final
class TokenOut(Answer):
    """robot: the lab's own; else its maker's, and may no more than he. hint: its first letters."""

    id: str
    created_at: datetime
    name: str
    scope: Literal["read", "write"]
    robot: bool
    owner: str | None
    hint: str
    expires_at: datetime | None
    revoked_at: datetime | None
    used_at: datetime | None


@final
class TokenList(ListOf):
    items: list[TokenOut]


@final
class NewToken(BaseModel):
    """robot: an admin makes one that stays when he leaves. days: until it ends; null: never."""

    name: Name
    scope: Literal["read", "write"] = "read"
    robot: bool = False
    days: Annotated[int | None, Field(ge=1, le=LONGEST_DAYS)] = 90


@final
class MadeToken(BaseModel):
    """secret: shown this once, and kept nowhere."""

    token: TokenOut
    secret: str


@final
class AuditOut(Answer):
    """who: in words, as far as the account or token is known; actor: as it was written down."""

    id: str
    created_at: datetime
    actor: str
    who: str
    action: str
    subject_kind: str
    subject_id: str
    before_hash: str | None
    after_hash: str | None
    said: str


@final
class AuditList(ListOf):
    items: list[AuditOut]


MOST_STUDIES = 50  # judgement: that go next, as many as a list of the API shows at first


@final
class OutlookOut(Answer):
    """of: how many there are that only their age keeps; stay: that something else keeps, whatever their age. kept_days:
    null: for good. next_at: when the first of them goes; of the audit, may be put into a file and removed, by hand.
    setting: by which who runs the service says it."""

    what: What
    of: int
    stay: int
    kept_days: float | None
    next_at: datetime | None
    setting: str


@final
class OldStudyOut(Answer):
    """goes_at: when its age is reached; it goes within an hour then."""

    id: str
    name: str
    goes_at: datetime


@final
class Retention(BaseModel):
    """studies: that go next, in order, where the lab's go by age."""

    lab_id: str
    kinds: list[OutlookOut]
    studies: list[OldStudyOut]


@router.get("/lab", operation_id="getLab")
def get_lab(caller: CallerDep, installation: InstallationDep, response: Response) -> LabOut:
    """The lab whose things are shown."""
    with installation.reading() as session:
        name = Accounts(session).lab(caller.lab_id or "").name
    response.headers["ETag"] = lab_etag(name)
    return LabOut(id=caller.lab_id or "", name=name, role=caller.role or "viewer")


@router.put("/lab", operation_id="renameLab")
def rename_lab(
    wanted: NewLab, caller: CallerDep, installation: InstallationDep, response: Response, if_match: IfMatch = None
) -> LabOut:
    key = caller.lab_id or ""
    with installation.session() as session:
        before = Accounts(session).lab(key).name
        refuse_changed(if_match, lab_etag(before), "the lab")
        lab = Accounts(session).rename_lab(key, wanted.name)
        said = f"{before} → {lab.name}"
        record(session, key, caller.actor, "rename", "lab", key, hashed(before), hashed(lab.name), said)
    response.headers["ETag"] = lab_etag(lab.name)
    return LabOut(id=lab.id, name=lab.name, role="admin")


def lab_etag(name: str) -> str:
    return f'"{hashed(name)}"'


@router.delete("/lab", operation_id="closeLab", status_code=204, response_class=Response)
def close(
    name: Annotated[str, Query(max_length=200, description="of the lab, once more: it closes for all of it")],
    caller: CallerDep,
    installation: InstallationDep,
) -> Response:
    """Nobody comes in any more, at once; after `EXOGAUGE_LAB_KEPT_DAYS` all of it goes but what it has published, and
    its audit. Until then who runs the service can open it again."""
    key = caller.lab_id or ""
    with installation.session() as session:
        accounts = Accounts(session)
        if accounts.lab(key).name != name:
            raise Conflict("this is not the name of the lab")
        close_lab(session, key, caller.actor)
        left = accounts.labs_of(caller.account_id or "")
        if left:
            accounts.show_lab(caller.session_id or "", caller.account_id or "", left[0][0].id)
    return Response(status_code=204)


@router.get("/lab/members", operation_id="listMembers")
def list_members(store: ReaderDep, after: Mark, limit: Limit = 50) -> MemberList:
    """By name."""
    items, more = part(store.members.all(), lambda each: (each.name, each.email), after, limit)
    return MemberList(items=[MemberOut.model_validate(each) for each in items], next_cursor=more)


@router.put("/lab/members/{account_id}", operation_id="setRole")
def set_role(account_id: Id, wanted: NewRole, store: StoreDep) -> MemberOut:
    """409 for the last admin."""
    return MemberOut.model_validate(store.members.set_role(str(account_id), wanted.role))


@router.delete("/lab/members/{account_id}", operation_id="removeMember", status_code=204, response_class=Response)
def remove_member(account_id: Id, store: StoreDep) -> Response:
    """Its tokens for this lab go too; what it handed in stays. 409 for the last admin."""
    store.members.remove(str(account_id))
    return Response(status_code=204)


@router.get("/lab/invitations", operation_id="listInvitations")
def list_invitations(store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> InvitationList:
    """Newest first."""
    page = store.invitations.page(cursor, limit)
    items = [InvitationOut.model_validate(each) for each in page.items]
    return InvitationList(items=items, next_cursor=encoded_cursor(page.after))


@router.post("/lab/invitations", operation_id="invite", status_code=201)
def invite(wanted: NewInvitation, caller: CallerDep, store: StoreDep) -> Invited:
    """Good for a week, once, for this address; nothing is sent: hand the link over yourself."""
    if any(member.email == wanted.email for member in store.members.all()):
        raise Conflict(f"{wanted.email} is a member already")
    invitation, code = store.invitations.add(wanted.email, wanted.role, caller.account_id)
    return Invited(invitation=InvitationOut.model_validate(invitation), code=code)


@router.delete(
    "/lab/invitations/{invitation_id}", operation_id="withdrawInvitation", status_code=204, response_class=Response
)
def withdraw_invitation(invitation_id: Id, store: StoreDep) -> Response:
    store.invitations.revoke(str(invitation_id))
    return Response(status_code=204)


@router.post("/invitations/look", operation_id="lookAtInvitation")
def look_at_invitation(wanted: CodeIn, request: Request, installation: InstallationDep) -> InvitedTo:
    """What it is for. Whoever has the code may know; nobody guesses it."""
    with installation.reading() as session:
        accounts = Accounts(session)
        invitation = accounts.invitation(wanted.code)
        lab = accounts.lab(invitation.lab_id).name
        try:
            accounts.by_email(invitation.email)
            has_account = True
        except NotFound:
            has_account = False
    shown = {key: getattr(invitation, key) for key in ("email", "role", "expires_at")}
    return InvitedTo(lab=lab, has_account=has_account, **shown)


@router.post("/invitations/accept", operation_id="acceptInvitation", status_code=204, response_class=Response)
def accept_invitation(
    wanted: Accept, request: Request, installation: InstallationDep, settings: SettingsDep
) -> Response:
    """As who is signed in, or with a new account, which is signed in then."""
    caller: Caller | None = request.scope[CALLER]
    if wanted.password is None:
        if caller is None or caller.account_id is None or caller.token_id is not None:
            raise HTTPException(403, "sign in first, or choose a name and a password")
        with installation.session() as session:
            accounts = Accounts(session)
            lab_id = accounts.invitation(wanted.code).lab_id
            accounts.accept(wanted.code, caller.account_id)
            accounts.show_lab(caller.session_id or "", caller.account_id, lab_id)
        return Response(status_code=204)
    refuse_open_line(request, settings)
    with installation.reading() as session:
        invitation = Accounts(session).invitation(wanted.code)
    name = wanted.name or invitation.email
    password_hash = passwords.hash_of(passwords.checked(wanted.password, invitation.email, name))
    with installation.session() as session:
        accounts = Accounts(session)
        account = accounts.add(invitation.email, name, password_hash)
        accounts.accept(wanted.code, account.id)
    return begun(account.id, request, installation)


@router.get("/tokens", operation_id="listTokens")
def list_tokens(caller: CallerDep, store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> TokenList:
    """One's own for this lab, newest first; to an admin, those of all."""
    of = None if caller.role == "admin" else caller.account_id
    page = store.tokens.page(cursor, limit, of=of, robots=False)
    people = {member.account_id: member.email for member in store.members.all()}
    items = [token_out(each, people) for each in page.items]
    return TokenList(items=items, next_cursor=encoded_cursor(page.after))


@router.post("/tokens", operation_id="createToken", status_code=201)
def create_token(wanted: NewToken, caller: CallerDep, store: StoreDep) -> MadeToken:
    """For a program: `Authorization: Bearer SECRET`."""
    needed = "admin" if wanted.robot else "member" if wanted.scope == "write" else "viewer"
    if RANK[caller.role or "viewer"] < RANK[needed]:
        raise HTTPException(403, f"this takes the role {needed}, and yours is {caller.role}")
    expires_at = None if wanted.days is None else utc_now() + timedelta(days=wanted.days)
    owner = None if wanted.robot else caller.account_id
    token, secret = store.tokens.add(
        wanted.name, wanted.scope, made_by=caller.account_id, account_id=owner, expires_at=expires_at
    )
    people = {member.account_id: member.email for member in store.members.all()}
    return MadeToken(token=token_out(token, people), secret=secret)


@router.delete("/tokens/{token_id}", operation_id="revokeToken", status_code=204, response_class=Response)
def revoke_token(token_id: Id, caller: CallerDep, store: StoreDep) -> Response:
    """One's own; an admin's hand reaches all."""
    token = store.tokens.get(str(token_id))
    if caller.role != "admin" and token.account_id != caller.account_id:
        raise NotFound(f"there is no token {str(token_id)!a}")
    store.tokens.revoke(token.id)
    return Response(status_code=204)


@router.get("/lab/audit", operation_id="listAudit")
def list_audit(store: ReaderDep, cursor: Cursor, limit: Limit = 50, search: Search = "") -> AuditList:
    """Who did what, newest first. search: words of an action, a sort of thing or what was said; or an id."""
    page = store.audit.page(cursor, limit, search)
    known = names_of(store, {each.actor for each in page.items})
    items = [
        AuditOut(who=known.get(each.actor, each.actor), **{key: getattr(each, key) for key in AUDITED})
        for each in page.items
    ]
    return AuditList(items=items, next_cursor=encoded_cursor(page.after))


@router.get("/lab/retention", operation_id="getRetention")
def get_retention(caller: CallerDep, store: ReaderDep, settings: SettingsDep) -> Retention:
    """What of the lab goes because it is old, what stays, and when."""
    lab, ages = caller.lab_id or "", Ages.of(settings)
    kinds = [
        OutlookOut(
            what=each.what, of=each.of, stay=each.stay, next_at=each.next_at,
            kept_days=None if each.kept is None else each.kept / timedelta(days=1),
            setting=f"EXOGAUGE_{each.what.upper()}_KEPT_DAYS",
        )
        for each in outlook(store.session, lab, ages, timedelta(days=settings.audit_kept_days))
    ]  # fmt: skip
    age = ages.studies.get(lab)
    studies = [] if age is None else next_studies(store.session, lab, age, MOST_STUDIES)
    return Retention(lab_id=lab, kinds=kinds, studies=[OldStudyOut.model_validate(each) for each in studies])


AUDITED = tuple(name for name in AuditOut.model_fields if name != "who")


def names_of(store: Store, actors: set[str]) -> dict[str, str]:
    """actor -> words, also of people who left and tokens that were revoked."""
    accounts, found = Accounts(store.session), {"worker": "worker", "local": "before there were accounts"}
    for actor in actors:
        kind, _, key = actor.partition(":")
        try:
            if kind == "account":
                found[actor] = accounts.get(key).email
            elif kind == "token":
                token = store.tokens.get(key)
                owner = "robot" if token.account_id is None else accounts.get(token.account_id).email
                found[actor] = f"{owner}, token {token.name}"
        except NotFound:
            continue
    return found


def token_out(token: object, people: dict[str, str]) -> TokenOut:
    account = getattr(token, "account_id", None)
    kept = {name: getattr(token, name) for name in TokenOut.model_fields if name not in ("robot", "owner")}
    return TokenOut(robot=account is None, owner=None if account is None else people.get(account), **kept)
