"""What was captured of people, contacts and maps said by hand, plans; a job and its result may be of these too.

Revision: 0019, after: 0018.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from exogauge.storage.database import UtcDateTime
from exogauge.storage.row_security import guard, unguard

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None

TABLES = ("motions", "motion_files", "motion_contacts", "motion_maps", "plans", "plan_files")
NEW = ("motion", "plan")  # what jobs can be of from now on
BEFORE = "(study_id IS NULL) <> (payload_id IS NULL)"
NOW = (
    "(CASE WHEN study_id IS NULL THEN 0 ELSE 1 END) + (CASE WHEN payload_id IS NULL THEN 0 ELSE 1 END) + "
    "(CASE WHEN motion_id IS NULL THEN 0 ELSE 1 END) + (CASE WHEN plan_id IS NULL THEN 0 ELSE 1 END) = 1"
)


def upgrade() -> None:
    named = lambda: [  # noqa: E731  # columns are of one table each
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("content_hash", sa.String(64), nullable=False),
        sa.Column("summary", sa.JSON(), nullable=False),
        sa.Column("words", sa.Text(), server_default=sa.text("''"), nullable=False),
    ]
    remembered = lambda: [  # noqa: E731
        sa.Column("content", sa.JSON(), nullable=False),
        sa.Column("content_hash", sa.String(64), nullable=False),
        sa.Column("changed_at", UtcDateTime(), nullable=False),
    ]
    make("motions", *named(), sa.Column("version", sa.Integer(), nullable=False), unique(
        "motions", "lab_id", "id"), unique("motions", "lab_id", "name", "version"),
        unique("motions", "lab_id", "name", "content_hash"))  # fmt: skip
    make_files("motion", "motions")
    make("motion_contacts", *remembered(), key("motion_id"), unique("motion_contacts", "motion_id"),
         reference("motion_contacts", "motion_id", "motions"))  # fmt: skip
    make("motion_maps", *remembered(), sa.Column("name", sa.String(200), nullable=False),
         unique("motion_maps", "lab_id", "name"))  # fmt: skip
    make("plans", *named(), key("robot_id"), key("motion_id", nullable=True), key("study_id", nullable=True),
         unique("plans", "lab_id", "id"), unique("plans", "lab_id", "content_hash"),
         reference("plans", "robot_id", "robots", None), reference("plans", "motion_id", "motions", None),
         reference("plans", "study_id", "studies", None))  # fmt: skip
    make_files("plan", "plans")
    for table in ("motions", "motion_maps", "plans"):
        op.create_index(f"ix_{table}_lab_id_created_at_id", table, ["lab_id", "created_at", "id"])
    for column in ("robot_id", "motion_id", "study_id"):
        op.create_index(f"ix_plans_{column}", "plans", [column])
    guard(op.get_bind(), TABLES)
    for table in ("jobs", "results"):
        with op.batch_alter_table(table) as batch:
            batch.drop_constraint(op.f(f"ck_{table}_one_owner"), type_="check")
            for noun in NEW:
                batch.add_column(sa.Column(f"{noun}_id", sa.String(36), nullable=True))
                batch.create_foreign_key(
                    f"fk_{table}_lab_id_{noun}_id_{noun}s", f"{noun}s", ["lab_id", f"{noun}_id"], ["lab_id", "id"],
                    ondelete="CASCADE",
                )  # fmt: skip
            batch.create_check_constraint(op.f(f"ck_{table}_one_owner"), NOW)
        for noun in NEW:
            op.create_index(f"ix_{table}_{noun}_id", table, [f"{noun}_id"])


def downgrade() -> None:
    """Jobs of motions and plans go with them."""
    ours = "motion_id IS NOT NULL OR plan_id IS NOT NULL"
    op.execute(f"DELETE FROM results WHERE {ours}")
    op.execute(f"DELETE FROM artifacts WHERE job_id IN (SELECT id FROM jobs WHERE {ours})")
    op.execute(f"DELETE FROM jobs WHERE {ours}")
    for table in ("jobs", "results"):
        for noun in NEW:
            op.drop_index(f"ix_{table}_{noun}_id", table)
        with op.batch_alter_table(table) as batch:
            batch.drop_constraint(op.f(f"ck_{table}_one_owner"), type_="check")
            for noun in NEW:
                batch.drop_constraint(f"fk_{table}_lab_id_{noun}_id_{noun}s", type_="foreignkey")
                batch.drop_column(f"{noun}_id")
            batch.create_check_constraint(op.f(f"ck_{table}_one_owner"), BEFORE)
    unguard(op.get_bind(), TABLES)
    for table in reversed(TABLES):
        op.drop_table(table)


def make(table: str, *parts: sa.schema.SchemaItem) -> None:
    op.create_table(
        table, sa.Column("id", sa.String(36), nullable=False), sa.Column("lab_id", sa.String(64), nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False), *parts,
        sa.PrimaryKeyConstraint("id", name=f"pk_{table}"),
    )  # fmt: skip


def make_files(noun: str, owners: str) -> None:
    table, column = f"{noun}_files", f"{noun}_id"
    make(table, key(column), sa.Column("path", sa.String(500), nullable=False),
         sa.Column("sha256", sa.String(64), nullable=False), sa.Column("size", sa.BigInteger(), nullable=False),
         unique(table, column, "path"), reference(table, column, owners))  # fmt: skip
    for indexed in (column, "sha256"):
        op.create_index(f"ix_{table}_{indexed}", table, [indexed])


def key(name: str, *, nullable: bool = False) -> sa.Column[str]:
    return sa.Column(name, sa.String(36), nullable=nullable)


def unique(table: str, *columns: str) -> sa.UniqueConstraint:
    return sa.UniqueConstraint(*columns, name=f"uq_{table}_{'_'.join(columns)}")


def reference(table: str, column: str, named: str, ondelete: str | None = "CASCADE") -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint(["lab_id", column], [f"{named}.lab_id", f"{named}.id"],
                                   name=f"fk_{table}_lab_id_{column}_{named}", ondelete=ondelete)  # fmt: skip
