"""The third lock between labs: PostgreSQL itself shows a transaction the rows of the lab that it has named, and takes
no others. The first is that every query names its lab, the second `scope`; this one holds where both are forgotten, in
SQL written by hand too.

The service works as a role that owns no table and may bypass nothing, whatever login it has (`SET ROLE` at connecting),
and rows are guarded from the owner too. A transaction that names no lab sees nothing; one for the queue names `*`.
SQLite has nothing like it.
"""

from __future__ import annotations

from collections.abc import Iterable

import sqlalchemy as sa
from sqlalchemy.engine import Connection

ROLE = "exogauge_app"
ALL = "*"
SETTING = "app.lab"
NAMED = f"current_setting('{SETTING}', true)"
MINE = f"(lab_id = {NAMED} OR {NAMED} = '{ALL}')"
NO_RIGHT = f"""
DO $$ BEGIN
  IF NOT EXISTS (SELECT FROM pg_roles WHERE rolname = '{ROLE}') THEN CREATE ROLE {ROLE} NOLOGIN NOBYPASSRLS; END IF;
  IF NOT pg_has_role(current_user, '{ROLE}', 'MEMBER') THEN
    EXECUTE 'GRANT {ROLE} TO ' || quote_ident(current_user);
  END IF;
EXCEPTION
  WHEN duplicate_object OR unique_violation THEN NULL;  -- made at the same moment, for another database
  WHEN insufficient_privilege THEN
    RAISE EXCEPTION USING MESSAGE =
      'this login may make no role; let an administrator run: CREATE ROLE {ROLE} NOLOGIN; '
      'GRANT {ROLE} TO ' || quote_ident(current_user);
END $$"""


def see(connection: Connection, lab: str) -> None:
    """Until the transaction ends. With `is_local` false the next request on this connection would have it."""
    if connection.dialect.name == "postgresql":
        connection.execute(sa.text(f"SELECT set_config('{SETTING}', :lab, true)"), {"lab": lab})


def seeing(lab: str) -> str:
    """The same as a statement for a transaction that has just begun."""
    if "\0" in lab:
        raise ValueError(f"{lab!a} is no lab")
    return f"SET LOCAL {SETTING} = '{lab.replace(chr(39), 2 * chr(39))}'"


def sees_all(connection: Connection) -> bool:
    """Whether the transaction sees the rows of all labs: what is not seen is no proof that nothing is there."""
    if connection.dialect.name != "postgresql":
        return True
    return bool(connection.execute(sa.text(f"SELECT {NAMED} = '{ALL}'")).scalar())


def make_role(connection: Connection) -> None:
    """Where it is not there yet; and what comes after needs no word for it."""
    kept = "SELECT, INSERT, UPDATE, DELETE"
    for statement in (
        NO_RIGHT,
        f"GRANT USAGE ON SCHEMA public TO {ROLE}",
        f"GRANT {kept} ON ALL TABLES IN SCHEMA public TO {ROLE}",
        f"ALTER DEFAULT PRIVILEGES IN SCHEMA public GRANT {kept} ON TABLES TO {ROLE}",
    ):
        connection.exec_driver_sql(statement)


def grant_schema(connection: Connection, schema: str) -> None:
    """All that is in a schema of somebody else's making, such as the queue's."""
    for statement in (
        f"GRANT USAGE ON SCHEMA {schema} TO {ROLE}",
        f"GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA {schema} TO {ROLE}",
        f"GRANT USAGE, SELECT ON ALL SEQUENCES IN SCHEMA {schema} TO {ROLE}",
        f"GRANT EXECUTE ON ALL FUNCTIONS IN SCHEMA {schema} TO {ROLE}",
    ):
        connection.exec_driver_sql(statement)


def guard(connection: Connection, tables: Iterable[str]) -> None:
    """For a migration that makes a table of labs."""
    if connection.dialect.name != "postgresql":
        return
    for table in tables:
        for statement in (
            f"ALTER TABLE {table} ENABLE ROW LEVEL SECURITY",
            f"ALTER TABLE {table} FORCE ROW LEVEL SECURITY",
            f"CREATE POLICY of_lab ON {table} USING {MINE} WITH CHECK {MINE}",
        ):
            connection.exec_driver_sql(statement)


def unguard(connection: Connection, tables: Iterable[str]) -> None:
    if connection.dialect.name != "postgresql":
        return
    for table in tables:
        connection.exec_driver_sql(f"DROP POLICY of_lab ON {table}")
        connection.exec_driver_sql(f"ALTER TABLE {table} NO FORCE ROW LEVEL SECURITY")
        connection.exec_driver_sql(f"ALTER TABLE {table} DISABLE ROW LEVEL SECURITY")
