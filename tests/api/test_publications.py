"""What a lab publishes: anybody reads it, it stays as it was, and what is revoked is gone but for its record."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from typing import Any

import pytest
import sqlalchemy as sa
from datacite import schema45
from fastapi.testclient import TestClient
from sqlalchemy.exc import DatabaseError
from tests.api.people import ORIGIN, People

from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import PublishedFile
from exogauge.storage.sweeping import sweep_installation
from exogauge.storage.tables import Artifact, Job, Publication, Result, utc_now

V1 = "/api/v1"
RESULTS = json.dumps({"version": 1, "name": "Bend"}).encode()
REPORT = b"<h1>Bend</h1>"
ABOUT = {
    "title": "A bend in a suit",
    "creators": [{"name": "Lovelace, Ada", "orcid": "0000-0001-5109-3700", "affiliation": "North"}, {"name": "Bob"}],
    "description": "What the suit does.",
    "keywords": ["exoskeleton"],
    "licence": "CC0-1.0",
}


@pytest.fixture
def ada(people: People) -> Iterator[TestClient]:
    with people.browser(people.session(people.person("ada@example.org", "north"))) as opened:
        yield opened


@pytest.fixture
def nobody(people: People) -> Iterator[TestClient]:
    with people.browser() as opened:
        yield opened


@pytest.fixture
def study(people: People) -> str:
    """Of the north, with a job that found something, and one that has not."""
    with people.installation.of_lab("north").transaction() as store:
        raw = store.blobs.put(b"t,q\n0,0\n")
        made, _ = store.studies.add("Bend", [PinnedFile("logs/a.csv", raw, 8)], {"logs": []})
        job = Job(kind="evaluate", study_id=made.id, request_hash="h", state="succeeded", finished_at=utc_now())
        store.session.add_all([job, Job(kind="evaluate", study_id=made.id, request_hash="i", state="failed")])
        store.session.flush()
        sha = store.blobs.put(RESULTS)
        store.session.add(Result(job_id=job.id, study_id=made.id, sha256=sha, size=len(RESULTS)))
        for name, content, kind in (
            ("results.json", RESULTS, "application/json"),
            ("report.html", REPORT, "text/html"),
        ):
            row = Artifact(
                job_id=job.id, name=name, sha256=store.blobs.put(content), size=len(content), media_type=kind
            )
            store.session.add(row)
    return made.id


Publish = Callable[..., dict[str, Any]]


@pytest.fixture
def publish(ada: TestClient, study: str) -> Publish:
    def ask(**more: Any) -> dict[str, Any]:
        answer = ada.post(f"{V1}/studies/{study}/publications", json=ABOUT | more)
        assert answer.status_code == 201, answer.text
        found: dict[str, Any] = answer.json()
        return found

    return ask


def test_anybody_reads_what_was_published_and_can_check_every_byte(publish: Publish, nobody: TestClient) -> None:
    made = publish()
    assert made["url"] == f"{ORIGIN}/published/{made['key']}"
    found = nobody.get(f"{V1}/published/{made['key']}").json()
    assert {each["path"] for each in found["files"]} == {"results/results.json", "results/report.html"}
    for each in found["files"]:
        got = nobody.get(f"{V1}/published/{made['key']}/files/{each['path']}")
        assert hashlib.sha256(got.content).hexdigest() == each["sha256"]
    sums = nobody.get(f"{V1}/published/{made['key']}/SHA256SUMS").text
    assert sums.splitlines()[1] == f"{hashlib.sha256(RESULTS).hexdigest()}  results/results.json"
    lines = sorted(f"{each['path']}\0{each['sha256']}\n" for each in found["files"])
    assert found["content_hash"] == hashlib.sha256("".join(lines).encode()).hexdigest()
    assert found["lab"] == "north"
    assert found["citation"].startswith("Lovelace, Ada; Bob (20")
    shown = {key: value for key, value in found.items() if key.endswith("_id") or key == "id"}
    assert shown == {}, "rows of the lab are its own"
    assert nobody.get(f"{V1}/published/{made['key']}/files/study/logs/a.csv").status_code == 404
    assert nobody.get(f"{V1}/published/0000000000").status_code == 404
    assert nobody.get(f"{V1}/publications").status_code == 401
    assert nobody.post(f"{V1}/publications/{made['id']}/revoke", json={"reason": "x"}).status_code == 401


def test_the_same_again_is_what_stands(publish: Publish, ada: TestClient, people: People, study: str) -> None:
    def again(**more: Any) -> tuple[int, str]:
        answer = ada.post(f"{V1}/studies/{study}/publications", json=ABOUT | more)
        return answer.status_code, answer.json()["id"]

    first = publish()["id"]
    assert again() == (200, first)
    assert again(creators=[ABOUT["creators"][0], {"name": "Bob", "orcid": None}]) == (200, first)  # said otherwise
    others = [publish(inputs=True)["id"], publish(title="Another")["id"], publish(keywords=[])["id"]]
    assert len({first, *others}) == 4
    second = publish(follows=first)["id"]  # a version of its own, though it says the same
    assert (again(follows=first), again(follows=second), again()) == ((200, second), (200, second), (200, first))
    with people.installation.of_lab("north").reading() as store:
        told = [each.subject_id for each in store.audit.page(None, 100, "publish").items]
    assert sorted(told) == sorted([first, second, *others])  # nothing happened again
    assert ada.post(f"{V1}/publications/{first}/revoke", json={"reason": "wrong"}).status_code == 200
    status, anew = again()
    assert (status, anew in (first, second)) == (201, False)


def test_two_that_publish_the_same_at_once_have_one(people: People, study: str) -> None:
    storage, together = people.installation.of_lab("north"), threading.Barrier(2)
    with storage.reading() as store:
        job = store.results.of_study(study).job_id
        files = [
            PublishedFile(f"results/{each.name}", each.sha256, each.size, each.media_type)
            for each in store.results.artifacts(job)
        ]

    def ask() -> str:
        together.wait()
        with storage.transaction() as store:
            stands = store.publications.standing(study, job, files, ABOUT)
            return (stands or store.publications.add(study, job, files, ABOUT)).id

    with ThreadPoolExecutor(2) as pool:
        first, other = (each.result() for each in [pool.submit(ask), pool.submit(ask)])
    assert first == other


def test_inputs_are_published_where_that_is_asked_for(publish: Publish, nobody: TestClient) -> None:
    made = publish(inputs=True)
    assert nobody.get(f"{V1}/published/{made['key']}/files/study/logs/a.csv").content == b"t,q\n0,0\n"


@pytest.mark.parametrize("doi", [None, "10.5281/zenodo.1"])
def test_its_metadata_are_those_that_datacite_asks_for(publish: Publish, nobody: TestClient, doi: str | None) -> None:
    first = publish(doi=doi)
    second = publish(follows=first["id"])
    said = [nobody.get(f"{V1}/published/{each['key']}/datacite").json() for each in (first, second)]
    for each in said:
        schema45.validator.validate(each)
    assert (said[0].get("doi"), said[0]["url"]) == (doi, first["url"])
    assert [(each["version"], [of["relationType"] for of in each["relatedIdentifiers"]]) for each in said] == [
        ("1", ["IsPreviousVersionOf"]), ("2", ["IsNewVersionOf"]),
    ]  # fmt: skip
    assert said[1]["relatedIdentifiers"][0]["relatedIdentifier"] == (doi or first["url"])
    versions = nobody.get(f"{V1}/published/{first['key']}").json()["versions"]
    assert [each["key"] for each in versions] == [first["key"], second["key"]]


def test_it_outlives_its_study_and_a_sweep(
    publish: Publish, ada: TestClient, nobody: TestClient, people: People, study: str
) -> None:
    made = publish()
    with people.installation.session() as session:  # the one that failed is over
        session.execute(sa.update(Job).where(Job.state == "queued").values(state="failed"))
    assert ada.delete(f"{V1}/studies/{study}").status_code == 204
    for _ in range(3):
        sweep_installation(people.installation, waited=timedelta(0))
    assert nobody.get(f"{V1}/published/{made['key']}/files/results/report.html").content == REPORT
    assert [each["key"] for each in ada.get(f"{V1}/publications?study_id={study}").json()["items"]] == [made["key"]]


def test_what_was_revoked_is_gone_and_its_record_stays(
    publish: Publish, ada: TestClient, nobody: TestClient, people: People, study: str
) -> None:
    made = publish()
    path = f"{V1}/published/{made['key']}"
    assert ada.post(f"{V1}/publications/{made['id']}/revoke", json={"reason": "a wrong log"}).status_code == 200
    gone = nobody.get(f"{path}/files/results/results.json")
    assert (gone.status_code, gone.json()["type"]) == (410, "urn:exogauge:problem:gone")
    found = nobody.get(path).json()
    assert found["revoked_because"] == "a wrong log"
    assert found["files"] == made["files"]
    assert "Withdrawn" in [each["dateType"] for each in nobody.get(f"{path}/datacite").json()["dates"]]
    again = ada.post(f"{V1}/publications/{made['id']}/revoke", json={"reason": "another"}).json()
    assert (again["revoked_at"], again["revoked_because"]) == (found["revoked_at"], "a wrong log")
    assert ada.delete(f"{V1}/studies/{study}").status_code == 204
    for _ in range(3):
        sweep_installation(people.installation, waited=timedelta(0))
    assert not people.installation.blobs.exists(made["files"][0]["sha256"]), "nothing needs its bytes any more"


def test_the_database_refuses_to_change_a_publication(publish: Publish, people: People) -> None:
    made = publish()
    for change in (
        sa.update(Publication).values(about={}), sa.update(Publication).values(content_hash="0" * 64),
        sa.delete(Publication), sa.text("UPDATE publication_files SET size = 0"),
    ):  # fmt: skip
        with pytest.raises(DatabaseError, match="can be revoked"), people.installation.session() as session:
            session.execute(change)
    with people.installation.of_lab("north").transaction() as store:
        store.publications.revoke(made["id"], "r")
    with pytest.raises(DatabaseError, match="can be revoked"), people.installation.session() as session:
        session.execute(sa.update(Publication).values(revoked_at=None))


def test_only_what_an_evaluation_of_this_study_found_is_published(
    ada: TestClient, study: str, people: People, publish: Publish
) -> None:
    with people.installation.of_lab("north").transaction() as store:
        other, _ = store.studies.add("Other", [PinnedFile("x", store.blobs.put(b"x"), 1)], {})
        failed = store.session.scalar(sa.select(Job.id).where(Job.state == "failed"))
    job = publish()["job_id"]
    ask = f"{V1}/studies/{{}}/publications"
    assert ada.post(ask.format(study), json=ABOUT | {"job_id": failed}).status_code == 404
    assert ada.post(ask.format(other.id), json=ABOUT).status_code == 404
    assert ada.post(ask.format(other.id), json=ABOUT | {"job_id": job}).status_code == 404
    for wrong in ({"doi": "doi:10.1/x"}, {"creators": []}, {"licence": "mine"}, {"title": " "}):
        assert ada.post(ask.format(study), json=ABOUT | wrong).status_code == 422, wrong


def test_the_public_address_is_the_one_that_is_set(publish: Publish, people: People) -> None:
    settings: Settings = people.app.state.settings
    people.app.state.settings = settings.model_copy(update={"public_url": "https://data.example/exo"})
    made = publish()
    assert made["url"] == f"https://data.example/exo/published/{made['key']}"
