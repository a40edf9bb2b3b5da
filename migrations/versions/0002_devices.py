"""Devices and their files; what was wrong with a failed job's input, place by place.

Revision: 0002, after: 0001.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "devices",
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("robot_id", sa.String(length=36), nullable=False),
        sa.Column("content_hash", sa.String(length=64), nullable=False),
        sa.Column("summary", sa.JSON(), nullable=False),
        sa.Column("id", sa.String(length=36), nullable=False),
        sa.Column("lab_id", sa.String(length=64), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(["robot_id"], ["robots.id"], name="fk_devices_robot_id_robots"),
        sa.PrimaryKeyConstraint("id", name="pk_devices"),
        sa.UniqueConstraint(
            "lab_id", "name", "robot_id", "content_hash", name="uq_devices_lab_id_name_robot_id_content_hash"
        ),
        sa.UniqueConstraint("lab_id", "name", "version", name="uq_devices_lab_id_name_version"),
    )
    op.create_index("ix_devices_lab_id_created_at_id", "devices", ["lab_id", "created_at", "id"])
    op.create_index("ix_devices_robot_id", "devices", ["robot_id"])

    op.create_table(
        "device_files",
        sa.Column("device_id", sa.String(length=36), nullable=False),
        sa.Column("path", sa.String(length=500), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.Column("size", sa.BigInteger(), nullable=False),
        sa.Column("id", sa.String(length=36), nullable=False),
        sa.Column("lab_id", sa.String(length=64), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["device_id"], ["devices.id"], name="fk_device_files_device_id_devices", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_device_files"),
        sa.UniqueConstraint("device_id", "path", name="uq_device_files_device_id_path"),
    )
    op.create_index("ix_device_files_device_id", "device_files", ["device_id"])
    op.create_index("ix_device_files_sha256", "device_files", ["sha256"])

    op.add_column("jobs", sa.Column("failure", sa.JSON(none_as_null=True), nullable=True))


def downgrade() -> None:
    op.drop_column("jobs", "failure")
    op.drop_table("device_files")
    op.drop_table("devices")
