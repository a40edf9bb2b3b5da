"""Health, lists, the OpenAPI document, and a start that is refused."""

from __future__ import annotations

import shutil
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from exogauge.api.app import create_app
from exogauge.settings import Settings
from exogauge.storage.database import make_engine
from exogauge.storage.files import PinnedFile
from exogauge.storage.migrate import WrongSchema
from exogauge.storage.store import Storage
from exogauge.storage.tables import WorkerLease

pytestmark = pytest.mark.usefixtures("without_bytes")

V1 = "/api/v1"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


def test_health_tells_what_is_there(client: TestClient) -> None:
    answer = client.get("/readyz")
    assert answer.status_code == 200
    assert answer.json() == {
        "status": "degraded", "version": "0.1.0", "database": "ok", "blobs": "ok", "workers_wanted": 0,
        "workers_alive": 0,
    }  # fmt: skip


@on_sqlite
def test_no_route_is_made_a_second_time_for_an_app(client: TestClient, settings: Settings) -> None:
    """To make all of them takes a tenth of a second, of the first request that a service answers."""
    others = {id(route) for route in create_app(settings).routes}
    assert len(others) > 100
    assert {id(route) for route in client.app.routes if route.path != f"{V1}/openapi.json"} <= others


@on_sqlite
def test_health_is_degraded_without_workers_and_unavailable_without_blobs(settings: Settings) -> None:
    app = create_app(settings.model_copy(update={"workers": 1}))
    with TestClient(app) as client:
        assert client.get("/readyz").json()["status"] == "degraded"
        with app.state.installation.of_lab("local").transaction() as store:
            now = datetime.now(UTC)
            store.session.add(WorkerLease(worker_id="w", beat_at=now, started_at=now, host="h", pid=1))
        assert client.get("/readyz").json()["status"] == "ok"
        shutil.rmtree(settings.blobs)
        answer = client.get("/readyz")
        assert (answer.status_code, answer.json()["blobs"]) == (503, "unavailable")


@on_sqlite
def test_health_is_looked_at_without_writing_anything(client: TestClient, settings: Settings) -> None:
    client.get("/readyz")
    before = {path: path.stat().st_mtime_ns for path in settings.blobs.rglob("*")}
    assert client.get("/readyz").json()["blobs"] == "ok"
    assert {path: path.stat().st_mtime_ns for path in settings.blobs.rglob("*")} == before
    assert not [path for path in before if path.is_file()]


@on_sqlite
@pytest.mark.slow
def test_a_full_disk_shows_in_health_and_is_507_wherever_it_is_met(
    settings: Settings, small_disk: Any, pack: Any, study_files: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    small = Settings(data_dir=small_disk.folder, database_url=settings.database_url, workers=0)
    monkeypatch.setattr(tempfile, "tempdir", str(small_disk.folder))  # where uploads are read, too
    with TestClient(create_app(small), raise_server_exceptions=False) as client:
        answers = []
        for pages in (0, 2, 6, 9, 11, 12, 13, 14, 15, 16, 18):  # full when it arrives, is laid out, is read or is kept
            small_disk.fill(pages * 4096)
            assert client.get("/readyz").json()["blobs"] == ("ok" if pages else "unavailable")
            answers.append(client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))}))
            small_disk.empty()
            if answers[-1].status_code == 201:
                break
        assert {each.json()["type"] for each in answers[:-1]} == {"urn:exogauge:problem:disk-full"}
        assert [each.status_code for each in answers] == [507] * (len(answers) - 1) + [201]


@on_sqlite
def test_a_database_that_goes_away_is_a_problem_and_comes_back(client: TestClient, settings: Settings) -> None:
    place = settings.data_dir.parent
    (place / "test.sqlite").rename(place / "gone")
    client.app.state.installation.engine.dispose()  # type: ignore[attr-defined]
    answer = client.get(f"{V1}/studies")
    assert (answer.status_code, answer.headers["content-type"]) == (503, "application/problem+json")
    (place / "gone").rename(place / "test.sqlite")
    client.app.state.installation.engine.dispose()  # type: ignore[attr-defined]
    assert client.get(f"{V1}/studies").status_code == 200


def test_a_list_is_paged_by_an_opaque_cursor(client: TestClient) -> None:
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    for k in range(5):
        with storage.transaction() as store:
            store.studies.add(f"study {k}", [PinnedFile("study.yaml", f"{k:064}", 1)], {})
    names, cursor = list[str](), ""
    while cursor is not None:
        page = client.get(f"{V1}/studies?limit=2{cursor and '&cursor=' + cursor}").json()
        names += [study["name"] for study in page["items"]]
        cursor = page["next_cursor"]
    assert names == [f"study {k}" for k in (4, 3, 2, 1, 0)]


@pytest.mark.slow
def test_a_new_database_gets_its_tables_when_the_service_starts(empty_database_url: str, tmp_path: Path) -> None:
    with TestClient(create_app(Settings(data_dir=tmp_path, database_url=empty_database_url, workers=0))) as client:
        assert client.get("/readyz").json()["database"] == "ok"
        assert client.get(f"{V1}/studies").json()["items"] == []


def test_a_server_refuses_a_schema_it_does_not_know(own_database_url: str, tmp_path: Path) -> None:
    settings = Settings(data_dir=tmp_path, database_url=own_database_url, workers=0)
    create_app(settings).state.installation.close()
    engine = make_engine(settings.database_url, migrating=True)
    with engine.begin() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    engine.dispose()
    with pytest.raises(WrongSchema, match="9999"):
        create_app(settings)


@pytest.mark.slow
@on_sqlite
def test_every_operation_has_a_name_a_problem_and_where_it_posts_a_key(client: TestClient) -> None:
    document = client.get(f"{V1}/openapi.json").json()
    assert document["openapi"].startswith("3.1")
    operations: list[tuple[str, dict[str, Any]]] = [
        (method, operation) for path in document["paths"].values() for method, operation in path.items()
    ]
    names = [operation["operationId"] for _, operation in operations]
    assert {"createRobot", "listRobots", "getRobot", "createLog", "createStudy", "getStudyResults"} <= set(names)
    assert {"createDevice", "listDevices", "getDevice", "getDeviceFile"} <= set(names)
    assert {"listArtifacts", "getArtifact", "getHealth", "submitJob", "getJob", "cancelJob"} <= set(names)
    assert len(names) == len(set(names))
    for method, operation in operations:
        for status in ("4XX", "5XX"):
            assert "application/problem+json" in operation["responses"][status]["content"]
        keys = [parameter["name"] for parameter in operation.get("parameters", [])]
        assert ("Idempotency-Key" in keys) == (method == "post")
    assert "Problem" in document["components"]["schemas"]
    assert "HTTPValidationError" not in document["components"]["schemas"]


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EXOGAUGE_DATABASE_URL", "postgresql://u:secret@h/d")
    monkeypatch.setenv("EXOGAUGE_PORT", "9000")
    settings = Settings()
    assert (settings.port, settings.workers, settings.local_only) == (9000, 2, True)
    assert settings.data_dir.is_absolute()
    assert settings.blobs == settings.data_dir / "blobs"
    assert "secret" not in repr(settings)
    assert not Settings(host="0.0.0.0").local_only
    assert Settings(database_url="").database_url.startswith("sqlite:////")


@on_sqlite
def test_what_was_handed_in_can_be_deleted(client: TestClient, study_id: str) -> None:
    assert client.delete(f"/api/v1/studies/{study_id}").status_code == 204
    gone = client.delete(f"/api/v1/studies/{study_id}")
    assert (gone.status_code, gone.headers["content-type"]) == (404, "application/problem+json")
    assert client.get(f"/api/v1/studies/{study_id}").status_code == 404
    for nouns in ("robots", "devices", "logs", "payloads"):
        assert client.delete(f"/api/v1/{nouns}/{study_id}").status_code == 404
