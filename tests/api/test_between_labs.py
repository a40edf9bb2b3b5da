"""One device in several labs: who sees which study of it, and what is said of their agreement."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient
from tests.api.people import People

from exogauge.storage.files import PinnedFile
from exogauge.storage.records import PublishedFile
from exogauge.storage.tables import Artifact, Job, Result, utc_now

V1 = "/api/v1"
RECORD = {"model": "Back strap", "size": "M", "serial": None}
ABOUT = {"title": "t", "creators": [{"name": "x"}], "licence": "CC0-1.0"}


def number(value: float | None, std: float | None, unit: str) -> dict[str, Any]:
    return {"value": value, "std": std, "unit": unit}


def results(
    stiffness: float, std: float | None, *, device: str = "strap", record: dict[str, Any] = RECORD,
    robot: str = "Small", identifiable: bool = True, torque: float = 20.0,
) -> dict[str, Any]:  # fmt: skip
    """results.json by the contract: one band, one joint."""
    band = {
        "device": device, "band": "left", "group": "back", "interval_95": {
            "stiffness_n_per_m": [stiffness - 2, stiffness + 2], "natural_length_m": [0.48, None]},
        "stiffness_n_per_m": number(stiffness, std, "N/m"), "natural_length_m": number(0.5, 0.01, "m"),
        "identifiable": identifiable, "length_identifiable": False,
    }  # fmt: skip
    effort = {**number(torque, 1.0, "N·m"), "approach": "A"}
    support = {
        "device": device, "motion": "bend", "joint": "waist", "unit": "N·m", "main": True, "peak": effort,
        "mean": effort,
    }  # fmt: skip
    return {
        "version": 1, "name": f"Study of {stiffness}", "robot": robot, "scope": {"synthetic": False},
        "configuration": {"devices": [{"device": device, "record": record, "logs": ["worn"]}]},
        "stiffness": [
            {**band, "approach": "B", "headline": False, "stiffness_n_per_m": number(999.0, 1.0, "N/m")},
            {**band, "approach": "A", "headline": True},
        ],
        "support": [support],
    }  # fmt: skip


@pytest.fixture
def ada(people: People) -> Iterator[TestClient]:
    for lab in ("south", "west", "east"):
        people.person(f"{lab}@example.org", lab)
    with people.browser(people.session(people.person("ada@example.org", "north", "viewer"))) as opened:
        yield opened


def evaluated(people: People, lab: str, content: dict[str, Any]) -> tuple[str, str, str]:
    """Study, job, hash of results.json."""
    with people.installation.of_lab(lab).transaction() as store:
        raw = json.dumps(content).encode()
        sha = store.blobs.put(raw)
        study, _ = store.studies.add(content["name"], [PinnedFile("study.yaml", sha, len(raw))], {"logs": []})
        job = Job(kind="evaluate", study_id=study.id, request_hash=sha, state="succeeded", finished_at=utc_now())
        store.session.add(job)
        store.session.flush()
        size = {"sha256": sha, "size": len(raw)}
        store.session.add(Result(job_id=job.id, study_id=study.id, **size))
        store.session.add(Artifact(job_id=job.id, name="results.json", media_type="application/json", **size))
        return study.id, job.id, sha


def share(people: People, lab: str, study: str, with_lab: str | None) -> None:
    with people.installation.of_lab(lab).transaction() as store:
        store.shares.add(study, with_lab)


def publish(people: People, lab: str, made: tuple[str, str, str], follows: str | None = None) -> str:
    study, job, sha = made
    with people.installation.of_lab(lab).transaction() as store:
        file = PublishedFile("results/results.json", sha, 1, "application/json")
        return store.publications.add(study, job, [file], ABOUT, follows).id


def compared(who: TestClient, model: str = "Back strap", size: str | None = "M") -> dict[str, Any]:
    asked = {"model": model} | ({} if size is None else {"size": size})
    answer = who.get(f"{V1}/compare/device", params=asked)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def stiffness_of(found: dict[str, Any]) -> dict[str, Any]:
    quantity: dict[str, Any] = next(each for each in found["quantities"] if each["quantity"] == "stiffness")
    return quantity


def test_own_shared_and_published_studies_stand_side_by_side_and_no_other(ada: TestClient, people: People) -> None:
    evaluated(people, "north", results(200.0, 1.0))
    share(people, "south", evaluated(people, "south", results(206.0, 2.0, robot="Large"))[0], "north")
    publish(people, "west", evaluated(people, "west", results(203.0, 2.0)))
    secret = evaluated(people, "east", results(300.0, 0.1))
    share(people, "east", secret[0], "south")
    found = compared(ada)
    seen = {each["lab"]: (each["seen"], each["study_id"] is not None) for each in found["studies"]}
    assert seen == {"north": ("own", True), "south": ("shared", True), "west": ("published", False)}
    assert found["studies"][0]["bands"][0]["stiffness_interval"] == [201.0, 205.0]
    quantity = stiffness_of(found)
    assert sorted(quantity["values"]) == [200.0, 203.0, 206.0]
    w = [1.0, 0.25, 0.25]
    mean = (200.0 + 0.25 * 203.0 + 0.25 * 206.0) / sum(w)
    assert quantity["found"]["mean"] == pytest.approx(mean)
    q = (200.0 - mean) ** 2 + 0.25 * (203.0 - mean) ** 2 + 0.25 * (206.0 - mean) ** 2
    assert quantity["found"]["q"] == pytest.approx(q)
    assert quantity["found"]["labs"] == 3
    assert quantity["found"]["provisional"]
    torques = {each["of"]: each["found"]["labs"] for each in found["quantities"] if each["quantity"] == "peak_torque"}
    assert torques == {"waist in bend of small": 2, "waist in bend of large": 1}, "other robots feel other torques"
    assert "natural_length" not in {each["quantity"] for each in found["quantities"]}, "no data decide it"
    listed = ada.get(f"{V1}/compare/devices").json()["items"]
    assert listed == [{"model": "Back strap", "size": "M", "labs": 3, "studies": 3}]


def test_one_lab_says_nothing_of_others_however_many_studies_it_has(ada: TestClient, people: People) -> None:
    evaluated(people, "north", results(200.0, 1.0))
    evaluated(people, "north", results(260.0, 1.0))
    quantity = stiffness_of(compared(ada))
    assert (quantity["values"], quantity["found"]["verdict"], quantity["found"]["mean"]) == ([260.0], "undecided", None)


def test_a_value_that_no_data_decide_or_without_a_doubt_does_not_count(ada: TestClient, people: People) -> None:
    evaluated(people, "north", results(200.0, 1.0))
    evaluated(people, "north", results(900.0, 1.0, identifiable=False))
    share(people, "south", evaluated(people, "south", results(207.0, None))[0], None)
    found = compared(ada)
    assert len(found["studies"]) == 3
    assert stiffness_of(found)["values"] == [200.0]


def test_what_is_revoked_no_longer_shared_or_an_older_version_is_not_there(ada: TestClient, people: People) -> None:
    made = evaluated(people, "west", results(203.0, 2.0))
    first = publish(people, "west", made)
    publish(people, "west", evaluated(people, "west", results(204.0, 2.0)), first)
    assert [each["study"] for each in compared(ada)["studies"]] == ["Study of 204.0"]
    gone = publish(people, "south", evaluated(people, "south", results(208.0, 2.0)))
    assert len(compared(ada)["studies"]) == 2
    with people.installation.of_lab("south").transaction() as store:
        store.publications.revoke(gone, "r")
    assert [each["lab"] for each in compared(ada)["studies"]] == ["west"]


def test_what_one_sees_anyway_and_was_published_is_there_once(ada: TestClient, people: People) -> None:
    made = evaluated(people, "north", results(200.0, 1.0))
    publish(people, "north", made)
    (only,) = compared(ada)["studies"]
    assert (only["seen"], only["study_id"]) == ("own", made[0])
    assert "/published/" in only["published"]


def test_devices_are_the_same_by_model_and_size_and_without_a_model_by_name(ada: TestClient, people: People) -> None:
    nothing = {"model": None, "size": None}
    evaluated(people, "north", results(200.0, 1.0, device="North's"))
    evaluated(people, "north", results(201.0, 1.0, record={"model": " back  STRAP", "size": "m"}))
    evaluated(people, "north", results(202.0, 1.0, record={"model": "Back strap", "size": "L"}))
    evaluated(people, "north", results(203.0, 1.0, device="Back strap", record=nothing))
    assert len(compared(ada)["studies"]) == 2
    assert [each["study"] for each in compared(ada, size="L")["studies"]] == ["Study of 202.0"]
    assert [each["study"] for each in compared(ada, size=None)["studies"]] == ["Study of 203.0"]
    assert ada.get(f"{V1}/compare/device", params={"model": "Front strap"}).status_code == 404
