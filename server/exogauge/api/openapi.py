"""The OpenAPI document: what FastAPI derives, and what it cannot know: problems, keys, bodies in two forms."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from exogauge.api.problems import MEDIA_TYPE, Problem
from exogauge.api.shapes import StudyFromParts

REF = "#/components/schemas/{model}"
PROBLEM = {"content": {MEDIA_TYPE: {"schema": {"$ref": REF.format(model="Problem")}}}}
KEY = {
    "name": "Idempotency-Key",
    "in": "header",
    "required": False,
    "description": "A key of the caller's making; the same request under it happens once.",
    "schema": {"type": "string", "minLength": 1, "maxLength": 255, "pattern": "^[!-~]+$"},
}


def document(app: FastAPI) -> dict[str, Any]:
    """Made once per app."""
    if app.openapi_schema is None:
        made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
        schemas = made.setdefault("components", {}).setdefault("schemas", {})
        for model in (Problem, StudyFromParts):
            schema = model.model_json_schema(ref_template=REF)
            schemas |= schema.pop("$defs", {})
            schemas[model.__name__] = schema
        for unused in ("HTTPValidationError", "ValidationError"):
            schemas.pop(unused, None)
        for path in made["paths"].values():
            for method, operation in path.items():
                complete(method, operation)
        app.openapi_schema = made
    return app.openapi_schema


def complete(method: str, operation: dict[str, Any]) -> None:
    """Every operation may answer with a problem; every POST takes an idempotency key."""
    responses = operation["responses"]
    responses.pop("422", None)
    responses["4XX"] = {"description": "What was wrong with the request, rule by rule", **PROBLEM}
    responses["5XX"] = {"description": "Why the service cannot serve now", **PROBLEM}
    if method == "post":
        operation.setdefault("parameters", []).append(KEY)
