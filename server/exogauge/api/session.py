"""Who is signed in: set-up of the first account, sign in and out, the lab whose pages are shown, one's own account."""

from __future__ import annotations

import hmac
import re
from typing import Annotated, Literal, final

from fastapi import Request, Response
from pydantic import AfterValidator, BaseModel, Field, StringConstraints
from starlette.exceptions import HTTPException

from exogauge.api import passwords
from exogauge.api.access import end_session, session_key, set_session
from exogauge.api.dependencies import CALLER, AccountsOn, CallerDep, InstallationDep, SettingsDep
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer
from exogauge.errors import BadInput, Conflict, Fault
from exogauge.settings import Settings
from exogauge.storage.accounts import Accounts
from exogauge.storage.callers import Caller
from exogauge.storage.rows import record

router = Router(tags=["accounts"])

EMAIL = r"^[^@\s\x00-\x1f]{1,64}@[^@\s\x00-\x1f]{1,189}$"  # not more: only sending to it would tell
NO_CONTROL = r"^[^\x00-\x1f\x7f]*$"
Email = Annotated[str, StringConstraints(pattern=EMAIL, max_length=254), AfterValidator(str.lower)]
Name = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=200, pattern=NO_CONTROL)]
Password = Annotated[str, Field(max_length=1024, json_schema_extra={"format": "password"})]
Code = Annotated[str, Field(min_length=1, max_length=200)]
RoleName = Literal["viewer", "member", "admin"]


@final
class LabOut(Answer):
    """role: of whoever asks."""

    id: str
    name: str
    role: RoleName


@final
class AccountOut(Answer):
    """operator: may found labs."""

    id: str
    email: str
    name: str
    operator: bool


@final
class SessionOut(BaseModel):
    """accounts: whether there are any here; set_up: whether the first one is still to be made. lab: whose things are
    shown; labs: those one could be shown. oidc: name of the provider at which one may sign in, too."""

    accounts: bool
    set_up: bool = False
    account: AccountOut | None = None
    lab: LabOut | None = None
    labs: list[LabOut] = []
    oidc: str | None = None


@final
class SignIn(BaseModel):
    email: Email
    password: Password


@final
class SetUp(BaseModel):
    """code: what the server said when it started."""

    code: Code
    email: Email
    name: Name
    password: Password
    lab: Name


@final
class ShownLab(BaseModel):
    lab_id: Annotated[str, Field(min_length=1, max_length=64)]


@final
class NewPassword(BaseModel):
    current: Password
    new: Password


@final
class NewLab(BaseModel):
    name: Name


@router.get("/session", operation_id="getSession")
def get_session(request: Request, installation: InstallationDep, settings: SettingsDep) -> SessionOut:
    """Who asks, and as what; never refused."""
    caller: Caller | None = request.scope[CALLER]
    if not request.app.state.accounts:
        only = LabOut(id=settings.lab, name=settings.lab, role="admin")
        return SessionOut(accounts=False, lab=only, labs=[only])
    with installation.reading() as session:
        accounts = Accounts(session)
        if caller is None:
            return SessionOut(accounts=True, set_up=not accounts.any(), oidc=settings.oidc_name or None)
        account = None if caller.account_id is None else AccountOut.model_validate(accounts.get(caller.account_id))
        labs = [] if caller.account_id is None else accounts.labs_of(caller.account_id)
        shown = [LabOut(id=lab.id, name=lab.name, role=role) for lab, role in labs]  # type: ignore[arg-type]
        lab = None
        if caller.lab_id is not None and caller.role is not None:
            lab = LabOut(id=caller.lab_id, name=accounts.lab(caller.lab_id).name, role=caller.role)
    only_this = caller.token_id is not None and lab is not None
    labs_shown = [lab] if only_this and lab else shown
    return SessionOut(accounts=True, account=account, lab=lab, labs=labs_shown, oidc=settings.oidc_name or None)


@router.post("/session", operation_id="signIn", status_code=204, response_class=Response, dependencies=[AccountsOn])
def sign_in(wanted: SignIn, request: Request, installation: InstallationDep, settings: SettingsDep) -> Response:
    """By a password. A session that this browser has ends."""
    refuse_open_line(request, settings)
    key = passwords.signed_in(installation, wanted.email, wanted.password, place_of(request))
    return begun(key, request, installation)


@router.delete("/session", operation_id="signOut", status_code=204, response_class=Response, dependencies=[AccountsOn])
def sign_out(request: Request, installation: InstallationDep) -> Response:
    key = session_key(request)
    if key is not None:
        with installation.session() as session:
            Accounts(session).end_session(key)
    response = Response(status_code=204, headers={"Clear-Site-Data": '"cache"'})  # of whoever comes next
    end_session(response, request)
    return response


@router.delete(
    "/sessions", operation_id="signOutElsewhere", status_code=204, response_class=Response, dependencies=[AccountsOn]
)
def sign_out_elsewhere(caller: CallerDep, installation: InstallationDep) -> Response:
    """All other sessions of one's account end."""
    with installation.session() as session:
        Accounts(session).end_sessions(account_of(caller), but=caller.session_id)
    return Response(status_code=204)


@router.put("/session/lab", operation_id="showLab", status_code=204, response_class=Response, dependencies=[AccountsOn])
def show_lab(wanted: ShownLab, caller: CallerDep, installation: InstallationDep) -> Response:
    """Show another lab that one is of, in all tabs of this browser."""
    with installation.session() as session:
        Accounts(session).show_lab(caller.session_id or "", account_of(caller), wanted.lab_id)
    return Response(status_code=204)


@router.post("/set-up", operation_id="setUp", status_code=204, response_class=Response, dependencies=[AccountsOn])
def set_up(wanted: SetUp, request: Request, installation: InstallationDep, settings: SettingsDep) -> Response:
    """The first account, once; it runs the installation, and is admin of the lab whose data are there."""
    refuse_open_line(request, settings)
    passwords.count_try(installation, "set-up", place_of(request))
    code = set_up_code(settings)
    if code is None or not hmac.compare_digest(wanted.code.strip().encode(), code):
        raise HTTPException(403, "this is not the code that the server said when it started")
    password = passwords.checked(wanted.password, wanted.email, wanted.name)
    hashed = passwords.hash_of(password)
    with installation.session() as session:
        accounts = Accounts(session)
        if accounts.any():
            raise Conflict("there is an account already; sign in, or let an admin invite you")
        account = accounts.add(wanted.email, wanted.name, hashed, operator=True)
        lab = accounts.found_lab(wanted.lab, settings.lab)
        accounts.join(account.id, lab.id, "admin", f"account:{account.id}", f"{account.email}, at set-up")
    settings.set_up_code.unlink(missing_ok=True)
    return begun(account.id, request, installation)


@router.put(
    "/account/password",
    operation_id="changePassword",
    status_code=204,
    response_class=Response,
    dependencies=[AccountsOn],
)
def change_password(
    wanted: NewPassword, caller: CallerDep, request: Request, installation: InstallationDep
) -> Response:
    """All other sessions end."""
    key = account_of(caller)
    with installation.reading() as session:
        account, kept = Accounts(session).get(key), Accounts(session).password_hash(key=key)
    passwords.count_try(installation, account.email, place_of(request))
    if not passwords.fits(wanted.current, None if kept is None else kept[1]):
        raise HTTPException(403, "the current password is wrong")
    hashed = passwords.hash_of(passwords.checked(wanted.new, account.email, account.name))
    with installation.session() as session:
        Accounts(session).set_password(key, hashed)
        Accounts(session).end_sessions(key, but=caller.session_id)
        if caller.lab_id is not None:
            record(session, caller.lab_id, caller.actor, "change password", "account", key)
    return Response(status_code=204)


@router.post("/labs", operation_id="createLab", status_code=201, dependencies=[AccountsOn])
def create_lab(wanted: NewLab, caller: CallerDep, installation: InstallationDep) -> LabOut:
    """Found a lab, as its admin; the operator of the installation may."""
    key = account_of(caller)
    with installation.session() as session:
        accounts = Accounts(session)
        account = accounts.get(key)
        if not account.operator:
            raise HTTPException(403, "only who runs this installation founds labs")
        lab = accounts.found_lab(wanted.name)
        accounts.join(key, lab.id, "admin", caller.actor, f"{account.email} founded {lab.name}")
        accounts.show_lab(caller.session_id or "", key, lab.id)
    return LabOut(id=lab.id, name=lab.name, role="admin")


def begun(account_id: str, request: Request, installation: InstallationDep) -> Response:
    """A new session, with a new key, whatever this browser had before."""
    before = session_key(request)
    with installation.session() as session:
        if before is not None:
            Accounts(session).end_session(before)
        key = Accounts(session).begin_session(account_id)
    response = Response(status_code=204)
    set_session(response, request, key)
    return response


def account_of(caller: Caller) -> str:
    if caller.account_id is None:
        raise HTTPException(403, "a robot has no account")
    return caller.account_id


def parsed_email(text: str) -> str:
    """As it is kept. BadInput where it is none."""
    if not re.fullmatch(EMAIL, text):
        raise BadInput(Fault("this is no e-mail address", "no_email", "It has one @.", value=text[:254]))
    return text.lower()


def place_of(request: Request) -> str:
    return "" if request.client is None else request.client.host


def refuse_open_line(request: Request, settings: Settings) -> None:
    """A password goes over an encrypted line, or stays on this machine."""
    if request.url.scheme == "https" or settings.local_only:
        return
    detail = "this came over an unencrypted line; a proxy named in EXOGAUGE_PROXY has to say `X-Forwarded-Proto: https`"
    raise HTTPException(403, detail)


def set_up_code(settings: Settings) -> bytes | None:
    """What the server said; None where there is none, and nothing fits."""
    try:
        return settings.set_up_code.read_text(encoding="ascii").strip().encode() or None
    except FileNotFoundError:
        return None
