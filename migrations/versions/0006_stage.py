"""The stage that an evaluation is at, which its message said before.

Revision: 0006, after: 0005.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("jobs", sa.Column("stage", sa.String(length=16), nullable=True))


def downgrade() -> None:
    op.drop_column("jobs", "stage")
