"""Who asks, by the key of a session or by a token: the account, the lab, and what it may there. Looked up with each
request, so that what was revoked, ended or taken away counts at once."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta
from typing import Literal, cast, final

import sqlalchemy as sa
from sqlalchemy.orm import Session, aliased

from exogauge.storage.account_tables import Account, ApiToken, LabRow, Membership, SessionRow
from exogauge.storage.secrets import hashed
from exogauge.storage.tables import Owned, utc_now

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


def by_session(session: Session, key: str) -> tuple[Caller, bool] | None:
    """And whether its use is to be noted. None: not known, over, or of an account that was disabled."""
    now = utc_now()
    of_lab = sa.and_(Membership.account_id == Account.id, Membership.lab_id == SessionRow.at_lab, is_open(Membership))
    query = (
        sa.select(SessionRow.id, SessionRow.seen_at, Account.id, SessionRow.at_lab, Membership.role)
        .join(Account, Account.id == SessionRow.account_id)
        .outerjoin(Membership, of_lab)
        .where(SessionRow.key_hash == hashed(key), SessionRow.expires_at > now, SessionRow.seen_at > now - IDLE)
        .where(Account.disabled_at.is_(None))
    )
    found = session.execute(query).first()
    if found is None:
        return None
    row, seen_at, account, lab, kept = found
    role = cast(Role | None, kept)
    caller = Caller(f"account:{account}", lab if role else None, role, account_id=account, session_id=row)
    return caller, now - seen_at > NOTED_EVERY


def by_token(session: Session, token: str) -> tuple[Caller, bool] | None:
    """And whether its use is to be noted. None: not known, revoked, over, or of an account that was disabled or is of
    the lab no more."""
    now = utc_now()
    of_lab = sa.and_(Membership.account_id == ApiToken.account_id, Membership.lab_id == ApiToken.lab_id)
    query = (
        sa.select(ApiToken.id, ApiToken.used_at, ApiToken.account_id, ApiToken.lab_id, ApiToken.scope, Membership.role)
        .outerjoin(Account, Account.id == ApiToken.account_id)
        .outerjoin(Membership, of_lab)
        .where(ApiToken.token_hash == hashed(token), ApiToken.revoked_at.is_(None))
        .where(sa.or_(ApiToken.expires_at.is_(None), ApiToken.expires_at > now), Account.disabled_at.is_(None))
        .where(is_open(ApiToken))
    )
    found = session.execute(query).first()
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


def is_open(table: type[Owned]) -> sa.ColumnElement[bool]:
    """The lab of a row is not closed."""
    closed = aliased(LabRow)  # whether or not the query around it asks for labs, too
    return ~sa.exists().where(closed.id == table.lab_id, closed.closed_at.is_not(None))


def note(session: Session, caller: Caller) -> None:
    """That it was used now."""
    if caller.session_id is not None:
        session.execute(sa.update(SessionRow).where(SessionRow.id == caller.session_id).values(seen_at=utc_now()))
    elif caller.token_id is not None:
        session.execute(sa.update(ApiToken).where(ApiToken.id == caller.token_id).values(used_at=utc_now()))
