"""The tables of who may do what: labs, accounts, sessions, members, tokens, invitations, failed sign-ins.

Of passwords, session keys, tokens and invitations only hashes are kept. An account spans labs, so its rows and those of
its sessions are of no lab; what gives it a right in a lab is of that lab.
"""

from __future__ import annotations

from datetime import datetime
from typing import final

import sqlalchemy as sa
from sqlalchemy.orm import Mapped, mapped_column

from exogauge.storage.database import UtcDateTime
from exogauge.storage.table_kinds import NAME, SHA256, UUID, Base, Owned, new_id, one_of, utc_now, within_lab

LAB = sa.String(64)
EMAIL = sa.String(254)
ROLES = ("viewer", "member", "admin")  # each may do what those before it may
SCOPES = ("read", "write")


def of_account(column: str = "account_id") -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint([column], ["accounts.id"], ondelete="CASCADE")


def of_lab(column: str = "lab_id", ondelete: str = "CASCADE") -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint([column], ["labs.id"], ondelete=ondelete)


@final
class LabRow(Base):
    """A lab that accounts belong to. Without accounts there is none: the settings name the one lab. closed_at: since
    when nobody comes in; some time later all that it has goes."""

    __tablename__ = "labs"
    id: Mapped[str] = mapped_column(LAB, primary_key=True, default=new_id)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    name: Mapped[str] = mapped_column(NAME, unique=True)
    closed_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


@final
class Account(Base):
    """A person. email: in small letters. password_hash: None where somebody else vouches. operator: may found labs."""

    __tablename__ = "accounts"
    id: Mapped[str] = mapped_column(UUID, primary_key=True, default=new_id)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    email: Mapped[str] = mapped_column(EMAIL, unique=True)
    name: Mapped[str] = mapped_column(NAME)
    password_hash: Mapped[str | None] = mapped_column(sa.String(300))
    operator: Mapped[bool] = mapped_column(default=False)
    disabled_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


@final
class SessionRow(Base):
    """A browser that is signed in. key_hash: of what its cookie holds. at_lab: whose pages it shows."""

    __tablename__ = "sessions"
    __table_args__ = (of_account(), of_lab("at_lab", "SET NULL"), sa.Index(None, "expires_at"))
    id: Mapped[str] = mapped_column(UUID, primary_key=True, default=new_id)
    account_id: Mapped[str] = mapped_column(UUID, index=True)
    key_hash: Mapped[str] = mapped_column(SHA256, unique=True)
    at_lab: Mapped[str | None] = mapped_column(LAB)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)


@final
class IdentityRow(Base):
    """A login at an OpenID provider, by which an account is reached: whom (`subject`) the issuer means."""

    __tablename__ = "identities"
    __table_args__ = (of_account(), sa.UniqueConstraint("issuer", "subject"))
    id: Mapped[str] = mapped_column(UUID, primary_key=True, default=new_id)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    account_id: Mapped[str] = mapped_column(UUID, index=True)
    issuer: Mapped[str] = mapped_column(sa.String(300))
    subject: Mapped[str] = mapped_column(sa.String(255))


@final
class Membership(Owned, Base):
    """What an account may do in a lab."""

    __tablename__ = "memberships"
    __table_args__ = (
        sa.UniqueConstraint("lab_id", "account_id"),
        sa.CheckConstraint(one_of("role", ROLES), name="role"),
        of_account(),
        of_lab(),
    )
    account_id: Mapped[str] = mapped_column(UUID, index=True)
    role: Mapped[str] = mapped_column(sa.String(16))


@final
class ApiToken(Owned, Base):
    """A program that may read, or write too. account_id: whose it is, and no more may it than its account; None for a
    robot, which is the lab's. hint: its first letters, to know it by. made_by: an account."""

    __tablename__ = "api_tokens"
    __table_args__ = (
        sa.CheckConstraint(one_of("scope", SCOPES), name="scope"),
        of_account(),
        sa.ForeignKeyConstraint(["made_by"], ["accounts.id"], ondelete="SET NULL"),
        of_lab(),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    name: Mapped[str] = mapped_column(NAME)
    scope: Mapped[str] = mapped_column(sa.String(8))
    account_id: Mapped[str | None] = mapped_column(UUID, index=True)
    made_by: Mapped[str | None] = mapped_column(UUID)
    token_hash: Mapped[str] = mapped_column(SHA256, unique=True)
    hint: Mapped[str] = mapped_column(sa.String(16))
    expires_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    used_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


@final
class Invitation(Owned, Base):
    """A link that makes whoever has it, and this address, a member. Used once; ends by itself."""

    __tablename__ = "invitations"
    __table_args__ = (
        sa.CheckConstraint(one_of("role", ROLES), name="role"),
        sa.ForeignKeyConstraint(["made_by"], ["accounts.id"], ondelete="SET NULL"),
        of_lab(),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    email: Mapped[str] = mapped_column(EMAIL)
    role: Mapped[str] = mapped_column(sa.String(16))
    code_hash: Mapped[str] = mapped_column(SHA256, unique=True)
    made_by: Mapped[str | None] = mapped_column(UUID)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    accepted_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


@final
class Share(Owned, Base):
    """Another lab may read a study, with its jobs and results. to_lab: which; None: every lab of the installation."""

    __tablename__ = "shares"
    __table_args__ = (
        within_lab("study_id", "studies"),
        of_lab(),
        of_lab("to_lab"),
        sa.Index(None, "to_lab", "study_id"),
    )
    study_id: Mapped[str] = mapped_column(UUID, index=True)
    to_lab: Mapped[str | None] = mapped_column(LAB)


@final
class SignInTries(Base):
    """How often somebody tried a password. key_hash: of the address, the account's name, or both."""

    __tablename__ = "sign_in_tries"
    key_hash: Mapped[str] = mapped_column(SHA256, primary_key=True)
    tries: Mapped[int]
    since: Mapped[datetime] = mapped_column(UtcDateTime)
