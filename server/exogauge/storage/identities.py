"""Logins at an OpenID provider, by which accounts are reached: an issuer, and whom it means.

Used in a session of all labs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, NotFound
from exogauge.storage.account_tables import IdentityRow
from exogauge.storage.records import IdentityRecord
from exogauge.storage.rows import as_record


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
