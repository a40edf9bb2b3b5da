"""Both databases behave alike where they would not by themselves."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta, timezone

import psycopg
import pytest
import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError, StatementError
from sqlalchemy.orm import Session

from exogauge.errors import Unavailable
from exogauge.storage.database import database_now, database_url, make_engine, serving
from exogauge.storage.store import Storage
from exogauge.storage.tables import Job, Study, WorkerLease


def add_job(storage: Storage) -> str:
    with storage.transaction() as store:
        store.session.add(Study(id="s", name="s", content_hash="c", summary={}))
        store.session.flush()
        job = Job(kind="evaluate", study_id="s", request_hash="h")
        store.session.add(job)
        store.session.flush()
        return job.id


def test_what_a_user_is_told_of_a_database_that_is_away_names_no_host() -> None:
    engine = make_engine("postgresql://secret_user:secret@127.0.0.1:1/secret_name")
    with pytest.raises(Unavailable) as told, serving("answer"), Session(engine):
        engine.connect()
    assert str(told.value) == "the database cannot answer now"
    assert "127.0.0.1" in str(told.value.__cause__)  # the log's business


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
def test_connections_that_the_server_has_ended_are_replaced_before_anybody_is_told(storage: Storage) -> None:
    """All that a pool holds, all asked for at once, within the time that one is trusted."""
    together = threading.Barrier(8)

    def look(_: int) -> int:
        with storage.reading() as store:
            found = int(store.session.scalar(sa.text("SELECT pg_backend_pid()")))
            together.wait()  # all hold theirs at once
            return found

    with ThreadPoolExecutor(8) as threads:
        before = set(threads.map(look, range(8)))
        address = storage.engine.url.set(drivername="postgresql").render_as_string(hide_password=False)
        with psycopg.connect(address, autocommit=True) as server:
            server.execute("SELECT pg_terminate_backend(pid, 5000) FROM unnest(%s::int[]) AS pid", [list(before)])
        after = set(threads.map(look, range(8)))
    assert (len(before), len(after), before & after) == (8, 8, set())


def test_a_time_comes_back_as_the_same_instant_in_utc(storage: Storage) -> None:
    given = datetime(2026, 3, 1, 0, 30, 0, 123456, tzinfo=timezone(timedelta(hours=9)))
    with storage.transaction() as store:
        store.session.add(WorkerLease(worker_id="w", beat_at=given, started_at=given, host="h", pid=1))
    with storage.reading() as store:
        back = store.session.scalar(sa.select(WorkerLease.beat_at))
    assert back == given
    assert back is not None
    assert back.utcoffset() == timedelta(0)


def test_a_time_without_zone_and_a_number_that_is_none_are_refused(storage: Storage) -> None:
    key = add_job(storage)
    for values in ({"started_at": datetime(2026, 1, 1)}, {"progress": float("nan")}):
        with pytest.raises(StatementError), storage.transaction() as store:
            store.session.execute(sa.update(Job).where(Job.id == key).values(**values))


@pytest.mark.parametrize("values", [{"state": "asleep"}, {"progress": 1.5}, {"study_id": "nobody"}])
def test_the_database_itself_refuses_what_cannot_be(storage: Storage, values: dict[str, object]) -> None:
    key = add_job(storage)
    with pytest.raises(IntegrityError), storage.transaction() as store:
        store.session.execute(sa.update(Job).where(Job.id == key).values(**values))


def test_the_clock_is_the_databases(storage: Storage) -> None:
    with storage.reading() as store:
        assert abs(database_now(store.session) - datetime.now(UTC)) < timedelta(seconds=5)


def test_a_transaction_that_fails_leaves_nothing(storage: Storage) -> None:
    def half_done() -> None:
        with storage.transaction() as store:
            store.session.add(Study(id="s", name="s", content_hash="c", summary={}))
            store.session.flush()
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        half_done()
    with storage.reading() as store:
        assert store.session.scalar(sa.select(sa.func.count()).select_from(Study)) == 0


def test_guarded_updates_lose_none_of_each_other(storage: Storage) -> None:
    """Four threads count; a read-modify-write would lose on either database without an error."""
    key = add_job(storage)

    def count() -> None:
        for _ in range(25):
            with storage.transaction() as store:
                store.session.execute(sa.update(Job).where(Job.id == key).values(attempts=Job.attempts + 1))

    threads = [threading.Thread(target=count) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with storage.reading() as store:
        assert store.session.execute(sa.select(Job.attempts, Job.revision)).one() == (100, 100)


def test_of_many_who_want_one_state_change_one_gets_it(storage: Storage) -> None:
    key, won = add_job(storage), list[str]()

    def claim(name: str) -> None:
        with storage.transaction() as store:
            guarded = sa.update(Job).where(Job.id == key, Job.state == "queued").values(state="running", worker=name)
            if store.session.execute(guarded).rowcount == 1:  # type: ignore[attr-defined]
                won.append(name)

    threads = [threading.Thread(target=claim, args=(f"w{k}",)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with storage.reading() as store:
        assert [store.session.scalar(sa.select(Job.worker))] == won


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_reader_does_not_wait_for_the_writer(storage: Storage) -> None:
    key = add_job(storage)
    with storage.transaction() as writer:
        writer.session.execute(sa.update(Job).values(message="half done"))
        with storage.reading() as reader:
            assert reader.jobs.page(None, 5).items[0].message == ""
            assert reader.session.scalar(sa.select(Job.id)) == key


def test_the_addresses_of_databases_are_understood_or_refused() -> None:
    assert database_url("postgres://u:p@h/d").drivername == "postgresql+psycopg"
    assert database_url("postgresql://u:p@h/d").password == "p"
    for bad in ("sqlite://", "sqlite:///:memory:", "mysql://h/d"):
        with pytest.raises(ValueError, match=r"in-memory|not supported"):
            database_url(bad)


def test_a_database_that_is_away_is_unavailable() -> None:
    engine = make_engine("postgresql://nobody@127.0.0.1:1/none")
    with pytest.raises(Unavailable, match="database"), serving("answer"), engine.connect():
        pass
    engine.dispose()
