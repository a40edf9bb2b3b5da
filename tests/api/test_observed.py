"""A request can be followed: an id in answer and log, counts and times for Prometheus; and health is told."""

from __future__ import annotations

import json
import logging
from typing import Any

import pytest
from fastapi.testclient import TestClient

from exogauge.api.app import create_app
from exogauge.logbook import AsJson, job_id, request_id
from exogauge.settings import Settings

on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@on_sqlite
def test_every_answer_has_an_id_which_its_sender_may_choose(client: TestClient) -> None:
    made = client.get("/api/v1/studies").headers["x-request-id"]
    assert len(made) == 32
    assert client.get("/api/v1/studies").headers["x-request-id"] != made
    for given, kept in (("robot-cell-7", True), ("short", False), ("a" * 65, False), ("two words!!", False)):
        answer = client.get("/api/v1/nothing", headers={"X-Request-ID": given})
        assert (answer.headers["x-request-id"] == given) is kept


@on_sqlite
def test_a_line_of_the_log_is_json_with_the_request_and_the_job_it_is_of(
    client: TestClient, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    caplog.set_level(logging.INFO, "exogauge")
    lines = list[dict[str, Any]]()
    monkeypatch.setattr(caplog.handler, "emit", lambda record: lines.append(json.loads(AsJson().format(record))))
    client.get("/api/v1/robots", headers={"X-Request-ID": "robot-cell-7"})
    told = next(line for line in lines if line.get("path") == "/api/v1/robots")
    assert told["request"] == "robot-cell-7"
    assert (told["method"], told["status"], told["level"]) == ("GET", 200, "info")
    assert told["seconds"] > 0
    token = job_id.set("j")
    logging.getLogger("exogauge.jobs").info('ä "quoted"\nline')
    job_id.reset(token)
    assert (lines[-1]["job"], lines[-1]["message"]) == ("j", 'ä "quoted"\nline')
    assert request_id.get() is None


def numbers(text: str) -> dict[str, float]:
    return {name: float(value) for name, value in (line.rsplit(" ", 1) for line in text.splitlines() if line[0] != "#")}


@on_sqlite
def test_metrics_count_requests_by_route_and_jobs_by_state(client: TestClient, finished_job: str) -> None:
    for _ in range(3):
        client.get(f"/api/v1/jobs/{finished_job}")
    client.get("/api/v1/jobs/00000000-0000-4000-8000-000000000000")
    found = numbers(client.get("/metrics").text)
    route = 'exogauge_requests_total{method="GET",route="/jobs/{job_id}",status="%d"}'
    assert (found[route % 200], found[route % 404]) == (3, 1)
    assert found['exogauge_jobs{state="succeeded"}'] == 1
    assert found['exogauge_jobs{state="queued"}'] == 0
    assert found["exogauge_database_up"] == 1
    assert found["exogauge_disk_free_bytes"] > 0
    assert finished_job not in client.get("/metrics").text


@on_sqlite
def test_metrics_go_out_only_where_it_is_said(settings: Settings) -> None:
    for host, metrics, status in (("0.0.0.0", None, 404), ("0.0.0.0", True, 200), ("127.0.0.1", False, 404)):
        with TestClient(create_app(settings.model_copy(update={"host": host, "metrics": metrics}))) as opened:
            assert opened.get("/metrics").status_code == status


def test_health_asks_nobody_and_readiness_asks_all(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    assert client.get("/readyz").json()["database"] == "ok"
    client.app.state.installation.engine.dispose()  # type: ignore[attr-defined]
    from exogauge.errors import Unavailable
    from exogauge.storage.store import Installation

    def away(_: Installation) -> int:
        raise Unavailable("the database is away")

    monkeypatch.setattr(Installation, "workers_alive", away)
    assert client.get("/healthz").json()["status"] == "ok"
    assert client.get("/readyz").status_code == 503
