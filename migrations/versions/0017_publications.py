"""Snapshots that are published: they are never changed, only revoked, once.

Revision: 0017, after: 0016.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from exogauge.storage.database import UtcDateTime
from exogauge.storage.row_security import guard, unguard

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None

UUID, SHA256 = sa.String(36), sa.String(64)
TABLES = ("publications", "publication_files")
FROZEN = "id, lab_id, created_at, key, series_id, version, study_id, job_id, content_hash, manifest, about, lab_name"
WHAT = "a publication is not changed; it can be revoked"


def upgrade() -> None:
    op.create_table(
        "publications",
        *owned(),
        sa.Column("key", sa.String(16), nullable=False),
        sa.Column("series_id", UUID, nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("study_id", UUID, nullable=False),
        sa.Column("job_id", UUID, nullable=False),
        sa.Column("content_hash", SHA256, nullable=False),
        sa.Column("manifest", sa.JSON(), nullable=False),
        sa.Column("about", sa.JSON(), nullable=False),
        sa.Column("lab_name", sa.String(200), nullable=False),
        sa.Column("revoked_at", UtcDateTime()),
        sa.Column("revoked_because", sa.Text()),
        sa.PrimaryKeyConstraint("id", name="pk_publications"),
        sa.UniqueConstraint("lab_id", "id", name="uq_publications_lab_id_id"),
        sa.UniqueConstraint("key", name="uq_publications_key"),
        sa.UniqueConstraint("series_id", "version", name="uq_publications_series_id_version"),
    )
    op.create_index("ix_publications_lab_id_created_at_id", "publications", ["lab_id", "created_at", "id"])
    op.create_index("ix_publications_study_id", "publications", ["study_id"])
    op.create_table(
        "publication_files",
        *owned(),
        sa.Column("publication_id", UUID, nullable=False),
        sa.Column("path", sa.String(500), nullable=False),
        sa.Column("sha256", SHA256, nullable=False),
        sa.Column("size", sa.BigInteger(), nullable=False),
        sa.Column("media_type", sa.String(100), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_publication_files"),
        sa.UniqueConstraint("publication_id", "path", name="uq_publication_files_publication_id_path"),
        sa.ForeignKeyConstraint(
            ["lab_id", "publication_id"], ["publications.lab_id", "publications.id"],
            name="fk_publication_files_lab_id_publication_id_publications", ondelete="CASCADE",
        ),
    )  # fmt: skip
    op.create_index("ix_publication_files_publication_id", "publication_files", ["publication_id"])
    op.create_index("ix_publication_files_sha256", "publication_files", ["sha256"])
    guard(op.get_bind(), TABLES)
    for statement in KEPT[op.get_bind().dialect.name]:
        op.execute(statement)


def owned() -> list[sa.Column[object]]:
    return [
        sa.Column("id", UUID, nullable=False),
        sa.Column("lab_id", sa.String(64), nullable=False),
        sa.Column("created_at", UtcDateTime(), nullable=False),
    ]


REFUSED = {  # name of the trigger -> on what
    "publications_stay": "DELETE ON publications",
    "publications_frozen": f"UPDATE OF {FROZEN} ON publications",
    "publication_files_frozen": "UPDATE ON publication_files",
}
ONCE = "UPDATE OF revoked_at, revoked_because ON publications"
KEPT = {
    "sqlite": [
        *(
            f"CREATE TRIGGER {name} BEFORE {what} BEGIN SELECT RAISE(ABORT, '{WHAT}'); END"
            for name, what in REFUSED.items()
        ),
        f"CREATE TRIGGER publications_revoked BEFORE {ONCE} WHEN OLD.revoked_at IS NOT NULL "
        f"BEGIN SELECT RAISE(ABORT, '{WHAT}'); END",
    ],
    "postgresql": [
        f"CREATE FUNCTION publication_refuses() RETURNS trigger LANGUAGE plpgsql AS "
        f"$$ BEGIN RAISE EXCEPTION '{WHAT}'; END $$",
        *(
            f"CREATE TRIGGER {name} BEFORE {what} FOR EACH ROW EXECUTE FUNCTION publication_refuses()"
            for name, what in REFUSED.items()
        ),
        f"CREATE TRIGGER publications_revoked BEFORE {ONCE} FOR EACH ROW WHEN (OLD.revoked_at IS NOT NULL) "
        "EXECUTE FUNCTION publication_refuses()",
    ],
}


def downgrade() -> None:
    unguard(op.get_bind(), TABLES)
    op.drop_table("publication_files")
    op.drop_table("publications")
    if op.get_bind().dialect.name == "postgresql":
        op.execute("DROP FUNCTION publication_refuses()")
