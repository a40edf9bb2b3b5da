"""What a lab's admin is told of what goes by age: it is what then goes, and of that lab alone."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient
from tests.api.people import People

from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.retention import Ages, retire
from exogauge.storage.tables import Job, Log, Plan, Publication, Study, utc_now

V1 = "/api/v1"
DAY = timedelta(days=1)
AGES = {"studies_kept_days": {"north": 10.0}, "unused_logs_kept_days": 20.0}


@pytest.fixture
def aged(people: People) -> Iterator[TestClient]:
    """An admin of north, at a server whose settings name ages."""
    people.app.state.settings = people.app.state.settings.model_copy(update=AGES)
    key = people.session(people.person("ada@example.org", "north", "admin"))
    with people.browser(key) as opened:
        yield opened


def study(people: People, lab: str, name: str, age: timedelta, job: timedelta | None = None) -> str:
    """job: how long ago one of it ended."""
    with people.installation.of_lab(lab).transaction() as store:
        blob = store.blobs.put(f"{lab} {name}".encode())
        made, _ = store.studies.add(name, [PinnedFile("study.yaml", blob, 1)], {})
        store.session.execute(sa.update(Study).where(Study.id == made.id).values(created_at=utc_now() - age))
        if job is not None:
            ended = {"state": "succeeded", "finished_at": utc_now() - job, "log": "words"}
            store.session.add(Job(kind="evaluate", study_id=made.id, request_hash=made.id[:32], **ended))
    return made.id


def filled(people: People) -> dict[str, str]:
    ids = {name: study(people, "north", name, age, job) for name, age, job in (
        ("old", 15 * DAY, 11 * DAY), ("next", 12 * DAY, 7 * DAY), ("unworked", 9 * DAY, None),
        ("published", 99 * DAY, None), ("planned", 99 * DAY, None), ("busy", 99 * DAY, None),
    )}  # fmt: skip
    study(people, "south", "another lab's", 99 * DAY)
    with people.installation.of_lab("north").transaction() as store:
        robot, _ = store.robots.add("r", [PinnedFile("robot.yaml", store.blobs.put(b"name: r\n"), 8)], {})
        store.session.add(Plan(name="p", content_hash="0" * 64, summary={}, robot_id=robot.id, study_id=ids["planned"]))
        store.session.add(Job(kind="evaluate", study_id=ids["busy"], request_hash="b", state="running"))
        named = {"study_id": ids["published"], "job_id": ids["published"], "series_id": ids["published"]}
        store.session.add(
            Publication(
                key="k" * 16, version=1, content_hash="0" * 64, manifest=[], about={}, lab_name="north", **named
            )
        )
        store.logs.add(PinnedFile("unused.csv", store.blobs.put(b"unused"), 6), None, {})
        store.session.execute(sa.update(Log).values(created_at=utc_now() - 5 * DAY))
    return ids


def days_from_now(at: str | None) -> float | None:
    return None if at is None else round((datetime.fromisoformat(at) - utc_now()) / DAY, 2)


def by_what(told: Any) -> dict[str, tuple[Any, ...]]:
    return {
        each["what"]: (each["of"], each["stay"], each["kept_days"], days_from_now(each["next_at"]))
        for each in told["kinds"]
    }


def test_an_admin_is_told_what_goes_when_and_that_is_what_goes(
    aged: TestClient, people: People, settings: Settings
) -> None:
    ids = filled(people)
    told = aged.get(f"{V1}/lab/retention").json()
    found = by_what(told)
    assert found["studies"] == (3, 3, 10.0, -1.0)
    assert found["unused_logs"] == (1, 0, 20.0, 15.0)
    assert found["job_logs"] == (2, 1, None, None)
    assert found["audit"][2:] == (3650.0, 3650.0)
    going = [(each["id"], days_from_now(each["goes_at"])) for each in told["studies"]]
    assert going == [(ids["old"], -1.0), (ids["unworked"], 1.0), (ids["next"], 3.0)]
    assert (told["lab_id"], told["kinds"][0]["setting"]) == ("north", "EXOGAUGE_STUDIES_KEPT_DAYS")
    assert retire(people.installation, Ages.of(settings.model_copy(update=AGES))).studies == 1
    left = aged.get(f"{V1}/lab/retention").json()
    assert [each["id"] for each in left["studies"]] == [ids["unworked"], ids["next"]]
    assert by_what(left)["studies"] == (2, 3, 10.0, 1.0)


def test_where_no_age_is_named_all_is_said_to_stay(people: People) -> None:
    filled(people)
    key = people.session(people.person("ada@example.org", "north", "admin"))
    with people.browser(key) as ada:
        told = ada.get(f"{V1}/lab/retention").json()
    assert by_what(told)["studies"] == (3, 3, None, None)
    assert told["studies"] == []
    with people.browser(people.session(people.person("bob@example.org", "north", "member"))) as bob:
        assert bob.get(f"{V1}/lab/retention").status_code == 403
