"""An idempotency key is held until a time, by one request; what was in flight can be asked for again.

Revision: 0008, after: 0007.
"""

from __future__ import annotations

from datetime import timedelta

import sqlalchemy as sa
from alembic import op

from exogauge.storage.database import UtcDateTime

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None
KEPT = timedelta(days=1)  # as revision 0007 kept an answer


def upgrade() -> None:
    op.execute("DELETE FROM idempotency_keys WHERE answer IS NULL")
    op.add_column("idempotency_keys", sa.Column("expires_at", sa.DateTime(timezone=True), nullable=True))
    keys = sa.table(
        "idempotency_keys", sa.column("id"), sa.column("created_at", UtcDateTime), sa.column("expires_at", UtcDateTime)
    )
    op.execute("UPDATE idempotency_keys SET owner = ''")  # a process, until now; of an answer nobody asks
    for row in op.get_bind().execute(sa.select(keys.c.id, keys.c.created_at)).all():
        op.execute(sa.update(keys).where(keys.c.id == row.id).values(expires_at=row.created_at + KEPT))
    with op.batch_alter_table("idempotency_keys") as batch:
        batch.alter_column("expires_at", existing_type=sa.DateTime(timezone=True), nullable=False)
        batch.alter_column("owner", existing_type=sa.String(length=300), type_=sa.String(length=36))
    op.create_index("ix_idempotency_keys_lab_id_expires_at", "idempotency_keys", ["lab_id", "expires_at"])


def downgrade() -> None:
    op.drop_index("ix_idempotency_keys_lab_id_expires_at", "idempotency_keys")
    with op.batch_alter_table("idempotency_keys") as batch:
        batch.alter_column("owner", existing_type=sa.String(length=36), type_=sa.String(length=300))
        batch.drop_column("expires_at")
