"""The committed OpenAPI document, which the web app's types are made of."""

from __future__ import annotations

from pathlib import Path

from exogauge.api.openapi_file import openapi_file

FILE = Path(__file__).resolve().parents[2] / "web" / "openapi.json"


def test_the_committed_openapi_document_is_the_apis_own() -> None:
    assert FILE.read_text(encoding="utf-8") == openapi_file(), "the API has changed: run `make openapi` and commit"
