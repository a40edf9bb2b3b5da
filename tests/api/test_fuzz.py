"""Requests made from the OpenAPI document, right and wrong ones: no 5xx, and nothing that the document does not say."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from exogauge.api.app import create_app
from exogauge.settings import Settings
from exogauge.storage.store import Storage
from exogauge.storage.tables import Job

# EXOGAUGE_TEST_REQUESTS=200 asks for more of each operation and kind, and for others every time.
REQUESTS = os.environ.get("EXOGAUGE_TEST_REQUESTS")
EXAMPLES = int(REQUESTS or 4)


@pytest.fixture
def schema(tmp_path: Path, unchecked: None) -> Iterator[Any]:
    """The document of an app that holds one robot, one device, one study and one ended job."""
    import schemathesis

    schemathesis.serializer.alias("application/offset+octet-stream", "application/octet-stream")
    app = create_app(Settings(data_dir=tmp_path, workers=0, max_upload_bytes=2_000_000))
    storage: Storage = app.state.installation.of_lab("local")
    with storage.transaction() as store:
        robot, _ = store.robots.add("r", [], {})
        store.devices.add("d", [], {}, robot_id=robot.id)
        study, _ = store.studies.add("s", [], {})
        store.session.add(Job(kind="evaluate", study_id=study.id, request_hash="h", state="failed"))
    document = schemathesis.openapi.from_asgi("/api/v1/openapi.json", app)
    document.config.checks.negative_data_rejection.expected_statuses.append("412")  # another version of tus
    yield document
    app.state.installation.close()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["right", "wrong"])
def test_no_request_gets_an_answer_that_the_document_does_not_know(schema: Any, kind: str) -> None:
    from schemathesis import GenerationMode  # which takes most of a second, of every process that collects tests
    from schemathesis.specs.openapi import checks

    mode = {"right": GenerationMode.POSITIVE, "wrong": GenerationMode.NEGATIVE}[kind]
    # A schema can say neither what must be in a file nor that a form's text is no number.
    unsayable = [checks.positive_data_acceptance, checks.negative_data_rejection]
    failures, count = dict[str, str](), 0
    for found in schema.get_all_operations():
        operation = found.ok()
        if kind == "wrong" and not (operation.query or operation.body or operation.path_parameters):
            continue

        @given(case=operation.as_strategy(generation_mode=mode))
        @settings(
            max_examples=EXAMPLES,
            deadline=None,
            derandomize=REQUESTS is None,
            database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        def ask(case: Any) -> None:
            nonlocal count
            count += 1
            form = str(case.media_type).startswith("multipart/")
            case.call_and_validate(excluded_checks=unsayable if form else unsayable[:1])

        try:
            ask()
        except BaseExceptionGroup as error:
            failures[operation.label] = str(error.exceptions[0])
    assert not failures, "\n\n".join(f"{label}\n{text}" for label, text in failures.items())
    assert count > 100
