"""The words that robots, devices and studies are found by.

Revision: 0004, after: 0003.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from exogauge.storage.bundles import words_of

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None
TABLES = ("robots", "devices", "studies")


def upgrade() -> None:
    for name in TABLES:
        op.add_column(name, sa.Column("words", sa.Text(), server_default=sa.text("''"), nullable=False))
        fill(name)


def fill(name: str) -> None:
    """The words of what is there already."""
    columns = (sa.column(key, sa.JSON if key == "summary" else sa.Text) for key in ("id", "name", "summary", "words"))
    table, connection = sa.table(name, *columns), op.get_bind()
    for row in connection.execute(sa.select(table.c.id, table.c.name, table.c.summary)).all():
        words = words_of(row.name, row.summary)
        connection.execute(sa.update(table).where(table.c.id == row.id).values(words=words))


def downgrade() -> None:
    for name in TABLES:
        op.drop_column(name, "words")
