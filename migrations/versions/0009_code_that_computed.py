"""Which code a job was asked of, beside which computes it.

What stood there was the code that took the request; of jobs that a worker has begun it stays as the best that is known.

Revision: 0009, after: 0008.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None
VERSION = sa.String(length=64)


def upgrade() -> None:
    op.add_column("jobs", sa.Column("requested_code_version", VERSION, nullable=True))
    op.execute("UPDATE jobs SET requested_code_version = code_version")
    with op.batch_alter_table("jobs") as batch:
        batch.alter_column("requested_code_version", existing_type=VERSION, nullable=False)
        batch.alter_column("code_version", existing_type=VERSION, nullable=True)
    op.execute("UPDATE jobs SET code_version = NULL WHERE started_at IS NULL OR state = 'queued'")


def downgrade() -> None:
    op.execute("UPDATE jobs SET code_version = requested_code_version")
    with op.batch_alter_table("jobs") as batch:
        batch.alter_column("code_version", existing_type=VERSION, nullable=False)
        batch.drop_column("requested_code_version")
