"""A study that is shared: what its readers see, what they do not, and that they see it no longer than they may."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient
from tests.api.people import People

from exogauge.api import access
from exogauge.storage.files import PinnedFile
from exogauge.storage.tables import Artifact, Job, Result, utc_now

V1 = "/api/v1"


@pytest.fixture
def ada(people: People) -> Iterator[TestClient]:
    with people.browser(people.session(people.person("ada@example.org", "north"))) as opened:
        yield opened


@pytest.fixture
def eve(people: People) -> Iterator[TestClient]:
    with people.browser(people.session(people.person("eve@example.org", "south", "admin"))) as opened:
        yield opened


@pytest.fixture
def made(people: People) -> dict[str, dict[str, str]]:
    """Two studies of the north with a job each, which has results."""
    found = {}
    with people.installation.of_lab("north").transaction() as store:
        for name in ("shared", "secret"):
            sha = store.blobs.put(f"of the {name}".encode())
            study, _ = store.studies.add(name, [PinnedFile("study.yaml", sha, 3)], {"logs": []})
            job = Job(kind="evaluate", study_id=study.id, request_hash=name, state="succeeded", finished_at=utc_now())
            store.session.add(job)
            store.session.flush()
            sha = store.blobs.put(b'{"version": 1}')
            store.session.add(Result(job_id=job.id, study_id=study.id, sha256=sha, size=14))
            store.session.add(
                Artifact(job_id=job.id, name="results.json", sha256=sha, size=14, media_type="application/json")
            )
            found[name] = {"study": study.id, "job": job.id}
    return found


def reads(who: TestClient, of: dict[str, str]) -> set[int]:
    paths = (
        f"studies/{of['study']}", f"studies/{of['study']}/files/study.yaml", f"studies/{of['study']}/results",
        f"studies/{of['study']}/models", f"jobs/{of['job']}", f"jobs/{of['job']}/results",
        f"jobs/{of['job']}/artifacts", f"jobs/{of['job']}/artifacts/results.json", f"jobs/{of['job']}/events",
    )  # fmt: skip
    return {who.get(f"{V1}/{path}").status_code for path in paths}


@pytest.mark.slow
@pytest.mark.parametrize("lab", ["south", None])
def test_a_study_is_read_by_whom_it_is_shared_with_until_that_ends(
    lab: str | None, ada: TestClient, eve: TestClient, people: People, made: dict[str, dict[str, str]]
) -> None:
    shared, secret = made["shared"], made["secret"]
    assert reads(eve, shared) == {404}
    share = ada.post(f"{V1}/studies/{shared['study']}/shares", json={"lab": lab})
    assert (share.status_code, share.json()["lab"]) == (201, lab)
    assert ada.post(f"{V1}/studies/{shared['study']}/shares", json={"lab": lab}).json() == share.json()
    assert reads(eve, shared) == {200}
    assert reads(eve, secret) == {404}
    (listed,) = eve.get(f"{V1}/shared").json()["items"]
    assert (listed["study_id"], listed["name"], listed["lab"]) == (shared["study"], "shared", "north")
    assert ada.get(f"{V1}/shared").json()["items"] == []
    assert eve.get(f"{V1}/studies").json()["items"] == []
    third = people.person("wes@example.org", "west")
    with people.browser(people.session(third)) as wes:
        assert reads(wes, shared) == ({404} if lab else {200})
    _, token = people.token("south", "read")
    with people.program(token) as program:
        assert reads(program, shared) == {200}
    assert ada.delete(f"{V1}/studies/{shared['study']}/shares/{share.json()['id']}").status_code == 204
    assert reads(eve, shared) == {404}
    assert eve.get(f"{V1}/shared").json()["items"] == []


def test_who_reads_changes_nothing_and_learns_nothing_of_who_else_may(
    ada: TestClient, eve: TestClient, people: People, made: dict[str, dict[str, str]]
) -> None:
    people.person("wes@example.org", "west")
    study, job = made["shared"]["study"], made["shared"]["job"]
    place = f"{V1}/studies/{study}/shares"
    ada.post(place, json={"lab": "south"})
    other = ada.post(place, json={"lab": "west"}).json()
    for answer in (
        eve.get(place), eve.post(place, json={"lab": "south"}), eve.delete(f"{place}/{other['id']}"),
        eve.delete(f"{V1}/studies/{study}"), eve.post(f"{V1}/jobs/{job}/cancel"), eve.post(f"{V1}/jobs/{job}/retry"),
        eve.post(f"{V1}/jobs", json={"study_id": study}), eve.get(f"{V1}/compare", params={"jobs": [job]}),
    ):  # fmt: skip
        assert answer.status_code == 404, answer.request.url
    assert [each["lab"] for each in ada.get(place).json()["items"]] == ["south", "west"]
    said = [each["said"] for each in audit(people)]
    assert said.count("with south") == said.count("with west") == 1


def audit(people: People) -> list[dict[str, str]]:
    with people.browser(people.session(people.person("chief@example.org", "north", "admin"))) as chief:
        items: list[dict[str, str]] = chief.get(f"{V1}/lab/audit", params={"search": "share"}).json()["items"]
    return items


def test_a_share_is_with_another_lab_that_there_is(
    ada: TestClient, eve: TestClient, made: dict[str, dict[str, str]]
) -> None:
    place = f"{V1}/studies/{made['shared']['study']}/shares"
    for lab in ("nowhere", "north"):
        assert ada.post(place, json={"lab": lab}).status_code == 404
    ada.post(place, json={"lab": "south"})
    assert ada.delete(f"{V1}/studies/{made['shared']['study']}").status_code == 204
    assert eve.get(f"{V1}/shared").json()["items"] == []


def test_events_of_a_shared_job_end_soon_after_the_share(
    ada: TestClient, eve: TestClient, people: People, made: dict[str, dict[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(access, "LOOK_EVERY_S", 0.1)
    study = made["shared"]["study"]
    with people.installation.of_lab("north").transaction() as store:
        job = Job(kind="evaluate", study_id=study, request_hash="waits")
        store.session.add(job)
        store.session.flush()
        key = job.id
    share = ada.post(f"{V1}/studies/{study}/shares", json={"lab": "south"}).json()
    with eve.stream("GET", f"{V1}/jobs/{key}/events") as events:
        lines = events.iter_lines()
        assert next(lines)
        with people.installation.of_lab("north").transaction() as store:
            store.shares.end(study, share["id"])
        assert all("succeeded" not in line for line in lines)
    assert eve.get(f"{V1}/jobs/{key}/events").status_code == 404
