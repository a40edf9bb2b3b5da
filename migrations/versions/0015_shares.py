"""Studies that other labs may read.

Revision: 0015, after: 0014.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from exogauge.storage.database import UtcDateTime
from exogauge.storage.row_security import guard, unguard

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "shares",
        sa.Column("id", sa.String(36), nullable=False),
        sa.Column("lab_id", sa.String(64), nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False),
        sa.Column("study_id", sa.String(36), nullable=False),
        sa.Column("to_lab", sa.String(64)),
        sa.PrimaryKeyConstraint("id", name="pk_shares"),
        sa.ForeignKeyConstraint(
            ["lab_id", "study_id"], ["studies.lab_id", "studies.id"], name="fk_shares_lab_id_study_id_studies",
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(["lab_id"], ["labs.id"], name="fk_shares_lab_id_labs", ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["to_lab"], ["labs.id"], name="fk_shares_to_lab_labs", ondelete="CASCADE"),
    )  # fmt: skip
    op.create_index("ix_shares_study_id", "shares", ["study_id"])
    op.create_index("ix_shares_to_lab_study_id", "shares", ["to_lab", "study_id"])
    guard(op.get_bind(), ["shares"])


def downgrade() -> None:
    unguard(op.get_bind(), ["shares"])
    op.drop_table("shares")
