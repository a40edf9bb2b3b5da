"""The schema of a database: our tables, and the queue's beside them."""

from __future__ import annotations

from exogauge.jobs.engine import migrate_engine
from exogauge.settings import Settings
from exogauge.storage import migrate


def prepare(settings: Settings) -> None:
    """Make the schema of a new database, upgrade a local SQLite file; another database is migrated by its operator."""
    if settings.database_url.startswith("sqlite"):
        settings.data_dir.mkdir(parents=True, exist_ok=True)
        upgrade(settings)
    else:
        migrate.prepare(settings.database_url)
        migrate_engine(settings.database_url)


def upgrade(settings: Settings) -> str:
    """Bring our tables and the queue's to this version; returns the revision."""
    revision = migrate.upgrade(settings.database_url)
    migrate_engine(settings.database_url)
    return revision
