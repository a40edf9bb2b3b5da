"""What the store promises of payloads, of their jobs and results, and of live streams."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from exogauge.errors import NotFound
from exogauge.storage.files import PinnedFile
from exogauge.storage.live_streams import Counts
from exogauge.storage.store import Storage, Store
from exogauge.storage.tables import Artifact, Job, Result

pytestmark = pytest.mark.usefixtures("without_bytes")

FILES = (PinnedFile("logs/postures.csv", "1" * 64, 10), PinnedFile("payload.yaml", "2" * 64, 20))
OTHER = (FILES[0], PinnedFile("payload.yaml", "3" * 64, 21))


def test_a_payload_is_versioned_by_name_and_found_by_content(storage: Storage) -> None:
    with storage.transaction() as store:
        first, new = store.payloads.add("Door", FILES, {"name": "Door"})
        second, _ = store.payloads.add("Door", OTHER, {})
        again, again_new = store.payloads.add("Door", FILES, {})
    assert (new, again_new, again.id, first.version, second.version) == (True, False, first.id, 1, 2)
    with storage.reading() as store:
        assert store.payloads.files(second.id) == OTHER
        assert store.payloads.file(first.id, "payload.yaml") == FILES[1]
        assert [each.id for each in store.payloads.page(None, 9, name="Door").items] == [second.id, first.id]
        assert [each.id for each in store.payloads.page(None, 9, search="DOOR").items] == [second.id, first.id]
        for key in ("", "x", "0" * 36, "\0"):
            with pytest.raises(NotFound):
                store.payloads.get(key)


def test_a_payload_is_laid_out_as_it_was_handed_in(storage: Storage, tmp_path: Path) -> None:
    contents = {"payload.yaml": b"version: 1", "logs/a.csv": b"t\n0\n"}
    files = [PinnedFile(path, storage.blobs.put(content), len(content)) for path, content in contents.items()]
    with storage.transaction() as store:
        payload, _ = store.payloads.add("p", files, {})
        store.payloads.write_to(payload.id, tmp_path / "out")
    assert {path: (tmp_path / "out" / path).read_bytes() for path in contents} == contents


def test_another_lab_sees_neither_payloads_nor_streams(storage: Storage) -> None:
    with storage.transaction() as store:
        payload = add(store)
        stream = store.live_streams.begin(payload)
    other = Storage(storage.engine, storage.blobs, "other")
    with other.transaction() as store:
        assert store.payloads.page(None, 9).items == ()
        assert store.live_streams.page(None, 9).items == ()
        with pytest.raises(NotFound):
            store.live_streams.begin(payload)
        with pytest.raises(NotFound):
            store.live_streams.get(stream.id)
        assert not store.live_streams.end(stream.id, Counts())


@pytest.mark.parametrize("owners", [{}, {"study_id": "both", "payload_id": "both"}])
def test_a_job_and_its_result_are_of_exactly_one_thing(storage: Storage, owners: dict[str, str]) -> None:
    with storage.transaction() as store:
        study = store.studies.add("s", FILES, {})[0].id
        keys = {"study_id": study, "payload_id": add(store)}
        job = Job(kind="payload", request_hash="a", payload_id=keys["payload_id"])
        store.session.add(job)
        store.session.flush()
        key = job.id
    theirs = {name: keys[name] for name in owners}
    for row in (
        Job(kind="payload", request_hash="b", **theirs),
        Result(job_id=key, sha256="4" * 64, size=1, **theirs),
    ):
        with pytest.raises(IntegrityError), storage.transaction() as store:
            store.session.add(row)


def test_the_latest_result_of_a_payload_is_no_plan_and_not_a_study_s(storage: Storage) -> None:
    now = datetime.now(UTC)
    with storage.transaction() as store:
        payload, study = add(store), store.studies.add("s", FILES, {})[0].id
        for k, (kind, file, owner) in enumerate([
            ("payload", "results.json", {"payload_id": payload}),
            ("payload_plan", "plan.json", {"payload_id": payload}),
            ("evaluate", "results.json", {"study_id": study}),
        ]):  # fmt: skip
            made = now + timedelta(seconds=k)
            job = Job(kind=kind, request_hash=str(k), state="succeeded", created_at=made, **owner)
            store.session.add(job)
            store.session.flush()
            store.session.add(Result(job_id=job.id, sha256=f"{k:064}", size=1, **owner))
            store.session.add(Artifact(job_id=job.id, name=file, sha256=f"{k:064}", size=1, media_type="text/plain"))
    with storage.reading() as store:
        assert store.results.of_payload(payload).sha256 == f"{0:064}"
        assert store.results.of_study(study).sha256 == f"{2:064}"
        for noun, key, kind in (("payload", payload, "payload"), ("study", study, "evaluate")):
            assert {key: job.kind for key, job in store.jobs.latest(noun, [key]).items()} == {key: kind}
        assert [job.kind for job in store.jobs.page(None, 9, payload_id=payload).items] == ["payload_plan", "payload"]
        assert [job.kind for job in store.jobs.page(None, 9, payload_id=payload, kind="payload").items] == ["payload"]
        with pytest.raises(NotFound, match="of a payload"):
            store.study_of(store.jobs.page(None, 1, payload_id=payload).items[0])


def test_a_live_stream_counts_while_it_is_open_and_ends_once(storage: Storage) -> None:
    with storage.transaction() as store:
        payload = add(store)
        stream = store.live_streams.begin(payload, summary={"rate_hz": 500})
    assert (stream.state, stream.samples, stream.last_sequence, stream.ended_at) == ("open", 0, None, None)
    with storage.transaction() as store:
        assert store.live_streams.count(stream.id, Counts(500, 2, 1, 501))
    with storage.transaction() as store:
        assert store.live_streams.end(stream.id, Counts(900, 3, 1, 902), raw=("5" * 64, 7200))
    with storage.transaction() as store:
        assert not store.live_streams.count(stream.id, Counts(901, 3, 1, 903))
        assert not store.live_streams.end(stream.id, Counts(), "lost")
    with storage.reading() as store:
        kept = store.live_streams.get(stream.id)
        assert store.live_streams.page(None, 9, payload_id=payload).items == (kept,)
    assert (kept.state, kept.samples, kept.dropped, kept.late, kept.last_sequence) == ("ended", 900, 3, 1, 902)
    assert (kept.sha256, kept.size, kept.summary) == ("5" * 64, 7200, {"rate_hz": 500})
    assert kept.ended_at is not None
    assert kept.ended_at >= kept.started_at


def test_streams_go_with_their_payload_and_keep_the_job_that_compensated_them(storage: Storage) -> None:
    with storage.transaction() as store:
        payload = add(store)
        job = Job(kind="payload", request_hash="a", payload_id=payload)
        store.session.add(job)
        store.session.flush()
        stream = store.live_streams.begin(payload, job.id).id
        assert store.live_streams.get(stream).job_id == job.id
    with pytest.raises(IntegrityError), storage.transaction() as store:
        store.session.execute(sa.text("DELETE FROM jobs"))
    with storage.transaction() as store:
        assert store.live_streams.get(stream).job_id is not None
        store.session.execute(sa.text("DELETE FROM payloads"))
        assert store.session.scalar(sa.select(sa.func.count()).select_from(Job)) == 0
        with pytest.raises(NotFound):
            store.live_streams.get(stream)


def add(store: Store) -> str:
    return store.payloads.add("Door", FILES, {})[0].id
