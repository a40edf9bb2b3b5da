"""What is deleted goes with all that hangs on it, and not while something needs it; its blobs follow."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import timedelta

import pytest
import sqlalchemy as sa

from exogauge.errors import Conflict, NotFound
from exogauge.storage.accounts import Accounts
from exogauge.storage.checking import check
from exogauge.storage.files import PinnedFile
from exogauge.storage.live_streams import Counts
from exogauge.storage.store import Installation, Storage, Store
from exogauge.storage.sweeping import sweep_installation
from exogauge.storage.tables import Artifact, AuditEntry, Job, LiveStream, PayloadFile, Result, StudyFile


def pinned(store: Store, path: str, content: bytes) -> PinnedFile:
    return PinnedFile(path, store.blobs.put(content), len(content))


def add_job(store: Store, state: str, **owner: str) -> str:
    job = Job(kind="evaluate", request_hash=state, state=state, **owner)
    store.session.add(job)
    store.session.flush()
    made = pinned(store, "results.json", b"{}" + state.encode())
    store.session.add(Result(job_id=job.id, sha256=made.sha256, size=made.size, **owner))
    store.session.add(Artifact(job_id=job.id, name="a", sha256=made.sha256, size=made.size, media_type="m"))
    store.session.flush()
    return job.id


def test_a_study_goes_with_its_jobs_and_bytes_once_no_job_of_it_runs(storage: Storage) -> None:
    with storage.transaction() as store:
        study, _ = store.studies.add("study", [pinned(store, "study.yaml", b"s")], {})
        other, _ = store.studies.add("other", [pinned(store, "study.yaml", b"o")], {})
        add_job(store, "succeeded", study_id=study.id)
        going = add_job(store, "queued", study_id=study.id)
        add_job(store, "running", study_id=other.id)
    with pytest.raises(Conflict, match="1 of its jobs wait or run"), storage.transaction() as store:
        store.studies.delete(study.id)
    with storage.transaction() as store:
        store.session.execute(sa.update(Job).where(Job.id == going).values(state="cancelled"))
    with storage.transaction() as store:
        store.studies.delete(study.id)
    with pytest.raises(NotFound), storage.transaction() as store:
        store.studies.delete(study.id)
    with storage.reading() as store:
        assert [each.id for each in store.studies.page(None, 9).items] == [other.id]
        left = {table.study_id for table in store.session.scalars(sa.select(StudyFile))}
        assert left == {job.study_id for job in store.session.scalars(sa.select(Job))} == {other.id}
        assert len(store.session.scalars(sa.select(Artifact)).all()) == 1
        audited = sa.select(AuditEntry.subject_id).where(AuditEntry.action == "delete")
        assert store.session.scalars(audited).all() == [study.id]
    installation = Installation(storage.engine, storage.blobs)
    assert sweep_installation(installation, timedelta(0)).blobs == 3
    assert check(installation, None).sound


def test_a_robot_stays_while_a_device_is_of_it(storage: Storage) -> None:
    with storage.transaction() as store:
        robot, _ = store.robots.add("arm", [pinned(store, "robot.yaml", b"r")], {})
        device, _ = store.devices.add("strap", [pinned(store, "device.yaml", b"d")], {}, robot_id=robot.id)
    with pytest.raises(Conflict, match="'strap' version 1"), storage.transaction() as store:
        store.robots.delete(robot.id)
    with storage.transaction() as store:
        store.devices.delete(device.id)
        store.robots.delete(robot.id)
        assert store.robots.page(None, 9).items == store.devices.page(None, 9).items == ()


def test_a_payload_goes_with_its_streams_once_they_have_ended(storage: Storage) -> None:
    with storage.transaction() as store:
        payload, _ = store.payloads.add("tool", [pinned(store, "payload.yaml", b"p")], {})
        job = add_job(store, "succeeded", payload_id=payload.id)
        stream = store.live_streams.begin(payload.id, job)
    with pytest.raises(Conflict, match="live stream"), storage.transaction() as store:
        store.payloads.delete(payload.id)
    with storage.transaction() as store:
        store.live_streams.end(stream.id, Counts())
        store.payloads.delete(payload.id)
        for table in (PayloadFile, LiveStream, Job, Result, Artifact):
            assert store.session.scalars(sa.select(table)).all() == []


def test_a_log_goes_and_a_study_of_it_keeps_its_file(storage: Storage) -> None:
    with storage.transaction() as store:
        file = pinned(store, "id.csv", b"t,q")
        log, _ = store.logs.add(file, None, {})
        store.studies.add("study", [file], {})
        store.logs.delete(log.id)
    installation = Installation(storage.engine, storage.blobs)
    assert sweep_installation(installation, timedelta(0)).blobs == 0
    assert check(installation, None).sound


def test_nobody_deletes_what_is_another_lab_s(storage: Storage) -> None:
    with storage.transaction() as store:
        study, _ = store.studies.add("study", [pinned(store, "study.yaml", b"s")], {})
        log, _ = store.logs.add(pinned(store, "id.csv", b"l"), None, {})
    other = Installation(storage.engine, storage.blobs).of_lab("other")
    for noun, key in (("studies", study.id), ("logs", log.id)):
        with pytest.raises(NotFound), other.transaction() as store:
            getattr(store, noun).delete(key)


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)  # SQLite's writers take turns
@pytest.mark.parametrize("first", ["share", "delete"])
def test_a_study_is_shared_once_or_gone_whoever_asks_at_once(storage: Storage, first: str) -> None:
    with Installation(storage.engine, storage.blobs).session() as session:
        Accounts(session).found_lab("Here", storage.lab_id)
    with storage.transaction() as store:
        study, _ = store.studies.add("s", [], {})

    def another() -> str:
        try:
            with storage.transaction() as store:
                return store.shares.add(study.id, None).id
        except NotFound:
            return "gone"

    with ThreadPoolExecutor(1) as pool:
        with storage.transaction() as store:
            mine = store.shares.add(study.id, None).id if first == "share" else "gone"
            if first == "delete":
                store.studies.delete(study.id)
            other = pool.submit(another)
            with suppress(TimeoutError):
                other.result(0.5)
        assert other.result(30.0) == mine
