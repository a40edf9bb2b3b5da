"""The schema can be made, checked and taken back on both databases; nothing unknown is served."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest
import sqlalchemy as sa

from exogauge.storage import migrate
from exogauge.storage.database import make_engine
from exogauge.storage.tables import (
    Artifact,
    Base,
    IdempotencyKey,
    Job,
    Motion,
    Payload,
    Plan,
    Result,
    Robot,
    Study,
    StudyFile,
)


def owner(url: str) -> sa.Engine:
    """Sees the rows of all labs; with foreign keys on."""
    engine = make_engine(url, migrating=True)
    if engine.dialect.name == "sqlite":
        sa.event.listen(engine, "connect", lambda connection, _: connection.execute("PRAGMA foreign_keys=ON"))
    return engine


OF_NO_LAB = {"identities", "worker_leases", "orphans", "chores", "labs", "accounts", "sessions", "sign_in_tries"}


@pytest.mark.slow
def test_upgrade_check_downgrade_leave_nothing_over(empty_database_url: str) -> None:
    assert migrate.current(empty_database_url) is None
    assert migrate.upgrade(empty_database_url) == migrate.newest()
    migrate.check(empty_database_url)
    migrate.downgrade(empty_database_url, "base")
    assert migrate.current(empty_database_url) is None
    assert tables(empty_database_url) <= {"alembic_version"}
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)


def test_check_finds_a_table_that_no_migration_made(own_database_url: str) -> None:
    execute(own_database_url, "ALTER TABLE robots ADD COLUMN surprise INTEGER")
    with pytest.raises(migrate.WrongSchema, match="surprise"):
        migrate.check(own_database_url)


def test_tables_of_the_job_engine_are_none_of_our_business(empty_database_url: str) -> None:
    execute(empty_database_url, "CREATE TABLE workflow_status (id INTEGER)")
    migrate.prepare(empty_database_url)
    migrate.check(empty_database_url)


def test_a_new_database_is_prepared_and_one_at_the_newest_revision_is_left_alone(empty_database_url: str) -> None:
    migrate.prepare(empty_database_url)
    migrate.prepare(empty_database_url)
    assert migrate.current(empty_database_url) == migrate.newest()


def test_an_unknown_revision_is_refused_with_instructions(own_database_url: str) -> None:
    execute(own_database_url, "UPDATE alembic_version SET version_num = 'from_the_future'")
    with pytest.raises(migrate.WrongSchema, match=r"from_the_future.*newer.*restore the backup"):
        migrate.prepare(own_database_url)
    with pytest.raises(migrate.WrongSchema, match="does not know"):
        migrate.upgrade(own_database_url)


def test_tables_without_a_revision_are_refused(empty_database_url: str) -> None:
    execute(empty_database_url, "CREATE TABLE robots (id INTEGER)")
    with pytest.raises(migrate.WrongSchema, match="no revision"):
        migrate.prepare(empty_database_url)


def test_every_constraint_has_a_name_and_every_lab_row_its_lab() -> None:
    for table in Base.metadata.tables.values():
        assert all(constraint.name for constraint in table.constraints), table.name
        assert "lab_id" in table.columns or table.name in OF_NO_LAB


def test_the_migrated_schema_keeps_what_the_engine_relies_on(own_database_url: str) -> None:
    """An equal live request is refused by the database itself; after a failure it is welcome again."""
    engine = owner(own_database_url)
    job = {"lab_id": "l", "kind": "evaluate", "study_id": "s", "request_hash": "h"}
    with engine.begin() as connection:
        connection.execute(sa.insert(Study).values(id="s", lab_id="l", name="s", content_hash="c", summary={}))
        connection.execute(sa.insert(Job).values(id="a", state="queued", **job))
    with pytest.raises(sa.exc.IntegrityError), engine.begin() as connection:
        connection.execute(sa.insert(Job).values(id="b", state="succeeded", **job))
    with engine.begin() as connection:
        connection.execute(sa.update(Job).values(state="failed", finished_at=datetime.now(UTC)))
        connection.execute(sa.insert(Job).values(id="b", state="queued", **job))
        assert connection.scalar(sa.select(Job.revision).where(Job.id == "a")) == 1
    engine.dispose()


@pytest.mark.slow
def test_what_the_first_schema_held_is_there_after_each_step_up_and_down(empty_database_url: str) -> None:
    migrate.upgrade(empty_database_url, "0001")
    execute(empty_database_url, "INSERT INTO studies (id, lab_id, created_at, name, content_hash, summary) "
            "VALUES ('s', 'local', '2026-01-01', 'old', 'c', '{}')")  # fmt: skip
    execute(empty_database_url, "INSERT INTO jobs (id, lab_id, created_at, kind, study_id, request_hash, settings, "
            "code_version, state, progress, message, attempts, cancel_requested, log, revision) VALUES "
            "('j', 'local', '2026-01-01', 'evaluate', 's', 'h', '{}', '', 'failed', 0, '', 1, '0', '', 3)")  # fmt: skip
    migrate.upgrade(empty_database_url)
    engine = owner(empty_database_url)
    with engine.connect() as connection:
        assert connection.execute(sa.select(Job.revision, Job.failure)).all() == [(3, None)]
    engine.dispose()
    migrate.downgrade(empty_database_url, "0001")
    assert "devices" not in tables(empty_database_url)
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)


@pytest.mark.slow
def test_going_back_before_payloads_takes_their_jobs_and_leaves_those_of_studies(empty_database_url: str) -> None:
    migrate.upgrade(empty_database_url)
    engine = owner(empty_database_url)
    job = {"lab_id": "l", "kind": "k", "state": "failed"}
    with engine.begin() as connection:
        connection.execute(sa.insert(Study).values(id="s", lab_id="l", name="s", content_hash="c", summary={}))
        connection.execute(
            sa.insert(Payload).values(id="p", lab_id="l", name="p", version=1, content_hash="c", summary={})
        )
        connection.execute(sa.insert(Job).values(id="of study", study_id="s", request_hash="a", **job))
        connection.execute(sa.insert(Job).values(id="of payload", payload_id="p", request_hash="b", **job))
    engine.dispose()
    migrate.downgrade(empty_database_url, "0004")
    assert not {"payloads", "payload_files", "live_streams"} & tables(empty_database_url)
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)
    engine = owner(empty_database_url)
    with engine.connect() as connection:
        assert connection.scalars(sa.select(Job.id)).all() == ["of study"]
    with pytest.raises(sa.exc.IntegrityError), engine.begin() as connection:
        connection.execute(
            sa.insert(Job).values(id="c", lab_id="l", study_id="s", request_hash="c", kind="k", state="odd")
        )
    engine.dispose()


@pytest.mark.slow
def test_going_back_before_motions_takes_their_jobs_and_leaves_those_of_studies(empty_database_url: str) -> None:
    migrate.upgrade(empty_database_url)
    engine = owner(empty_database_url)
    job = {"lab_id": "l", "kind": "k", "state": "failed"}
    named = {"lab_id": "l", "name": "n", "content_hash": "c", "summary": {}}
    with engine.begin() as connection:
        connection.execute(sa.insert(Study).values(id="s", **named))
        connection.execute(sa.insert(Robot).values(id="r", version=1, **named))
        connection.execute(sa.insert(Motion).values(id="m", version=1, **named))
        connection.execute(sa.insert(Plan).values(id="p", robot_id="r", motion_id="m", **named))
        for of, key in (("study", "s"), ("motion", "m"), ("plan", "p")):
            connection.execute(sa.insert(Job).values(id=f"of {of}", request_hash=of, **{f"{of}_id": key}, **job))
        connection.execute(
            sa.insert(Result).values(id="x", lab_id="l", job_id="of plan", plan_id="p", sha256="0", size=1)
        )
    with pytest.raises(sa.exc.IntegrityError), engine.begin() as connection:
        connection.execute(sa.insert(Job).values(id="two", request_hash="t", study_id="s", plan_id="p", **job))
    engine.dispose()
    migrate.downgrade(empty_database_url, "0018")
    assert not {"motions", "motion_files", "plans", "plan_files", "motion_maps"} & tables(empty_database_url)
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)
    engine = owner(empty_database_url)
    with engine.connect() as connection:
        assert connection.scalars(sa.select(Job.id)).all() == ["of study"]
    engine.dispose()


@pytest.mark.slow
def test_what_a_worker_wrote_under_another_lab_goes_back_to_its_job_s(empty_database_url: str) -> None:
    """A worker started for another lab than the server's wrote results and files under its own."""
    migrate.upgrade(empty_database_url, "0006")
    rows = {
        "studies": {"id": "s", "lab_id": "north", "name": "s", "content_hash": "c", "summary": "{}"},
        "study_files": {"id": "f", "lab_id": "north", "study_id": "s", "path": "study.yaml", "sha256": "h", "size": 1},
        "jobs": {
            "id": "j", "lab_id": "north", "kind": "evaluate", "study_id": "s", "request_hash": "h", "settings": "{}",
            "code_version": "", "state": "succeeded", "progress": 1, "message": "", "attempts": 1,
            "cancel_requested": "0", "log": "", "revision": 3,
        },
        "results": {"id": "r", "lab_id": "local", "job_id": "j", "study_id": "s", "sha256": "h", "size": 1},
        "artifacts": {
            "id": "a", "lab_id": "local", "job_id": "j", "name": "a.csv", "sha256": "h", "size": 1, "media_type": "m",
        },
    }  # fmt: skip
    for table, row in rows.items():
        values = {**row, "created_at": "2026-01-01"}
        said = ", ".join(str(value) if isinstance(value, int) else f"'{value}'" for value in values.values())
        execute(empty_database_url, f"INSERT INTO {table} ({', '.join(values)}) VALUES ({said})")
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)
    engine = owner(empty_database_url)
    with engine.connect() as connection:
        kept = [connection.execute(sa.select(table.id, table.lab_id)).all() for table in (Study, StudyFile, Job)]
        moved = [connection.execute(sa.select(table.id, table.lab_id)).all() for table in (Result, Artifact)]
    assert kept == [[("s", "north")], [("f", "north")], [("j", "north")]]
    assert moved == [[("r", "north")], [("a", "north")]]
    with engine.begin() as connection:
        connection.execute(sa.delete(Study))
        assert connection.execute(sa.select(Artifact.id)).all() == []  # still goes with its owner
    engine.dispose()
    migrate.downgrade(empty_database_url, "0006")
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)


@pytest.mark.slow
def test_a_reference_between_labs_that_no_worker_made_stops_the_upgrade_and_changes_nothing(
    empty_database_url: str,
) -> None:
    migrate.upgrade(empty_database_url, "0006")
    execute(empty_database_url, "INSERT INTO studies (id, lab_id, created_at, name, content_hash, summary) "
            "VALUES ('s', 'north', '2026-01-01', 's', 'c', '{}')")  # fmt: skip
    execute(empty_database_url, "INSERT INTO study_files (id, lab_id, created_at, study_id, path, sha256, size) "
            "VALUES ('f', 'south', '2026-01-01', 's', 'study.yaml', 'h', 1)")  # fmt: skip
    with pytest.raises((AssertionError, sa.exc.IntegrityError)):
        migrate.upgrade(empty_database_url)
    assert migrate.current(empty_database_url) == "0006"
    assert ["lab_id", "study_id"] not in keys_of(empty_database_url, "study_files")


@pytest.mark.slow
def test_an_answer_is_still_kept_for_its_day_and_what_was_in_flight_is_free(empty_database_url: str) -> None:
    migrate.upgrade(empty_database_url, "0007")
    for key, answer in (("answered", "'{}'"), ("in flight", "NULL")):
        columns = "id, lab_id, created_at, key, owner, request_hash, answer"
        values = f"'{key}', 'north', '2026-01-01 12:00:00', '{key}', '{'host/' * 20}', 'h', {answer}"
        execute(empty_database_url, f"INSERT INTO idempotency_keys ({columns}) VALUES ({values})")
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)
    engine = owner(empty_database_url)
    with engine.connect() as connection:
        kept = connection.execute(sa.select(IdempotencyKey.key, IdempotencyKey.expires_at)).all()
    engine.dispose()
    assert kept == [("answered", datetime(2026, 1, 2, 12, tzinfo=UTC))]
    migrate.downgrade(empty_database_url, "0007")
    migrate.upgrade(empty_database_url)


@pytest.mark.slow
def test_a_job_that_nobody_has_begun_names_only_the_code_it_was_asked_of(empty_database_url: str) -> None:
    migrate.upgrade(empty_database_url, "0008")
    execute(empty_database_url, "INSERT INTO studies (id, lab_id, created_at, name, content_hash, summary) "
            "VALUES ('s', 'north', '2026-01-01', 's', 'c', '{}')")  # fmt: skip
    columns = "id, lab_id, created_at, kind, study_id, request_hash, settings, code_version, state, progress, message, "
    columns += "attempts, cancel_requested, log, revision, started_at"
    for key, state, started in (("j", "succeeded", "'2026-01-01'"), ("k", "queued", "NULL")):
        values = (
            f"'{key}', 'north', '2026-01-01', 'evaluate', 's', '{key}', '{{}}', '0.1', '{state}', 0, '', 1, '0', '', 0"
        )
        execute(empty_database_url, f"INSERT INTO jobs ({columns}) VALUES ({values}, {started})")
    migrate.upgrade(empty_database_url)
    migrate.check(empty_database_url)
    engine = owner(empty_database_url)
    with engine.connect() as connection:
        found = connection.execute(sa.select(Job.id, Job.requested_code_version, Job.code_version).order_by(Job.id))
        assert found.all() == [("j", "0.1", "0.1"), ("k", "0.1", None)]
    engine.dispose()
    migrate.downgrade(empty_database_url, "0008")
    migrate.upgrade(empty_database_url)


def tables(url: str) -> set[str]:
    engine = owner(url)
    names = set(sa.inspect(engine).get_table_names())
    engine.dispose()
    return names


def execute(url: str, statement: str) -> None:
    engine = owner(url)
    with engine.begin() as connection:
        connection.exec_driver_sql(statement)
    engine.dispose()


def keys_of(url: str, table: str) -> list[list[str]]:
    """The columns of each foreign key of a table, as the database has them."""
    engine = owner(url)
    found = [key["constrained_columns"] for key in sa.inspect(engine).get_foreign_keys(table)]
    engine.dispose()
    return found
