"""Requests and jobs of a whole service are told to a collector of OpenTelemetry, where one is named."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx
import pytest
from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest
from tests.whole_service import Service, small_study

from exogauge import Client
from exogauge.client import ClientProblem

PATIENCE_S = 30.0
TOO_SHORT = 40  # samples: nothing can be identified
ERROR = 2  # of opentelemetry.proto.trace.v1.Status


@contextmanager
def collector() -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Its address, and the spans that came."""
    spans = list[dict[str, Any]]()

    class Takes(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = ExportTraceServiceRequest.FromString(self.rfile.read(int(self.headers["Content-Length"])))
            for of_service in body.resource_spans:
                service = {each.key: each.value.string_value for each in of_service.resource.attributes}["service.name"]
                spans.extend(told(span, service) for scope in of_service.scope_spans for span in scope.spans)
            self.send_response(200)
            self.end_headers()

        def log_message(self, *_: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Takes) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}", spans
        server.shutdown()


def told(span: Any, service: str) -> dict[str, Any]:
    facts = {each.key: each.value.string_value or each.value.int_value for each in span.attributes}
    events = [each.name for each in span.events]
    return {"service": service, "name": span.name, "trace": span.trace_id.hex(), "parent": span.parent_span_id.hex(),
            "error": span.status.code == ERROR, "why": span.status.message, "events": events, **facts}  # fmt: skip


@pytest.mark.slow
def test_a_request_and_its_job_are_spans_of_their_processes(tmp_path: Path) -> None:
    study, broken = (tmp_path / name for name in ("study", "broken"))
    for folder in (study, broken):
        for name, data in small_study(folder.name, 400 if folder is study else TOO_SHORT).items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
    with collector() as (address, spans):
        service = Service(tmp_path, "", log="json")
        service.environment |= {"OTEL_EXPORTER_OTLP_ENDPOINT": address, "OTEL_BSP_SCHEDULE_DELAY": "200"}
        url = service.start()
        caller = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
        with Client(url) as client:
            done = client.submit(client.upload_study(study))
            client.wait(done)
            with pytest.raises(ClientProblem):
                client.wait(client.submit(client.upload_study(broken)))
        with httpx.Client(base_url=url) as http:
            http.get("/api/v1/studies", headers={"traceparent": caller, "X-Request-ID": "robot-cell-7"})
            http.get("/api/v1/jobs/00000000-0000-4000-8000-000000000000")
            http.get("/healthz")
        service.process.send_signal(signal.SIGTERM)
        service.process.wait(PATIENCE_S)
        until = time.monotonic() + PATIENCE_S
        while sum(each["name"].startswith("job ") for each in spans) < 2:  # a worker leaves after the server
            assert time.monotonic() < until, spans
            time.sleep(0.1)
    of_request = next(each for each in spans if each.get("exogauge.request") == "robot-cell-7")
    assert of_request["name"] == "GET /api/v1/studies"
    assert of_request["http.response.status_code"] == 200
    assert (of_request["trace"], of_request["parent"]) == (caller.split("-")[1], caller.split("-")[2])
    missing = next(each for each in spans if each.get("http.response.status_code") == 404)
    assert not missing["error"], "what a client asks for wrongly is no fault of the service"
    job, failed = (each for each in spans if each["service"] == "exogauge-worker" and each["name"].startswith("job "))
    assert (job["name"], job["exogauge.job"], job["exogauge.attempt"]) == ("job evaluate", done.id, 1)
    assert job["events"][:2] == ["reading", "identify"]
    assert not job["error"]
    assert failed["error"]
    assert f"{TOO_SHORT} samples" in failed["why"]
    assert not [each for each in spans if each.get("url.path") == "/healthz"]


@pytest.mark.slow
def test_a_collector_without_the_package_is_refused_with_what_to_install(tmp_path: Path) -> None:
    hidden = "import sys; sys.modules['opentelemetry.sdk'] = None; import exogauge.cli; sys.exit(exogauge.cli.main())"
    service = Service(tmp_path, "")
    service.environment["OTEL_EXPORTER_OTLP_ENDPOINT"] = "http://127.0.0.1:9"
    command = [sys.executable, "-c", hidden, "serve"]
    done = subprocess.run(command, env=service.environment, capture_output=True, text=True)
    assert done.returncode == 2
    assert "OTEL_EXPORTER_OTLP_ENDPOINT" in done.stderr
    assert "pip install 'exogauge[telemetry]'" in done.stderr
