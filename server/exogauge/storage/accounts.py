"""Accounts, their sessions and their labs: what no lab owns. Used in a session of all labs (`Installation.session`).

A login at an OpenID provider reaches an account: an issuer, and whom it means.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, NotFound
from exogauge.storage.account_tables import (
    Account,
    IdentityRow,
    Invitation,
    LabRow,
    Membership,
    SessionRow,
    SignInTries,
)
from exogauge.storage.callers import IDLE, RANK, SESSION, is_open
from exogauge.storage.records import AccountRecord, IdentityRecord, InvitationRecord, LabRecord
from exogauge.storage.rows import as_record, record
from exogauge.storage.secrets import hashed, new_key
from exogauge.storage.tables import utc_now

NO_INVITATION = "this invitation is not known, was used or withdrawn, or has run out; ask for another"


@final
@dataclass(frozen=True)
class Accounts:
    session: Session

    def any(self) -> bool:
        return self.session.scalar(sa.select(Account.id).limit(1)) is not None

    def all(self) -> list[AccountRecord]:
        return [
            as_record(AccountRecord, row) for row in self.session.scalars(sa.select(Account).order_by(Account.email))
        ]

    def add(self, email: str, name: str, password_hash: str | None, *, operator: bool = False) -> AccountRecord:
        """Conflict where the address has one."""
        row = Account(email=email, name=name, password_hash=password_hash, operator=operator)
        try:
            with self.session.begin_nested():
                self.session.add(row)
        except IntegrityError:
            raise Conflict(f"{email} has an account already") from None
        return as_record(AccountRecord, row)

    def get(self, key: str) -> AccountRecord:
        return self._one(Account.id == key, key)

    def by_email(self, email: str) -> AccountRecord:
        return self._one(Account.email == email, email)

    def password_hash(self, *, email: str | None = None, key: str | None = None) -> tuple[str, str] | None:
        """The account's id and its hash; None where there is none that could sign in with a password."""
        which = Account.email == email if key is None else Account.id == key
        query = sa.select(Account.id, Account.password_hash).where(which, Account.disabled_at.is_(None))
        found = self.session.execute(query).first()
        return None if found is None or found[1] is None else (found[0], found[1])

    def set_password(self, key: str, password_hash: str) -> None:
        self.session.execute(sa.update(Account).where(Account.id == key).values(password_hash=password_hash))

    def disable(self, key: str, disabled: bool) -> AccountRecord:
        """All its sessions end; its tokens stop at once, and work again when it is enabled."""
        when = utc_now() if disabled else None
        self.session.execute(sa.update(Account).where(Account.id == key).values(disabled_at=when))
        if disabled:
            self.end_sessions(key)
        self.session.expire_all()
        return self.get(key)

    def found_lab(self, name: str, key: str | None = None) -> LabRecord:
        """key: of the lab whose rows are there already."""
        if key is not None and (row := self.session.get(LabRow, key)) is not None:
            return as_record(LabRecord, row)
        row = LabRow(name=name) if key is None else LabRow(id=key, name=name)
        try:
            with self.session.begin_nested():
                self.session.add(row)
        except IntegrityError:
            raise Conflict(f"there is a lab {name!r} already") from None
        return as_record(LabRecord, row)

    def rename_lab(self, key: str, name: str) -> LabRecord:
        try:
            with self.session.begin_nested():
                self.session.execute(sa.update(LabRow).where(LabRow.id == key).values(name=name))
        except IntegrityError:
            raise Conflict(f"there is a lab {name!r} already") from None
        return as_record(LabRecord, self.session.get_one(LabRow, key))

    def lab_named(self, name: str) -> LabRecord | None:
        row = self.session.scalars(sa.select(LabRow).where(LabRow.name == name)).first()
        return None if row is None else as_record(LabRecord, row)

    def join(self, key: str, lab_id: str, role: str, actor: str, said: str) -> None:
        """Make it a member; one that is a member keeps the higher role."""
        mine = Membership.account_id == key, Membership.lab_id == lab_id
        now = self.session.scalars(sa.select(Membership).where(*mine)).first()
        if now is None:
            self.session.add(Membership(account_id=key, lab_id=lab_id, role=role))
        elif RANK[now.role] >= RANK[role]:
            return
        else:
            now.role = role
        record(self.session, lab_id, actor, "join", "member", key, after=hashed(role), said=said)
        self.session.flush()

    def labs_of(self, key: str) -> list[tuple[LabRecord, str]]:
        """With its role in each, by name."""
        query = sa.select(LabRow, Membership.role).join(Membership, Membership.lab_id == LabRow.id)
        mine = Membership.account_id == key, LabRow.closed_at.is_(None)
        rows = self.session.execute(query.where(*mine).order_by(LabRow.name))
        return [(as_record(LabRecord, lab), role) for lab, role in rows]

    def lab(self, key: str) -> LabRecord:
        row = self.session.get(LabRow, key)
        if row is None:
            raise NotFound(f"there is no lab {key[:64]!a}")
        return as_record(LabRecord, row)

    def begin_session(self, key: str) -> str:
        """What its cookie holds. It shows the lab that was shown last, or the first."""
        latest = sa.select(SessionRow.at_lab).where(SessionRow.account_id == key, SessionRow.at_lab.is_not(None))
        before = self.session.scalar(latest.order_by(SessionRow.seen_at.desc()).limit(1))
        labs = [lab.id for lab, _ in self.labs_of(key)]
        at = before if before in labs else labs[0] if labs else None
        secret, now = new_key(), utc_now()
        over = sa.or_(SessionRow.expires_at <= now, SessionRow.seen_at <= now - IDLE)
        self.session.execute(sa.delete(SessionRow).where(over))
        self.session.add(SessionRow(account_id=key, key_hash=hashed(secret), at_lab=at, expires_at=now + SESSION))
        if at is not None:
            record(self.session, at, f"account:{key}", "sign in", "account", key)
        return secret

    def end_session(self, secret: str) -> None:
        self.session.execute(sa.delete(SessionRow).where(SessionRow.key_hash == hashed(secret)))

    def end_sessions(self, key: str, but: str | None = None) -> None:
        mine = sa.delete(SessionRow).where(SessionRow.account_id == key)
        self.session.execute(mine if but is None else mine.where(SessionRow.id != but))

    def show_lab(self, session_id: str, account_id: str, lab_id: str) -> None:
        """NotFound where the account is not of it: whether there is such a lab is not told."""
        if lab_id not in [lab.id for lab, _ in self.labs_of(account_id)]:
            raise NotFound(f"there is no lab {lab_id[:64]!a}")
        self.session.execute(sa.update(SessionRow).where(SessionRow.id == session_id).values(at_lab=lab_id))

    def invitation(self, code: str) -> InvitationRecord:
        """NotFound unless it is open; what was wrong with it is not told."""
        open_ = Invitation.accepted_at.is_(None), Invitation.revoked_at.is_(None), Invitation.expires_at > utc_now()
        known = Invitation.code_hash == hashed(code), is_open(Invitation.lab_id)
        row = self.session.scalars(sa.select(Invitation).where(*known, *open_)).first()
        if row is None:
            raise NotFound(NO_INVITATION)
        return as_record(InvitationRecord, row)

    def accept(self, code: str, key: str) -> None:
        """The account becomes what the invitation says, once. It may be of the invited address alone."""
        invitation, account = self.invitation(code), self.get(key)
        if account.email != invitation.email:
            raise Conflict(f"this invitation is for {invitation.email}, and you are signed in as {account.email}")
        still = Invitation.id == invitation.id, Invitation.accepted_at.is_(None), Invitation.revoked_at.is_(None)
        done: Any = self.session.execute(sa.update(Invitation).where(*still).values(accepted_at=utc_now()))
        if done.rowcount != 1:
            raise NotFound(NO_INVITATION)
        self.join(
            key, invitation.lab_id, invitation.role, f"account:{key}", f"{account.email} as {invitation.role}, invited"
        )

    def count_tries(self, keys: Sequence[str], within: timedelta) -> list[int]:
        """Count one more try of each, and say how many there were within the time; one statement each, so that tries at
        once are all counted."""
        now, made = utc_now(), postgresql if self.session.get_bind().dialect.name == "postgresql" else sqlite
        found = []
        for key in sorted(keys):  # always in one order: two that wait for each other would wait for ever
            table = SignInTries
            new = made.insert(table).values(key_hash=key, tries=1, since=now)
            old = table.since <= now - within
            again = {"tries": sa.case((old, 1), else_=table.tries + 1), "since": sa.case((old, now), else_=table.since)}
            counted = new.on_conflict_do_update(index_elements=[table.key_hash], set_=again).returning(table.tries)
            found.append((key, self.session.execute(counted).scalar_one()))
        counts = dict(found)
        return [counts[key] for key in keys]

    def forget_tries(self, keys: Sequence[str], before: timedelta) -> None:
        """Of these keys, and what is older."""
        old = sa.or_(SignInTries.key_hash.in_(keys), SignInTries.since <= utc_now() - before)
        self.session.execute(sa.delete(SignInTries).where(old))

    def _one(self, which: sa.ColumnElement[bool], said: str) -> AccountRecord:
        row = self.session.scalars(sa.select(Account).where(which)).first()
        if row is None:
            raise NotFound(f"there is no account {said[:254]!a}")
        return as_record(AccountRecord, row)


@final
@dataclass(frozen=True)
class Identities:
    session: Session

    def account(self, issuer: str, subject: str) -> str | None:
        """Whose it is."""
        mine = IdentityRow.issuer == issuer, IdentityRow.subject == subject
        return self.session.scalar(sa.select(IdentityRow.account_id).where(*mine))

    def of(self, account_id: str) -> list[IdentityRecord]:
        """Oldest first."""
        query = sa.select(IdentityRow).where(IdentityRow.account_id == account_id)
        rows = self.session.scalars(query.order_by(IdentityRow.created_at, IdentityRow.id))
        return [as_record(IdentityRecord, row) for row in rows]

    def link(self, account_id: str, issuer: str, subject: str) -> None:
        """Conflict where it is another account's."""
        try:
            with self.session.begin_nested():
                self.session.add(IdentityRow(account_id=account_id, issuer=issuer, subject=subject))
        except IntegrityError:
            raise Conflict("this login is linked with an account already") from None

    def unlink(self, account_id: str, key: str) -> None:
        mine = IdentityRow.account_id == account_id, IdentityRow.id == key
        done = self.session.execute(sa.delete(IdentityRow).where(*mine))
        if not getattr(done, "rowcount", 0):
            raise NotFound(f"there is no login {key!a}")
