"""When a lab was last served, found without reading all its jobs.

Revision: 0010, after: 0009.
"""

from __future__ import annotations

from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_index("ix_jobs_lab_id_started_at", "jobs", ["lab_id", "started_at"])


def downgrade() -> None:
    op.drop_index("ix_jobs_lab_id_started_at", "jobs")
