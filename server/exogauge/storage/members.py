"""Who is of a lab, who is invited, which programs may come in, and what all of them did.

A lab keeps an admin: the last one cannot leave or become less, also where two leave at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import final

import sqlalchemy as sa

from exogauge.errors import Conflict, NotFound
from exogauge.storage import tables
from exogauge.storage.account_tables import Account, ApiToken, Invitation, LabRow, Membership
from exogauge.storage.records import AuditRecord, InvitationRecord, MemberRecord, Page, TokenRecord
from exogauge.storage.rows import Lab, as_record
from exogauge.storage.secrets import hashed, new_key, new_token
from exogauge.storage.tables import utc_now

INVITED_FOR = timedelta(days=7)


@final
@dataclass(frozen=True)
class Members:
    lab: Lab

    def all(self) -> list[MemberRecord]:
        """By name."""
        return self._found(Membership.lab_id == self.lab.lab_id)

    def get(self, account_id: str) -> MemberRecord:
        found = self._found(Membership.lab_id == self.lab.lab_id, Account.id == account_id)
        if not found:
            raise NotFound(f"there is no member {account_id[:64]!a}")
        return found[0]

    def set_role(self, account_id: str, role: str) -> MemberRecord:
        self._alone()
        before = self.get(account_id)
        if before.role == "admin" and role != "admin":
            self._refuse_without_admin(account_id)
        mine = Membership.lab_id == self.lab.lab_id, Membership.account_id == account_id
        self.lab.session.execute(sa.update(Membership).where(*mine).values(role=role))
        if before.role != role:
            said = f"{before.email}: {before.role} → {role}"
            self.lab.audit("set role", "member", account_id, hashed(before.role), hashed(role), said)
        return self.get(account_id)

    def remove(self, account_id: str) -> None:
        """Its tokens go too: they may no more than it."""
        self._alone()
        before = self.get(account_id)
        if before.role == "admin":
            self._refuse_without_admin(account_id)
        mine = ApiToken.lab_id == self.lab.lab_id, ApiToken.account_id == account_id, ApiToken.revoked_at.is_(None)
        self.lab.session.execute(sa.update(ApiToken).where(*mine).values(revoked_at=utc_now()))
        gone = Membership.lab_id == self.lab.lab_id, Membership.account_id == account_id
        self.lab.session.execute(sa.delete(Membership).where(*gone))
        self.lab.audit("remove", "member", account_id, hashed(before.role), said=f"{before.email}, {before.role}")

    def _found(self, *which: sa.ColumnElement[bool]) -> list[MemberRecord]:
        columns = (Account.id, Account.email, Account.name, Membership.role, Membership.created_at, Account.disabled_at)
        query = sa.select(*columns).join(Membership, Membership.account_id == Account.id).where(*which)
        return [MemberRecord(*row) for row in self.lab.session.execute(query.order_by(Account.name, Account.email))]

    def _alone(self) -> None:
        """One change of members at a time."""
        self.lab.session.execute(sa.select(LabRow.id).where(LabRow.id == self.lab.lab_id).with_for_update())

    def _refuse_without_admin(self, account_id: str) -> None:
        others = sa.select(Membership.id).join(Account, Account.id == Membership.account_id)
        others = others.where(Membership.lab_id == self.lab.lab_id, Membership.role == "admin")
        others = others.where(Membership.account_id != account_id, Account.disabled_at.is_(None))
        if self.lab.session.scalar(others.limit(1)) is None:
            raise Conflict("a lab keeps an admin, and this is the last one; make another member admin first")


@final
@dataclass(frozen=True)
class Invitations:
    lab: Lab

    def page(self, after: tuple[datetime, str] | None, limit: int) -> Page[InvitationRecord]:
        return self.lab.page(InvitationRecord, Invitation, after, limit)

    def add(self, email: str, role: str, made_by: str | None) -> tuple[InvitationRecord, str]:
        """And its code, which is kept nowhere. An open one for the same address ends."""
        open_ = self._open(), Invitation.email == email
        self.lab.session.execute(sa.update(Invitation).where(*open_).values(revoked_at=utc_now()))
        code = new_key()
        row = Invitation(
            lab_id=self.lab.lab_id, email=email, role=role, code_hash=hashed(code), made_by=made_by,
            expires_at=utc_now() + INVITED_FOR,
        )  # fmt: skip
        self.lab.session.add(row)
        self.lab.session.flush()
        self.lab.audit("invite", "invitation", row.id, after=hashed(role), said=f"{email} as {role}")
        return as_record(InvitationRecord, row), code

    def revoke(self, key: str) -> None:
        found = self.lab.get(InvitationRecord, Invitation, key, "invitation")
        done = self.lab.session.execute(
            sa.update(Invitation).where(self._open(), Invitation.id == key).values(revoked_at=utc_now())
        )
        if getattr(done, "rowcount", 0):
            self.lab.audit("revoke", "invitation", key, said=found.email)

    def _open(self) -> sa.ColumnElement[bool]:
        free = Invitation.accepted_at.is_(None) & Invitation.revoked_at.is_(None)
        return sa.and_(Invitation.lab_id == self.lab.lab_id, free)


@final
@dataclass(frozen=True)
class Tokens:
    lab: Lab

    def page(
        self, after: tuple[datetime, str] | None, limit: int, *, of: str | None = None, robots: bool = True
    ) -> Page[TokenRecord]:
        """Those of the account `of`; without it, those of all. robots: the lab's own, too."""
        if of is None:
            return self.lab.page(TokenRecord, ApiToken, after, limit)
        whose = ApiToken.account_id == of
        wanted = sa.or_(whose, ApiToken.account_id.is_(None)) if robots else whose
        return self.lab.page(TokenRecord, ApiToken, after, limit, wanted)

    def get(self, key: str) -> TokenRecord:
        return self.lab.get(TokenRecord, ApiToken, key, "token")

    def add(
        self, name: str, scope: str, *, made_by: str | None, account_id: str | None, expires_at: datetime | None
    ) -> tuple[TokenRecord, str]:
        """And the token, which is kept nowhere."""
        token = new_token()
        row = ApiToken(
            lab_id=self.lab.lab_id, name=name, scope=scope, made_by=made_by, account_id=account_id,
            token_hash=hashed(token), hint=token[:8], expires_at=expires_at,
        )  # fmt: skip
        self.lab.session.add(row)
        self.lab.session.flush()
        whose = "of a robot" if account_id is None else "of its maker"
        self.lab.audit("make", "token", row.id, after=hashed(scope), said=f"{name}, {scope}, {whose}")
        return as_record(TokenRecord, row), token

    def revoke(self, key: str) -> TokenRecord:
        found = self.get(key)
        if found.revoked_at is None:
            mine = ApiToken.lab_id == self.lab.lab_id, ApiToken.id == key
            self.lab.session.execute(sa.update(ApiToken).where(*mine).values(revoked_at=utc_now()))
            self.lab.audit("revoke", "token", key, said=found.name)
        return self.get(key)


@final
@dataclass(frozen=True)
class Audit:
    lab: Lab

    def page(self, after: tuple[datetime, str] | None, limit: int, search: str = "") -> Page[AuditRecord]:
        """search: an action, a sort of thing, an id, or a word of what was said."""
        wanted, table = list[sa.ColumnElement[bool]](), tables.AuditEntry
        for word in search.split():
            inside = (
                column.icontains(word, autoescape=True) for column in (table.action, table.subject_kind, table.said)
            )
            wanted.append(sa.or_(*inside, table.subject_id == word, table.actor.endswith(word, autoescape=True)))
        return self.lab.page(AuditRecord, table, after, limit, *wanted)
