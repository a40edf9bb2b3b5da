"""Runs the migrations; called by `exogauge.storage.migrate` with a connection, or by the `alembic` command without."""

from __future__ import annotations

from alembic import context
from sqlalchemy.engine import Connection

from exogauge.settings import Settings
from exogauge.storage.migrate import connected
from exogauge.storage.tables import Base


def include_name(name: str | None, kind: str, _parents: object) -> bool:
    """Only our own tables: the job engine keeps its own beside them (SQLite) or in the schema `dbos` (PostgreSQL)."""
    return kind != "table" or name in Base.metadata.tables


def migrate(connection: Connection) -> None:
    context.configure(
        connection=connection,
        target_metadata=Base.metadata,
        include_name=include_name,
        render_as_batch=True,
        transaction_per_migration=True,
        compare_type=True,
        compare_server_default=True,
    )
    with context.begin_transaction():
        context.run_migrations()


given = context.config.attributes.get("connection")
if given is not None:
    migrate(given)
else:
    with connected(Settings().database_url) as opened:
        migrate(opened)
