"""What is too much is refused with the time after which it works again, and others are served meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from datetime import timedelta
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient

from exogauge.api.app import create_app
from exogauge.api.rate import Buckets, place_of
from exogauge.errors import QuotaFull, TooMany, Unavailable
from exogauge.sandbox.asking import Places, at_once
from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.quotas import Quotas, cpu_s_of, refuse_jobs
from exogauge.storage.store import Storage, Store
from exogauge.storage.tables import Job, new_id

V1 = "/api/v1"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.fixture
def served(settings: Settings) -> Iterator[Callable[..., TestClient]]:
    """A service with other settings."""
    opened = list[TestClient]()

    def serve(**other: Any) -> TestClient:
        opened.append(TestClient(create_app(settings.model_copy(update=other)), base_url="http://127.0.0.1"))
        opened[-1].__enter__()
        return opened[-1]

    yield serve
    for each in opened:
        each.__exit__(None, None, None)
    at_once.bound(None)


@on_sqlite
def test_who_asks_too_often_is_told_when_to_come_again(served: Callable[..., TestClient]) -> None:
    client = served(requests_per_s=0.5)  # five at once, then one in two seconds
    answers = [client.get(f"{V1}/studies") for _ in range(7)]
    assert [each.status_code for each in answers] == [200] * 5 + [429] * 2
    assert answers[-1].headers["content-type"] == "application/problem+json"
    assert 1 <= int(answers[-1].headers["retry-after"]) <= 2
    assert client.get("/healthz").status_code == 200


def test_a_bucket_fills_as_time_goes_on_and_is_each_address_own() -> None:
    now = [0.0]
    buckets = Buckets(2.0, lambda: now[0])
    assert [buckets.wait_s("a") for _ in range(20)] == [0.0] * 20
    assert buckets.wait_s("a") == pytest.approx(0.5)
    assert buckets.wait_s("b") == 0.0
    now[0] = 0.5
    assert buckets.wait_s("a") == 0.0
    assert buckets.wait_s("a") > 0.0
    now[0] = 1e6
    assert [buckets.wait_s("a") for _ in range(21)].count(0.0) == 20


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("2606:4700::1", "2606:4700::ffff:2", True),
        ("2606:4700:0:1::1", "2606:4700::1", False),
        ("fe80::1%eth0", "fe80::2", True),
        ("::ffff:1.2.3.4", "::ffff:1.2.3.5", False),
        ("1.2.3.4", "1.2.3.5", False),
        ("1.2.3.4", "::ffff:1.2.3.4", True),
        ("testclient", "testclient", True),
        ("a:b", "a:c", False),
    ],
)
def test_whoever_has_a_network_of_ipv6_is_one(one: str, other: str, same: bool) -> None:
    assert (place_of(one) == place_of(other)) is same


def test_as_many_are_read_at_once_as_may_and_the_next_is_sent_away() -> None:
    places, entered, leave = Places(), threading.Semaphore(0), threading.Event()
    places.bound(2, wait_s=0.05)

    def read() -> None:
        with places.place("log"):
            entered.release()
            leave.wait(30)

    with ThreadPoolExecutor(2) as pool:
        running = [pool.submit(read) for _ in range(2)]
        for _ in running:
            assert entered.acquire(timeout=30)
        with pytest.raises(Unavailable, match="too many files"), places.place("log"):
            raise AssertionError
        leave.set()
        for each in running:
            each.result()
    with places.place("log"):
        pass


@pytest.mark.slow
@on_sqlite
def test_an_upload_that_finds_no_reader_is_503_and_right_a_moment_later(
    served: Callable[..., TestClient], study_files: Mapping[str, bytes], pack: Callable[[Mapping[str, bytes]], bytes]
) -> None:
    client = served()
    at_once.bound(1, wait_s=0.05)
    with at_once.place("log"):
        refused = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))})
        assert (refused.status_code, refused.headers["retry-after"]) == (503, "2")
        assert client.get(f"{V1}/studies").status_code == 200
    assert client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))}).status_code == 201


@on_sqlite
def test_a_lab_keeps_no_more_than_it_may_and_has_room_again_when_it_deletes(
    served: Callable[..., TestClient], unchecked: None, study_files: Mapping[str, bytes],
    pack: Callable[[Mapping[str, bytes]], bytes],
) -> None:  # fmt: skip
    size = sum(map(len, study_files.values()))
    client = served(lab_bytes=int(1.5 * size))
    first = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))})
    assert first.status_code == 201
    more = {**study_files, "study.yaml": study_files["study.yaml"] + b"\n# another\n"}
    refused = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(more))})
    assert (refused.status_code, refused.json()["type"]) == (507, "urn:exogauge:problem:quota-full")
    assert "retry-after" in refused.headers
    tus = {"Tus-Resumable": "1.0.0", "Upload-Length": str(size)}
    assert client.post(f"{V1}/uploads", headers=tus).status_code == 507
    assert client.delete(f"{V1}/studies/{first.json()['id']}").status_code == 204
    assert client.post(f"{V1}/uploads", headers=tus).status_code == 201
    assert client.post(f"{V1}/uploads", headers=tus).status_code == 507  # beside the one that is on its way
    assert client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(more))}).status_code == 201


@on_sqlite
def test_a_full_lab_hands_in_again_what_it_has(
    served: Callable[..., TestClient], unchecked: None, study_files: Mapping[str, bytes],
    pack: Callable[[Mapping[str, bytes]], bytes],
) -> None:  # fmt: skip
    client = served(lab_bytes=sum(map(len, study_files.values())))
    answers = [client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))}) for _ in range(2)]
    assert [each.status_code for each in answers] == [201, 200]
    more = {**study_files, "study.yaml": study_files["study.yaml"] + b"\n# another\n"}
    assert client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(more))}).status_code == 507


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)  # SQLite's writers take turns
@pytest.mark.parametrize("of", ["bytes", "uploads", "jobs"])
def test_who_adds_at_once_with_another_has_no_more_than_both_may(
    storage: Storage, without_bytes: None, of: str
) -> None:
    limited = replace(storage, quotas=Quotas(bytes=10, jobs=1))
    with storage.transaction() as store:
        study, _ = store.studies.add("jobs", [PinnedFile("study.yaml", "3" * 64, 0)], {})

    def add(store: Store, number: int) -> None:
        if of == "bytes":
            store.studies.add("s", [PinnedFile("study.yaml", str(number) * 64, 6)], {})
            store.refuse_bytes(0)
        elif of == "uploads":
            store.uploads.add(new_id(), "u", 6, timedelta(days=1))
            store.refuse_bytes(0, coming=True)
        else:
            refuse_jobs(store.lab, store.quotas)
            store.session.add(Job(kind="k", study_id=study.id, request_hash=str(number)))

    def another() -> str:
        try:
            with limited.transaction() as store:
                add(store, 2)
        except (QuotaFull, TooMany):
            return "refused"
        return "let in"

    with ThreadPoolExecutor(1) as pool:
        with limited.transaction() as store:
            add(store, 1)
            store.session.flush()
            other = pool.submit(another)
            with suppress(TimeoutError):
                other.result(1.0)
        assert other.result(30.0) == "refused"


@on_sqlite
def test_a_lab_has_no_more_jobs_than_it_may_and_others_are_not_held_up(
    served: Callable[..., TestClient], unchecked: None, study_files: Mapping[str, bytes],
    pack: Callable[[Mapping[str, bytes]], bytes],
) -> None:  # fmt: skip
    client = served(lab_jobs=1)
    study = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))}).json()["id"]
    first = client.post(f"{V1}/jobs", json={"study_id": study})
    assert first.status_code == 202
    assert client.post(f"{V1}/jobs", json={"study_id": study}).status_code == 200  # the same job is no further one
    other = {"study_id": study, "kind": "support"}
    refused = client.post(f"{V1}/jobs", json=other)
    assert (refused.status_code, refused.headers["retry-after"]) == (429, "60")
    client.post(f"{V1}/jobs/{first.json()['id']}/cancel")
    assert client.post(f"{V1}/jobs", json=other).status_code == 202


def test_cpu_seconds_of_the_last_day_count(storage: Storage, without_bytes: None) -> None:
    from exogauge.storage.database import database_now

    with storage.transaction() as store:
        now = database_now(store.session)
        study, _ = store.studies.add("s", [PinnedFile("study.yaml", "1" * 64, 1)], {})
        for hours, used in ((1, 10.0), (30, 500.0)):
            when = now - timedelta(hours=hours)
            job = Job(kind="k", study_id=study.id, request_hash=str(hours), state="failed", cpu_s=used)
            job.started_at = job.finished_at = when
            store.session.add(job)
    with storage.reading() as store:
        assert cpu_s_of(store.lab) == 10.0
        refuse_jobs(store.lab, Quotas(cpu_s_per_day=11.0))
        with pytest.raises(TooMany, match="10 of 10 CPU seconds"):
            refuse_jobs(store.lab, Quotas(cpu_s_per_day=10.0))
        refuse_jobs(replace(store.lab, lab_id="other"), Quotas(cpu_s_per_day=1.0))
        assert store.session.scalar(sa.select(sa.func.count(Job.id))) == 2
