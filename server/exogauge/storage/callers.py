"""Who asks, by the key of a session or by a token: the account, the lab, and what it may there. Looked up with each
request, so that what was revoked, ended or taken away counts at once."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta
from typing import Any, Literal, cast, final

import sqlalchemy as sa
from sqlalchemy.engine import Connection
from sqlalchemy.orm import Session

from exogauge.storage.account_tables import Account, ApiToken, LabRow, Membership, SessionRow
from exogauge.storage.database import UtcDateTime
from exogauge.storage.secrets import hashed
from exogauge.storage.tables import utc_now

Role = Literal["viewer", "member", "admin"]
RANK: dict[str, int] = {"viewer": 0, "member": 1, "admin": 2}
SESSION = timedelta(days=30)  # the longest that one lasts: NIST SP 800-63B-4, 2.1.3 …
IDLE = timedelta(days=7)  # … and unused
NOTED_EVERY = timedelta(minutes=5)  # that one was used


@final
@dataclass(frozen=True)
class Caller:
    """actor: as the audit has it. role: in lab_id; None of one who is of no lab. By a session, or a token, or neither
    where there are no accounts. guest: of another lab, which lab_id lets read this."""

    actor: str
    lab_id: str | None
    role: Role | None
    account_id: str | None = None
    session_id: str | None = None
    token_id: str | None = None
    guest: bool = False


_account, _token, _session = Account.__table__.c, ApiToken.__table__.c, SessionRow.__table__.c
_of_lab, _closed = Membership.__table__.c, LabRow.__table__.alias()
NOW, KEY = sa.bindparam("now", type_=UtcDateTime()), sa.bindparam("key", type_=sa.String())


def is_open(lab_id: Any) -> sa.ColumnElement[bool]:
    """That lab is not closed; whether or not the query around it asks for labs, too."""
    return ~sa.exists().where(_closed.c.id == lab_id, _closed.c.closed_at.is_not(None))


# Made once: what a request costs is mostly what is made anew with each.
BY_SESSION = (
    sa.select(_session.id, _session.seen_at, _account.id, _session.at_lab, _of_lab.role)
    .join(Account.__table__, _account.id == _session.account_id)
    .outerjoin(
        Membership.__table__,
        sa.and_(_of_lab.account_id == _account.id, _of_lab.lab_id == _session.at_lab, is_open(_of_lab.lab_id)),
    )
    .where(_session.key_hash == KEY, _session.expires_at > NOW, _account.disabled_at.is_(None))
    .where(_session.seen_at > sa.bindparam("idle_since", type_=UtcDateTime()))
)
BY_TOKEN = (
    sa.select(_token.id, _token.used_at, _token.account_id, _token.lab_id, _token.scope, _of_lab.role)
    .outerjoin(Account.__table__, _account.id == _token.account_id)
    .outerjoin(Membership.__table__, sa.and_(_of_lab.account_id == _token.account_id, _of_lab.lab_id == _token.lab_id))
    .where(_token.token_hash == KEY, _token.revoked_at.is_(None), _account.disabled_at.is_(None))
    .where(sa.or_(_token.expires_at.is_(None), _token.expires_at > NOW), is_open(_token.lab_id))
)


def by_session(connection: Connection, key: str) -> tuple[Caller, bool] | None:
    """And whether its use is to be noted. None: not known, over, or of an account that was disabled."""
    now = utc_now()
    found = connection.execute(BY_SESSION, {"key": hashed(key), "now": now, "idle_since": now - IDLE}).first()
    if found is None:
        return None
    row, seen_at, account, lab, kept = found
    role = cast(Role | None, kept)
    caller = Caller(f"account:{account}", lab if role else None, role, account_id=account, session_id=row)
    return caller, now - seen_at > NOTED_EVERY


def by_token(connection: Connection, token: str) -> tuple[Caller, bool] | None:
    """And whether its use is to be noted. None: not known, revoked, over, or of an account that was disabled or is of
    the lab no more."""
    now = utc_now()
    found = connection.execute(BY_TOKEN, {"key": hashed(token), "now": now}).first()
    if found is None:
        return None
    row, used_at, account, lab, scope, of_account = found
    if account is not None and of_account is None:
        return None
    role: Role = "member" if scope == "write" else "viewer"
    if of_account is not None and RANK[of_account] < RANK[role]:
        role = cast(Role, of_account)
    caller = Caller(f"token:{row}", lab, role, account_id=account, token_id=row)
    return caller, used_at is None or now - used_at > NOTED_EVERY


def note(session: Session, caller: Caller) -> None:
    """That it was used now."""
    if caller.session_id is not None:
        session.execute(sa.update(SessionRow).where(SessionRow.id == caller.session_id).values(seen_at=utc_now()))
    elif caller.token_id is not None:
        session.execute(sa.update(ApiToken).where(ApiToken.id == caller.token_id).values(used_at=utc_now()))
