"""Payloads, their files and live streams; a job and its result are of a study or of a payload.

Revision: 0005, after: 0004.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None
ONE_OWNER = "(study_id IS NULL) <> (payload_id IS NULL)"


def upgrade() -> None:
    op.create_table(
        "payloads",
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("content_hash", sa.String(length=64), nullable=False),
        sa.Column("summary", sa.JSON(), nullable=False),
        sa.Column("words", sa.Text(), server_default=sa.text("''"), nullable=False),
        sa.Column("id", sa.String(length=36), nullable=False),
        sa.Column("lab_id", sa.String(length=64), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_payloads"),
        sa.UniqueConstraint("lab_id", "name", "content_hash", name="uq_payloads_lab_id_name_content_hash"),
        sa.UniqueConstraint("lab_id", "name", "version", name="uq_payloads_lab_id_name_version"),
    )
    op.create_index("ix_payloads_lab_id_created_at_id", "payloads", ["lab_id", "created_at", "id"])

    op.create_table(
        "payload_files",
        sa.Column("payload_id", sa.String(length=36), nullable=False),
        sa.Column("path", sa.String(length=500), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.Column("size", sa.BigInteger(), nullable=False),
        sa.Column("id", sa.String(length=36), nullable=False),
        sa.Column("lab_id", sa.String(length=64), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["payload_id"], ["payloads.id"], name="fk_payload_files_payload_id_payloads", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_payload_files"),
        sa.UniqueConstraint("payload_id", "path", name="uq_payload_files_payload_id_path"),
    )
    op.create_index("ix_payload_files_payload_id", "payload_files", ["payload_id"])
    op.create_index("ix_payload_files_sha256", "payload_files", ["sha256"])

    for table in ("jobs", "results"):
        with op.batch_alter_table(table) as batch:
            batch.add_column(sa.Column("payload_id", sa.String(length=36), nullable=True))
            batch.alter_column("study_id", existing_type=sa.String(length=36), nullable=True)
            batch.create_foreign_key(
                f"fk_{table}_payload_id_payloads", "payloads", ["payload_id"], ["id"], ondelete="CASCADE"
            )
            batch.create_check_constraint(op.f(f"ck_{table}_one_owner"), ONE_OWNER)
        op.create_index(f"ix_{table}_payload_id", table, ["payload_id"])

    op.create_table(
        "live_streams",
        sa.Column("payload_id", sa.String(length=36), nullable=False),
        sa.Column("job_id", sa.String(length=36), nullable=True),
        sa.Column("state", sa.String(length=16), nullable=False),
        sa.Column("started_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ended_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("samples", sa.BigInteger(), nullable=False),
        sa.Column("dropped", sa.BigInteger(), nullable=False),
        sa.Column("late", sa.BigInteger(), nullable=False),
        sa.Column("last_sequence", sa.BigInteger(), nullable=True),
        sa.Column("summary", sa.JSON(), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=True),
        sa.Column("size", sa.BigInteger(), nullable=True),
        sa.Column("id", sa.String(length=36), nullable=False),
        sa.Column("lab_id", sa.String(length=64), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.CheckConstraint("state IN ('open', 'ended', 'lost')", name=op.f("ck_live_streams_state")),
        sa.CheckConstraint("samples >= 0 AND dropped >= 0 AND late >= 0", name=op.f("ck_live_streams_counts")),
        sa.ForeignKeyConstraint(
            ["payload_id"], ["payloads.id"], name="fk_live_streams_payload_id_payloads", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(["job_id"], ["jobs.id"], name="fk_live_streams_job_id_jobs", ondelete="SET NULL"),
        sa.PrimaryKeyConstraint("id", name="pk_live_streams"),
    )
    op.create_index("ix_live_streams_lab_id_created_at_id", "live_streams", ["lab_id", "created_at", "id"])
    op.create_index("ix_live_streams_job_id", "live_streams", ["job_id"])
    op.create_index("ix_live_streams_payload_id", "live_streams", ["payload_id"])
    op.create_index("ix_live_streams_sha256", "live_streams", ["sha256"])


def downgrade() -> None:
    """Jobs of payloads go with them."""
    op.drop_table("live_streams")
    for table in ("results", "artifacts", "jobs"):
        op.execute(gone(table))
    for table in ("jobs", "results"):
        op.drop_index(f"ix_{table}_payload_id", table)
        with op.batch_alter_table(table) as batch:
            batch.drop_constraint(op.f(f"ck_{table}_one_owner"), type_="check")
            batch.drop_constraint(f"fk_{table}_payload_id_payloads", type_="foreignkey")
            batch.drop_column("payload_id")
            batch.alter_column("study_id", existing_type=sa.String(length=36), nullable=False)
    op.drop_table("payload_files")
    op.drop_table("payloads")


def gone(table: str) -> str:
    if table == "artifacts":
        return "DELETE FROM artifacts WHERE job_id IN (SELECT id FROM jobs WHERE payload_id IS NOT NULL)"
    return f"DELETE FROM {table} WHERE payload_id IS NOT NULL"
