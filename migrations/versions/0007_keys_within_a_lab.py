"""A row refers to rows of its own lab alone: every foreign key holds the lab.

Results and artifacts that a worker wrote under another lab than their job's, as it could, go back to the job's. A
stream no longer forgets the job whose results compensated it: that job stays as long as the stream does.

Revision: 0007, after: 0006.
"""

from __future__ import annotations

from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

REFERRED = ("robots", "devices", "studies", "payloads", "jobs")
KEYS = (  # table, column, table it names, what happens when that row goes: before, and from now on
    ("robot_files", "robot_id", "robots", "CASCADE", "CASCADE"),
    ("robot_mappings", "robot_id", "robots", "CASCADE", "CASCADE"),
    ("devices", "robot_id", "robots", None, None),
    ("device_files", "device_id", "devices", "CASCADE", "CASCADE"),
    ("study_files", "study_id", "studies", "CASCADE", "CASCADE"),
    ("payload_files", "payload_id", "payloads", "CASCADE", "CASCADE"),
    ("jobs", "study_id", "studies", "CASCADE", "CASCADE"),
    ("jobs", "payload_id", "payloads", "CASCADE", "CASCADE"),
    ("results", "job_id", "jobs", "CASCADE", "CASCADE"),
    ("results", "study_id", "studies", "CASCADE", "CASCADE"),
    ("results", "payload_id", "payloads", "CASCADE", "CASCADE"),
    ("artifacts", "job_id", "jobs", "CASCADE", "CASCADE"),
    ("live_streams", "payload_id", "payloads", "CASCADE", "CASCADE"),
    ("live_streams", "job_id", "jobs", "SET NULL", None),
)
MADE_BY_WORKERS = ("results", "artifacts")
CHANGED = tuple(dict.fromkeys((*REFERRED, *(table for table, *_ in KEYS))))


def upgrade() -> None:
    for table in MADE_BY_WORKERS:
        op.execute(
            f"UPDATE {table} SET lab_id = (SELECT jobs.lab_id FROM jobs WHERE jobs.id = {table}.job_id) "
            f"WHERE lab_id <> (SELECT jobs.lab_id FROM jobs WHERE jobs.id = {table}.job_id)"
        )
    for table in CHANGED:  # what rows refer to comes before them
        with op.batch_alter_table(table) as batch:
            if table in REFERRED:
                batch.create_unique_constraint(f"uq_{table}_lab_id_id", ["lab_id", "id"])
            for _, column, named, _, rule in keys_of(table):
                batch.drop_constraint(f"fk_{table}_{column}_{named}", type_="foreignkey")
                batch.create_foreign_key(
                    f"fk_{table}_lab_id_{column}_{named}", named, ["lab_id", column], ["lab_id", "id"], ondelete=rule
                )


def downgrade() -> None:
    for table in reversed(CHANGED):
        with op.batch_alter_table(table) as batch:
            for _, column, named, rule, _ in keys_of(table):
                batch.drop_constraint(f"fk_{table}_lab_id_{column}_{named}", type_="foreignkey")
                batch.create_foreign_key(f"fk_{table}_{column}_{named}", named, [column], ["id"], ondelete=rule)
            if table in REFERRED:
                batch.drop_constraint(f"uq_{table}_lab_id_id", type_="unique")


def keys_of(table: str) -> list[tuple[str, str, str, str | None, str | None]]:
    return [key for key in KEYS if key[0] == table]
