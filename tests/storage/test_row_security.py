"""PostgreSQL keeps labs apart by itself: on every table, from every statement, on every connection."""

from __future__ import annotations

from datetime import timedelta

import psycopg
import pytest
import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.storage import orphans
from exogauge.storage.files import PinnedFile
from exogauge.storage.migrate import downgrade, upgrade
from exogauge.storage.row_security import ALL, ROLE, see
from exogauge.storage.scope import OF_ALL_LABS, LabSession
from exogauge.storage.store import Installation, Storage
from exogauge.storage.tables import Base, Study

on_postgresql = pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
OWNED = sorted(name for name, table in Base.metadata.tables.items() if "lab_id" in table.columns)


@pytest.fixture
def installation(storage: Storage, without_bytes: None) -> Installation:
    """North and south have a study each."""
    made = Installation(storage.engine, storage.blobs)
    for lab in ("north", "south"):
        with made.of_lab(lab).transaction() as store:
            store.studies.add(f"of {lab}", [PinnedFile("study.yaml", "1" * 64, 10)], {})
    return made


@on_postgresql
def test_every_table_of_labs_is_guarded_from_its_owner_too(storage: Storage) -> None:
    query = sa.text(
        "SELECT relname, relrowsecurity AND relforcerowsecurity, pg_get_userbyid(relowner), "
        "(SELECT string_agg(polcmd::text || pg_get_expr(polqual, polrelid) || pg_get_expr(polwithcheck, polrelid), '') "
        "FROM pg_policy WHERE polrelid = pg_class.oid) FROM pg_class WHERE relname = ANY(:names) AND relkind = 'r'"
    )
    role = sa.text("SELECT current_user, rolsuper OR rolbypassrls FROM pg_roles WHERE rolname = current_user")
    with storage.engine.begin() as connection:
        found = connection.execute(query, {"names": OWNED}).all()
        assert connection.execute(role).one() == (ROLE, False)
    assert sorted(row[0] for row in found) == OWNED
    for name, guarded, owner, policy in found:
        assert guarded, name
        assert owner != ROLE, name
        assert policy.startswith("*"), name  # of reading, adding, changing and deleting
        assert policy.count("lab_id") == policy.count(f"'{ALL}'") == 2, name


@on_postgresql
def test_a_statement_that_forgets_the_lab_and_the_orm_sees_its_own_lab_alone(installation: Installation) -> None:
    raw = sa.text("SELECT name FROM studies")
    with installation.of_lab("north").transaction() as store:
        look = store.session
        assert look.scalars(raw).all() == ["of north"]
        assert look.execute(sa.text("UPDATE studies SET name = 'taken'")).rowcount == 1  # type: ignore[attr-defined]
        assert look.execute(sa.text("DELETE FROM studies WHERE lab_id = 'south'")).rowcount == 0  # type: ignore[attr-defined]
        assert look.connection().scalars(sa.select(sa.func.count()).select_from(Study.__table__)).all() == [1]
        assert sorted(look.scalars(sa.select(Study.lab_id), execution_options=OF_ALL_LABS)) == ["north", "south"]
        assert look.scalars(raw).all() == ["taken"]  # and no longer all
    with installation.session() as session:
        assert sorted(session.scalars(raw)) == ["of south", "taken"]
    into = sa.text(
        "INSERT INTO uploads (id, lab_id, created_at, name, size, expires_at) "
        "VALUES ('u', 'south', now(), 'x', 1, now())"
    )
    with pytest.raises(sa.exc.ProgrammingError, match="row-level security"):  # noqa: SIM117
        with installation.of_lab("north").transaction() as store:
            store.session.execute(into)


@on_postgresql
def test_a_connection_that_goes_back_to_the_pool_takes_no_lab_with_it(installation: Installation) -> None:
    raw = sa.text("SELECT name FROM studies")
    with installation.of_lab("north").reading() as store:
        assert store.session.scalars(raw).all() == ["of north"]
    with installation.session() as session:
        assert len(session.scalars(raw).all()) == 2
    for _ in range(12):  # more than the pool holds
        with installation.engine.begin() as connection:
            assert connection.scalars(raw).all() == []
            see(connection, "south")
            assert connection.scalars(raw).all() == ["of south"]


@on_postgresql
def test_a_savepoint_that_is_taken_back_leaves_the_lab_as_it_was(installation: Installation) -> None:
    raw = sa.text("SELECT name FROM studies")
    with installation.of_lab("north").transaction() as store:
        with pytest.raises(ZeroDivisionError), store.session.begin_nested():
            raise ZeroDivisionError
        assert store.session.scalars(raw).all() == ["of north"]


@on_postgresql
def test_what_one_lab_does_not_see_is_not_taken_for_an_orphan(installation: Installation) -> None:
    with installation.session() as session:
        assert orphans.named(session, "1") == {"1" * 64}
    for sort in (Session(installation.engine), LabSession(installation.engine, "west", "x", installation.blobs)):
        with sort as session:
            with pytest.raises(AssertionError):
                orphans.named(session, "1")
            with pytest.raises(AssertionError):
                orphans.condemn(session, timedelta(0))


@on_postgresql
def test_what_the_service_works_as_may_not_take_the_guard_away(storage: Storage) -> None:
    for statement in (
        "ALTER TABLE studies DISABLE ROW LEVEL SECURITY",
        "DROP POLICY of_lab ON studies",
        "ALTER TABLE audit DISABLE TRIGGER ALL",
        "TRUNCATE audit",
        "CREATE TABLE mine (id int)",
    ):
        with pytest.raises(sa.exc.ProgrammingError), storage.engine.begin() as connection:
            connection.exec_driver_sql(statement)


@pytest.mark.slow
def test_a_login_that_is_no_superuser_serves_and_is_told_where_it_may_make_no_role(postgres_url: str) -> None:
    name = postgres_url.rsplit("/", 1)[1]
    login = f"login_{name[-8:]}"
    with psycopg.connect(postgres_url, autocommit=True) as connection:
        connection.execute(f'CREATE ROLE "{login}" LOGIN CREATEROLE')
        connection.execute(f'ALTER SCHEMA public OWNER TO "{login}"')
        connection.execute(f'ALTER DATABASE "{name}" OWNER TO "{login}"')
    mine = postgres_url.replace("//postgres@", f"//{login}@").replace("//root@", f"//{login}@")
    upgrade(mine)
    upgrade(mine)
    downgrade(mine, "0012")
    with psycopg.connect(postgres_url, autocommit=True) as connection:
        connection.execute(f'REVOKE {ROLE} FROM "{login}"')
        connection.execute(f'ALTER ROLE "{login}" NOCREATEROLE')
    with pytest.raises(sa.exc.DBAPIError, match=f"GRANT {ROLE} TO {login}"):
        upgrade(mine)
    with psycopg.connect(postgres_url, autocommit=True) as connection:
        connection.execute(f'REASSIGN OWNED BY "{login}" TO current_user')
        connection.execute(f'DROP OWNED BY "{login}"')
        connection.execute(f'DROP ROLE "{login}"')
