"""Labs, accounts, sessions, members, tokens, invitations; the audit is only ever added to.

Revision: 0012, after: 0011.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from exogauge.storage.database import UtcDateTime

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None

UUID, SHA256, LAB, NAME, EMAIL = sa.String(36), sa.String(64), sa.String(64), sa.String(200), sa.String(254)
ROLE = "role IN ('viewer', 'member', 'admin')"


def upgrade() -> None:
    op.create_table(
        "labs",
        sa.Column("id", LAB, nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_labs"),
        sa.UniqueConstraint("name", name="uq_labs_name"),
    )
    op.create_table(
        "accounts",
        sa.Column("id", UUID, nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False),
        sa.Column("email", EMAIL, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("password_hash", sa.String(300)),
        sa.Column("operator", sa.Boolean(), nullable=False),
        sa.Column("disabled_at", UtcDateTime()),
        sa.PrimaryKeyConstraint("id", name="pk_accounts"),
        sa.UniqueConstraint("email", name="uq_accounts_email"),
    )
    op.create_table(
        "sessions",
        sa.Column("id", UUID, nullable=False),
        sa.Column("account_id", UUID, nullable=False),
        sa.Column("key_hash", SHA256, nullable=False),
        sa.Column("at_lab", LAB),
        sa.Column("created_at", UtcDateTime(), nullable=False),
        sa.Column("seen_at", UtcDateTime(), nullable=False),
        sa.Column("expires_at", UtcDateTime(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_sessions"),
        sa.UniqueConstraint("key_hash", name="uq_sessions_key_hash"),
        account_key("sessions"),
        sa.ForeignKeyConstraint(["at_lab"], ["labs.id"], name="fk_sessions_at_lab_labs", ondelete="SET NULL"),
    )
    op.create_index("ix_sessions_account_id", "sessions", ["account_id"])
    op.create_index("ix_sessions_expires_at", "sessions", ["expires_at"])
    op.create_table(
        "memberships",
        *owned(),
        sa.Column("account_id", UUID, nullable=False),
        sa.Column("role", sa.String(16), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_memberships"),
        sa.UniqueConstraint("lab_id", "account_id", name="uq_memberships_lab_id_account_id"),
        sa.CheckConstraint(ROLE, name="role"),
        account_key("memberships"),
        lab_key("memberships"),
    )
    op.create_index("ix_memberships_account_id", "memberships", ["account_id"])
    op.create_table(
        "api_tokens",
        *owned(),
        sa.Column("name", NAME, nullable=False),
        sa.Column("scope", sa.String(8), nullable=False),
        sa.Column("account_id", UUID),
        sa.Column("made_by", UUID),
        sa.Column("token_hash", SHA256, nullable=False),
        sa.Column("hint", sa.String(16), nullable=False),
        sa.Column("expires_at", UtcDateTime()),
        sa.Column("revoked_at", UtcDateTime()),
        sa.Column("used_at", UtcDateTime()),
        sa.PrimaryKeyConstraint("id", name="pk_api_tokens"),
        sa.UniqueConstraint("token_hash", name="uq_api_tokens_token_hash"),
        sa.CheckConstraint("scope IN ('read', 'write')", name="scope"),
        account_key("api_tokens"),
        maker_key("api_tokens"),
        lab_key("api_tokens"),
    )
    op.create_index("ix_api_tokens_account_id", "api_tokens", ["account_id"])
    op.create_index("ix_api_tokens_lab_id_created_at_id", "api_tokens", ["lab_id", "created_at", "id"])
    op.create_table(
        "invitations",
        *owned(),
        sa.Column("email", EMAIL, nullable=False),
        sa.Column("role", sa.String(16), nullable=False),
        sa.Column("code_hash", SHA256, nullable=False),
        sa.Column("made_by", UUID),
        sa.Column("expires_at", UtcDateTime(), nullable=False),
        sa.Column("accepted_at", UtcDateTime()),
        sa.Column("revoked_at", UtcDateTime()),
        sa.PrimaryKeyConstraint("id", name="pk_invitations"),
        sa.UniqueConstraint("code_hash", name="uq_invitations_code_hash"),
        sa.CheckConstraint(ROLE, name="role"),
        maker_key("invitations"),
        lab_key("invitations"),
    )
    op.create_index("ix_invitations_lab_id_created_at_id", "invitations", ["lab_id", "created_at", "id"])
    op.create_table(
        "sign_in_tries",
        sa.Column("key_hash", SHA256, nullable=False),
        sa.Column("tries", sa.Integer(), nullable=False),
        sa.Column("since", UtcDateTime(), nullable=False),
        sa.PrimaryKeyConstraint("key_hash", name="pk_sign_in_tries"),
    )
    op.add_column("audit", sa.Column("said", sa.Text(), nullable=False, server_default=sa.text("''")))
    for statement in ONLY_ADDED[op.get_bind().dialect.name]:
        op.execute(statement)


ONLY_ADDED = {
    "sqlite": [
        f"CREATE TRIGGER audit_refuses_{what} BEFORE {what} ON audit "
        "BEGIN SELECT RAISE(ABORT, 'the audit is only ever added to'); END"
        for what in ("update", "delete")
    ],
    "postgresql": [
        "CREATE FUNCTION audit_refuses() RETURNS trigger LANGUAGE plpgsql AS "
        "$$ BEGIN RAISE EXCEPTION 'the audit is only ever added to'; END $$",
        "CREATE TRIGGER audit_refuses_change BEFORE UPDATE OR DELETE OR TRUNCATE ON audit "
        "FOR EACH STATEMENT EXECUTE FUNCTION audit_refuses()",
    ],
}
ADDED_AND_CHANGED = {
    "sqlite": ["DROP TRIGGER audit_refuses_update", "DROP TRIGGER audit_refuses_delete"],
    "postgresql": ["DROP TRIGGER audit_refuses_change ON audit", "DROP FUNCTION audit_refuses()"],
}


def owned() -> list[sa.Column[object]]:
    return [
        sa.Column("id", UUID, nullable=False),
        sa.Column("lab_id", LAB, nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False),
    ]


def account_key(table: str) -> sa.ForeignKeyConstraint:
    name = f"fk_{table}_account_id_accounts"
    return sa.ForeignKeyConstraint(["account_id"], ["accounts.id"], name=name, ondelete="CASCADE")


def maker_key(table: str) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint(
        ["made_by"], ["accounts.id"], name=f"fk_{table}_made_by_accounts", ondelete="SET NULL"
    )


def lab_key(table: str) -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint(["lab_id"], ["labs.id"], name=f"fk_{table}_lab_id_labs", ondelete="CASCADE")


def downgrade() -> None:
    for statement in ADDED_AND_CHANGED[op.get_bind().dialect.name]:
        op.execute(statement)
    op.drop_column("audit", "said")
    for table in ("sign_in_tries", "invitations", "api_tokens", "memberships", "sessions", "accounts", "labs"):
        op.drop_table(table)
