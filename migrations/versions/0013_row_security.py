"""PostgreSQL guards the rows of labs by itself, and from a role that is not their owner.

Revision: 0013, after: 0012.
"""

from __future__ import annotations

from alembic import op

from exogauge.storage.row_security import ROLE, guard, make_role, unguard

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None

TABLES = (
    "robots", "robot_files", "devices", "device_files", "logs", "studies", "study_files", "payloads", "payload_files",
    "live_streams", "jobs", "results", "artifacts", "uploads", "robot_mappings", "idempotency_keys", "audit",
    "memberships", "api_tokens", "invitations",
)  # fmt: skip


def upgrade() -> None:
    connection = op.get_bind()
    if connection.dialect.name == "postgresql":
        make_role(connection)
    guard(connection, TABLES)


def downgrade() -> None:
    connection = op.get_bind()
    unguard(connection, TABLES)
    if connection.dialect.name == "postgresql":
        op.execute(f"DROP OWNED BY {ROLE}")  # what it may in this database; others may have it too
