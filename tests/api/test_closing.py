"""A lab that is closed: nobody comes in, it can be opened again for a while, then all goes but what others cite."""

from __future__ import annotations

import json
from collections.abc import Iterator
from datetime import timedelta
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient
from tests.api.people import People

from exogauge.cli import main
from exogauge.errors import Conflict, NotFound
from exogauge.settings import Settings
from exogauge.storage.account_tables import LabRow
from exogauge.storage.closing import STAYS, close_lab, due_labs, remove_lab, reopen_lab
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import PublishedFile
from exogauge.storage.sweeping import sweep_installation
from exogauge.storage.tables import Artifact, AuditEntry, Base, Job, Result, utc_now
from exogauge.upkeep.hourly import CLOSED, Housekeeping

V1 = "/api/v1"


@pytest.fixture
def ada(people: People) -> Iterator[TestClient]:
    with people.browser(people.session(people.person("ada@example.org", "north", "admin"))) as opened:
        yield opened


@pytest.fixture
def eve(people: People) -> Iterator[TestClient]:
    with people.browser(people.session(people.person("eve@example.org", "south", "admin"))) as opened:
        yield opened


@pytest.fixture
def north(people: People, ada: TestClient, eve: TestClient) -> dict[str, str]:
    """It has something of most sorts, and shares and publishes; the south has the same bytes."""
    with people.installation.of_lab("south").transaction() as store:
        store.studies.add("South's", [PinnedFile("x", store.blobs.put(b"of both"), 7)], {})
    with people.installation.of_lab("north").transaction() as store:
        both, own, raw = (store.blobs.put(each) for each in (b"of both", b"of the north", json.dumps({}).encode()))
        study, _ = store.studies.add("Bend", [PinnedFile("x", both, 7), PinnedFile("y", own, 12)], {"logs": []})
        job = Job(kind="evaluate", study_id=study.id, request_hash="h", state="succeeded", finished_at=utc_now())
        waiting = Job(kind="evaluate", study_id=study.id, request_hash="i")
        store.session.add_all([job, waiting])
        store.session.flush()
        store.session.add(Result(job_id=job.id, study_id=study.id, sha256=raw, size=2))
        store.session.add(
            Artifact(job_id=job.id, name="results.json", sha256=raw, size=2, media_type="application/json")
        )
        file = PublishedFile("results/results.json", raw, 2, "application/json")
        about = {"title": "t", "creators": [{"name": "x"}], "licence": "CC0-1.0"}
        publication = store.publications.add(study.id, job.id, [file], about)
        store.shares.add(study.id, "south")
        store.webhooks.ping(store.webhooks.add("https://x.example", ["job.ended"])[0].id)
        store.invitations.add("guest@example.org", "viewer", None)
        code = store.invitations.add("other@example.org", "viewer", None)[1]
    _, token = people.token("north")
    return {
        "study": study.id, "waiting": waiting_id(people), "published": publication.key, "own": own, "both": both,
        "raw": raw, "code": code, "token": token,
    }  # fmt: skip


def waiting_id(people: People) -> str:
    with people.installation.reading() as session:
        return str(session.scalar(sa.select(Job.id).where(Job.request_hash == "i")))


def test_a_closed_lab_lets_nobody_in_and_what_it_has_published_is_read(
    ada: TestClient, eve: TestClient, people: People, north: dict[str, str]
) -> None:
    assert eve.get(f"{V1}/studies/{north['study']}").status_code == 200
    assert ada.delete(f"{V1}/lab?name=South").status_code == 409
    assert ada.get(f"{V1}/studies").status_code == 200
    assert ada.delete(f"{V1}/lab?name=north").status_code == 204
    assert ada.get(f"{V1}/studies").status_code == 403
    assert ada.get(f"{V1}/session").json()["labs"] == []
    assert ada.put(f"{V1}/session/lab", json={"lab_id": "north"}).status_code == 404
    with people.program(north["token"]) as robot:
        assert robot.get(f"{V1}/studies").status_code == 401
    assert eve.get(f"{V1}/studies/{north['study']}").status_code == 404
    assert eve.get(f"{V1}/shared").json()["items"] == []
    with people.browser() as nobody:
        assert nobody.post(f"{V1}/invitations/look", json={"code": north["code"]}).status_code == 404
        assert nobody.get(f"{V1}/published/{north['published']}/files/results/results.json").content == b"{}"
    with people.installation.reading() as session:
        waited = session.get_one(Job, north["waiting"])
        assert (waited.state, waited.reason) == ("cancelled", "its lab was closed")


def test_it_opens_again_with_all_it_had_while_it_is_there(
    ada: TestClient, people: People, north: dict[str, str]
) -> None:
    ada.delete(f"{V1}/lab?name=north")
    with people.installation.session() as session:
        reopen_lab(session, "north", "operator")
    assert ada.put(f"{V1}/session/lab", json={"lab_id": "north"}).status_code == 204
    assert ada.get(f"{V1}/studies/{north['study']}").status_code == 200
    with pytest.raises(Conflict), people.installation.session() as session:
        reopen_lab(session, "north", "operator")


def test_after_its_time_all_goes_but_its_audit_and_what_it_has_published(
    ada: TestClient, eve: TestClient, people: People, north: dict[str, str], settings: Settings
) -> None:
    with people.installation.session() as session:
        close_lab(session, "north", "test")
        assert due_labs(session, timedelta(days=1)) == []
    keeping = Housekeeping(people.installation, settings.model_copy(update={"lab_kept_days": 0.0}))
    keeping._chore(CLOSED, keeping._remove_closed)
    left = rows_of(people, "north")
    assert {name for name, count in left.items() if count} == set(STAYS)
    assert rows_of(people, "south")["studies"] == 1
    for _ in range(3):
        sweep_installation(people.installation, waited=timedelta(0))
    there = {name: people.installation.blobs.exists(north[name]) for name in ("own", "both", "raw")}
    assert there == {"own": False, "both": True, "raw": True}
    address = f"{V1}/published/{north['published']}"
    with people.browser() as nobody:
        assert nobody.get(f"{address}/files/results/results.json").content == b"{}"
        told = [nobody.get(f"{address}{path}") for path in ("", "/datacite", "/SHA256SUMS")]
        assert [each.status_code for each in told] == [200, 200, 200]
        assert (told[0].json()["lab"], told[0].json()["revoked_at"]) == ("north", None)
    with people.installation.session() as session:
        assert session.get(LabRow, "north") is None
        told = session.scalars(sa.select(AuditEntry.action).where(AuditEntry.lab_id == "north")).all()
        assert told[-1] == "remove" or "remove" in told
        with pytest.raises(NotFound):
            reopen_lab(session, "north", "operator")
    assert ada.get(f"{V1}/session").json()["account"]["email"] == "ada@example.org"


def test_the_command_says_which_closed_labs_would_go_and_then_lets_them_go(
    people: People,
    north: dict[str, str],
    settings: Settings,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """What the server does every hour, `exogauge gc` does by hand."""
    monkeypatch.setenv("EXOGAUGE_DATABASE_URL", settings.database_url)
    monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(settings.data_dir))
    with people.installation.session() as session:
        close_lab(session, "north", "test")
    before = rows_of(people, "north")

    def gc(*options: str) -> dict[str, Any]:
        assert main(["gc", "--json", *options]) == 0
        told: dict[str, Any] = json.loads(capsys.readouterr().out)
        return told

    assert gc("--stopped")["closed"] == {"labs": 0, "rows": 0}  # it was closed just now
    monkeypatch.setenv("EXOGAUGE_LAB_KEPT_DAYS", "0")
    would_go = gc("--dry-run")["closed"]
    assert rows_of(people, "north") == before
    assert would_go == {"labs": 1, "rows": sum(before.values()) - sum(before[name] for name in STAYS)}
    assert gc("--stopped")["closed"] == would_go
    assert {name for name, count in rows_of(people, "north").items() if count} == set(STAYS)
    assert rows_of(people, "south")["studies"] == 1
    assert not people.installation.blobs.exists(north["own"])
    assert gc("--dry-run")["closed"] == {"labs": 0, "rows": 0}


def test_what_a_lab_that_is_gone_has_published_is_revoked_by_who_runs_the_service(
    people: People, north: dict[str, str], settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    with people.installation.session() as session:
        close_lab(session, "north", "test")
        remove_lab(session, "north")
    monkeypatch.setenv("EXOGAUGE_DATABASE_URL", settings.database_url)
    monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(settings.data_dir))
    assert main(["lab", "retract", north["published"], "--because", "a wrong sign"]) == 0
    assert main(["lab", "retract", "nothing", "--because", "a wrong sign"]) != 0
    address = f"{V1}/published/{north['published']}"
    with people.browser() as nobody:
        assert nobody.get(f"{address}/files/results/results.json").status_code == 410
        assert nobody.get(address).json()["revoked_because"] == "a wrong sign"
    with people.installation.reading() as session:
        said = sa.select(AuditEntry.actor).where(AuditEntry.lab_id == "north", AuditEntry.action == "revoke")
        assert session.scalars(said.where(AuditEntry.subject_kind == "publication")).all() == ["operator"]


def test_an_open_lab_is_never_removed(people: People, north: dict[str, str]) -> None:
    with people.installation.session() as session:
        assert remove_lab(session, "north") is None
        assert due_labs(session, timedelta(0)) == []
    assert rows_of(people, "north")["studies"] == 1


def test_a_name_is_changed_by_whoever_has_seen_the_present_one(ada: TestClient, north: dict[str, str]) -> None:
    seen = ada.get(f"{V1}/lab").headers["etag"]
    changed = ada.put(f"{V1}/lab", json={"name": "Northern"}, headers={"If-Match": seen})
    assert (changed.status_code, changed.headers["etag"] != seen) == (200, True)
    assert ada.put(f"{V1}/lab", json={"name": "Other"}, headers={"If-Match": seen}).status_code == 412
    assert ada.put(f"{V1}/lab", json={"name": "north"}, headers={"If-Match": "*"}).status_code == 200


def rows_of(people: People, lab: str) -> dict[str, Any]:
    with people.installation.reading() as session:
        return {
            table.name: session.scalar(sa.select(sa.func.count()).select_from(table).where(table.c.lab_id == lab))
            for table in Base.metadata.sorted_tables
            if "lab_id" in table.columns
        }
