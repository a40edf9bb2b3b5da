"""Webhooks and their outbox; labs that are closed.

Revision: 0020, after: 0019.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from exogauge.storage.database import UtcDateTime
from exogauge.storage.row_security import guard, unguard

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None

UUID = sa.String(36)
TABLES = ("webhooks", "deliveries")


def upgrade() -> None:
    op.create_table(
        "webhooks",
        *owned(),
        sa.Column("url", sa.String(2000), nullable=False),
        sa.Column("events", sa.JSON(), nullable=False),
        sa.Column("secret", sa.String(100), nullable=False),
        sa.Column("disabled_at", UtcDateTime()),
        sa.Column("disabled_because", sa.String(500)),
        sa.PrimaryKeyConstraint("id", name="pk_webhooks"),
        sa.UniqueConstraint("lab_id", "id", name="uq_webhooks_lab_id_id"),
        sa.Index("ix_webhooks_lab_id_created_at_id", "lab_id", "created_at", "id"),
    )
    op.create_table(
        "deliveries",
        *owned(),
        sa.Column("webhook_id", UUID, nullable=False),
        sa.Column("event", sa.String(64), nullable=False),
        sa.Column("data", sa.JSON(), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("attempts", sa.Integer(), nullable=False),
        sa.Column("due_at", UtcDateTime(), nullable=False),
        sa.Column("ended_at", UtcDateTime()),
        sa.Column("status", sa.Integer()),
        sa.Column("said", sa.String(500), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_deliveries"),
        sa.CheckConstraint("state IN ('waiting', 'delivered', 'failed')", name="state"),
        sa.ForeignKeyConstraint(
            ["lab_id", "webhook_id"], ["webhooks.lab_id", "webhooks.id"],
            name="fk_deliveries_lab_id_webhook_id_webhooks", ondelete="CASCADE",
        ),
    )  # fmt: skip
    op.create_index("ix_deliveries_webhook_id", "deliveries", ["webhook_id"])
    op.create_index("ix_deliveries_state_due_at", "deliveries", ["state", "due_at"])
    op.create_index("ix_deliveries_lab_id_created_at_id", "deliveries", ["lab_id", "created_at", "id"])
    guard(op.get_bind(), TABLES)
    op.add_column("labs", sa.Column("closed_at", UtcDateTime()))


def owned() -> list[sa.Column[object]]:
    return [
        sa.Column("id", UUID, nullable=False),
        sa.Column("lab_id", sa.String(64), nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False),
    ]


def downgrade() -> None:
    op.drop_column("labs", "closed_at")
    unguard(op.get_bind(), TABLES)
    op.drop_table("deliveries")
    op.drop_table("webhooks")
