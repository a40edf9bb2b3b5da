"""What the store promises of robots, devices, logs, studies, jobs, results and keys."""

from __future__ import annotations

import sqlite3
import threading
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import psycopg
import pytest
import sqlalchemy as sa

from exogauge.errors import NotFound
from exogauge.settings import Settings
from exogauge.storage import keys
from exogauge.storage.database import database_now
from exogauge.storage.files import PinnedFile
from exogauge.storage.jobs import latest_of
from exogauge.storage.store import Installation, Storage, Store, open_installation
from exogauge.storage.tables import OWNERS, AuditEntry, IdempotencyKey, Job, RobotFile, WorkerLease, new_id

pytestmark = pytest.mark.usefixtures("without_bytes")

FILES = (PinnedFile("robot.urdf", "1" * 64, 10), PinnedFile("robot.yaml", "2" * 64, 20))
OTHER = (PinnedFile("robot.urdf", "3" * 64, 11), FILES[1])


def test_a_robot_is_versioned_by_name_and_found_by_content(storage: Storage) -> None:
    with storage.transaction() as store:
        first, new = store.robots.add("arm", FILES, {"joints": ["a"]})
        second, _ = store.robots.add("arm", OTHER, {})
        again, again_new = store.robots.add("arm", FILES, {})
        elsewhere, _ = store.robots.add("leg", FILES, {})
    assert (new, again_new, again.id) == (True, False, first.id)
    assert (first.version, second.version, elsewhere.version) == (1, 2, 1)
    with storage.reading() as store:
        assert store.robots.files(second.id) == OTHER
        assert store.robots.get(first.id) == first
        actions = store.session.scalars(sa.select(AuditEntry.subject_id)).all()
    assert sorted(actions) == sorted([first.id, second.id, elsewhere.id])


def test_robots_added_at_once_all_get_their_own_version(storage: Storage) -> None:
    def add(k: int) -> None:
        with storage.transaction() as store:
            store.robots.add("arm", [PinnedFile("robot.yaml", f"{k:064}", k)], {})

    in_parallel(add, 5)
    with storage.reading() as store:
        assert sorted(robot.version for robot in store.robots.page(None, 50).items) == [1, 2, 3, 4, 5]
        assert store.session.scalar(sa.select(sa.func.count()).select_from(RobotFile)) == 5


def test_a_device_is_versioned_by_name_content_and_the_robot_it_was_checked_against(storage: Storage) -> None:
    with storage.transaction() as store:
        arm, leg = (store.robots.add(name, FILES, {})[0].id for name in ("arm", "leg"))
        first, new = store.devices.add("suit", FILES, {"groups": ["A"]}, robot_id=arm)
        other, _ = store.devices.add("suit", OTHER, {}, robot_id=arm)
        elsewhere, elsewhere_new = store.devices.add("suit", FILES, {}, robot_id=leg)
        again, again_new = store.devices.add("suit", FILES, {}, robot_id=arm)
        glove, _ = store.devices.add("glove", FILES, {}, robot_id=arm)
    assert (new, elsewhere_new, again_new, again.id) == (True, True, False, first.id)
    assert [each.version for each in (first, other, elsewhere, glove)] == [1, 2, 3, 1]
    with storage.reading() as store:
        assert store.devices.files(other.id) == OTHER
        assert store.devices.file(first.id, "robot.yaml") == FILES[1]
        assert store.devices.get(first.id).summary == {"groups": ["A"]}
        assert {each.id for each in store.devices.page(None, 9, name="suit").items} == {
            first.id,
            other.id,
            elsewhere.id,
        }
        assert [each.id for each in store.devices.page(None, 9, robot_id=leg).items] == [elsewhere.id]
        for path in ("robot.yml", "../robot.yaml", "", "\0"):
            with pytest.raises(NotFound):
                store.devices.file(first.id, path)


def test_a_device_of_a_robot_that_another_lab_has_cannot_be_added(storage: Storage) -> None:
    with storage.transaction() as store:
        robot = store.robots.add("arm", FILES, {})[0].id
        device = store.devices.add("suit", FILES, {}, robot_id=robot)[0].id
    other = Storage(storage.engine, storage.blobs, "other")
    with other.transaction() as store:
        assert store.devices.page(None, 9).items == ()
        with pytest.raises(NotFound):
            store.devices.add("suit", FILES, {}, robot_id=robot)
        with pytest.raises(NotFound):
            store.devices.file(device, "robot.yaml")


def test_the_same_study_added_at_once_is_one_study(storage: Storage) -> None:
    found = list[tuple[str, bool]]()

    def add(_k: int) -> None:
        with storage.transaction() as store:
            study, new = store.studies.add("s", FILES, {})
        found.append((study.id, new))

    in_parallel(add, 5)
    assert len({key for key, _ in found}) == 1
    assert sum(new for _, new in found) == 1


def test_a_log_differs_by_name_bytes_and_mapping(storage: Storage) -> None:
    file, mapping = PinnedFile("id.csv", "1" * 64, 5), PinnedFile("mapping.yaml", "2" * 64, 5)
    with storage.transaction() as store:
        plain, _ = store.logs.add(file, None, {})
        mapped, _ = store.logs.add(file, mapping, {})
        renamed, _ = store.logs.add(PinnedFile("other.csv", "1" * 64, 5), None, {})
        again, new = store.logs.add(file, mapping, {})
    assert len({plain.id, mapped.id, renamed.id}) == 3
    assert (again.id, new, again.mapping_sha256) == (mapped.id, False, "2" * 64)


def test_a_study_is_laid_out_as_it_was_handed_in(storage: Storage, tmp_path: Path) -> None:
    contents = {"study.yaml": b"version: 1", "logs/a.csv": b"t\n0\n"}
    files = [PinnedFile(path, storage.blobs.put(content), len(content)) for path, content in contents.items()]
    with storage.transaction() as store:
        study, _ = store.studies.add("s", files, {})
        store.studies.write_to(study.id, tmp_path / "out")
    assert {path: (tmp_path / "out" / path).read_bytes() for path in contents} == contents


def test_pages_show_everything_once_newest_first_while_more_arrives(storage: Storage) -> None:
    added = [add_study(storage, k) for k in range(7)]
    seen, after = list[str](), None
    while True:
        with storage.reading() as store:
            page = store.studies.page(after, 3)
        seen += [study.id for study in page.items]
        after = page.after
        if after is None:
            break
        add_study(storage, 100 + len(seen))
    assert seen == added[::-1]


def test_another_lab_sees_nothing(storage: Storage) -> None:
    key = add_study(storage, 1)
    other = Storage(storage.engine, storage.blobs, "other")
    with other.transaction() as store:
        assert store.studies.page(None, 10).items == ()
        with pytest.raises(NotFound):
            store.studies.get(key)
        _, new = store.studies.add("s", [PinnedFile("study.yaml", f"{1:064}", 1)], {})
        assert new


def test_a_key_that_is_none_is_not_found(storage: Storage) -> None:
    with storage.reading() as store:
        for noun in (store.robots, store.devices, store.logs, store.studies, store.jobs):
            for key in ("", "x", "0" * 36, "'; DROP TABLE jobs; --", "\0", "\ud800"):
                with pytest.raises(NotFound):
                    noun.get(key)


def test_the_latest_job_of_each_study_is_found(storage: Storage) -> None:
    first, second = add_study(storage, 1), add_study(storage, 2)
    now = datetime.now(UTC)
    with storage.transaction() as store:
        for k, (study, state) in enumerate([(first, "succeeded"), (first, "failed"), (second, "queued")]):
            made = now + timedelta(seconds=k)
            store.session.add(Job(kind="e", study_id=study, request_hash=str(k), state=state, created_at=made))
    with storage.reading() as store:
        assert {key: job.state for key, job in store.jobs.latest("study", [first, second]).items()} == {
            first: "failed",
            second: "queued",
        }
        assert [job.state for job in store.jobs.page(None, 10, study_id=first).items] == ["failed", "succeeded"]
        assert store.jobs.page(None, 10, state="queued").items[0].study_id == second
        with pytest.raises(NotFound, match="succeeded yet"):
            store.results.of_study(second)


@pytest.mark.parametrize("noun", OWNERS)
def test_the_newest_job_of_each_is_found_without_reading_all_of_the_lab(storage: Storage, noun: str) -> None:
    """SQLite took the index by lab for the better one, as long as the query named it; PostgreSQL read all of the table
    and put it into a hash."""
    postgresql = storage.engine.dialect.name == "postgresql"
    study, others = add_study(storage, 1), 3000
    job = {"lab_id": "local", "kind": "e", "study_id": study, "state": "failed", "created_at": datetime.now(UTC)}
    made = [{**job, "id": new_id(), "request_hash": str(k)} for k in range(others)]
    with storage.transaction() as store:
        store.session.execute(sa.insert(Job), made)
    asked = latest_of(noun).params(lab="local", keys=["a", "b"])
    words = str(asked.compile(storage.engine, compile_kwargs={"literal_binds": True}))
    with storage.transaction() as store:
        store.session.execute(sa.text("ANALYZE jobs"))
        told = store.session.execute(sa.text(f"EXPLAIN {'' if postgresql else 'QUERY PLAN'} {words}"))
        steps = [row[0 if postgresql else 3] for row in told]
    assert any(f"ix_jobs_{noun}_id" in step for step in steps), steps
    assert not any("Seq Scan on jobs" in step or step.startswith("SCAN jobs") for step in steps), steps
    assert not any("lab_id=" in step for step in steps), steps


def test_what_was_added_is_found_before_it_is_kept(storage: Storage) -> None:
    study = add_study(storage, 1)
    with storage.transaction() as store:
        row = Job(id=new_id(), kind="e", study_id=study, request_hash="h", log="words")
        store.session.add(row)
        assert store.jobs.get(row.id).log == "words"
        assert [job.id for job in store.jobs.page(None, 9).items] == [row.id]


def test_a_worker_counts_while_its_beat_is_recent(storage: Storage) -> None:
    now = datetime.now(UTC)
    with storage.transaction() as store:
        for name, age_s in (("fresh", 1), ("stale", 60)):
            beat = now - timedelta(seconds=age_s)
            store.session.add(WorkerLease(worker_id=name, beat_at=beat, started_at=beat, host="h", pid=1))
    assert Installation(storage.engine, storage.blobs).workers_alive() == 1


def hold(storage: Storage, key: str, lease_s: float = 60.0) -> keys.Held | keys.UsedKey:
    with storage.transaction() as store:
        return store.keys.reserve(key, timedelta(seconds=lease_s))


def test_a_key_in_flight_is_one_request_s_until_its_lease_ends(storage: Storage) -> None:
    first = hold(storage, "k", 0.0)
    second = hold(storage, "k")
    assert isinstance(first, keys.Held)
    assert isinstance(second, keys.Held)
    assert hold(storage, "k") == keys.UsedKey(None, None)
    with storage.transaction() as store:  # the first wakes up: it has lost the key, and leaves the second alone
        assert not store.keys.hold_on(first, timedelta(minutes=1))
        assert not store.keys.answer(first, "f" * 64, {"status": 500})
        store.keys.release(first)
        assert store.keys.answer(second, "h" * 64, {"status": 201})
        assert not store.keys.hold_on(second, timedelta(minutes=1))  # an answer is no lease
    assert hold(storage, "k") == keys.UsedKey("h" * 64, {"status": 201})


def test_a_lease_that_is_put_off_does_not_end(storage: Storage) -> None:
    held = hold(storage, "k", 0.2)
    assert isinstance(held, keys.Held)
    with storage.transaction() as store:
        assert store.keys.hold_on(held, timedelta(minutes=1))
    time.sleep(0.3)
    assert hold(storage, "k") == keys.UsedKey(None, None)
    with storage.transaction() as store:
        store.keys.release(held)
    assert isinstance(hold(storage, "k"), keys.Held)


def test_of_many_who_ask_for_a_key_at_once_one_holds_it(storage: Storage) -> None:
    hold(storage, "k", 0.0)  # and its end is seen by all of them
    found = list[keys.Held | keys.UsedKey]()
    in_parallel(lambda _: found.append(hold(storage, "k")), 8)
    assert sum(isinstance(each, keys.Held) for each in found) == 1
    assert sum(each == keys.UsedKey(None, None) for each in found) == 7


def test_two_labs_use_one_key_each_for_itself(storage: Storage) -> None:
    other = Storage(storage.engine, storage.blobs, "other")
    assert isinstance(hold(storage, "k"), keys.Held)
    assert isinstance(hold(other, "k"), keys.Held)
    assert hold(other, "k") == keys.UsedKey(None, None)


def test_keys_are_forgotten_after_a_day(storage: Storage) -> None:
    held = hold(storage, "k")
    assert isinstance(held, keys.Held)
    with storage.transaction() as store:
        assert store.keys.answer(held, "h" * 64, {"status": 201})
        day = store.session.scalars(sa.select(IdempotencyKey.expires_at)).one() - database_now(store.session)
        assert timedelta(hours=23, minutes=59) < day <= timedelta(days=1)
    assert hold(storage, "k") == keys.UsedKey("h" * 64, {"status": 201})
    with storage.transaction() as store:
        store.session.execute(sa.update(IdempotencyKey).values(expires_at=database_now(store.session)))
    assert isinstance(hold(storage, "k"), keys.Held)


def test_a_connection_in_use_is_closed_when_it_is_given_back_to_a_closed_installation(settings: Settings) -> None:
    opened = open_installation(settings)
    in_use = opened.engine.connect()
    held = in_use.connection.dbapi_connection
    assert held is not None
    opened.close()
    assert in_use.execute(sa.text("SELECT 1")).scalar_one() == 1
    in_use.close()
    with pytest.raises((sqlite3.ProgrammingError, psycopg.OperationalError)):
        held.cursor().execute("SELECT 1")


def add_study(storage: Storage, k: int) -> str:
    with storage.transaction() as store:
        return add(store, k)


def add(store: Store, k: int) -> str:
    study, _ = store.studies.add("s", [PinnedFile("study.yaml", f"{k:064}", 1)], {})
    return study.id


def in_parallel(action: object, count: int) -> None:
    failed = list[BaseException]()

    def run(k: int) -> None:
        try:
            action(k)  # type: ignore[operator]
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=run, args=(k,)) for k in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
