"""Request bodies that a signature cannot say: bundles of files in a form of any field names, or JSON in their place."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, field
from json import JSONDecodeError
from typing import Any, final

from fastapi import HTTPException, Request
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.datastructures import FormData, UploadFile

from exogauge.api.dependencies import get_settings
from exogauge.api.problems import NOT_JSON
from exogauge.api.reading import FORM, JSON, media_type
from exogauge.api.shapes import StudyFromParts


@final
@dataclass(frozen=True)
class BundleUpload:
    """files: as they came, spooled, unopened. name: the form's `name`, where given. robot: its `robot`, an id; only
    devices ask for one. said: all other fields that are not blank."""

    files: tuple[UploadFile, ...]
    name: str | None
    robot: str | None = None
    said: Mapping[str, str] = field(default_factory=dict)


async def bundle_body(request: Request) -> AsyncIterator[BundleUpload]:
    """The files of a multipart form; they are closed when the request ends."""
    if media_type(request) != FORM:
        raise HTTPException(415, f"send the files as {FORM}")
    async with request.form(max_files=(await get_settings(request)).max_bundle_files, max_fields=20) as form:
        files = tuple(value for _, value in form.multi_items() if isinstance(value, UploadFile))
        if not files:
            raise refused(
                ("body", "files"), "missing", "the form holds no file; a file has a `filename` beside its `name`"
            )
        said = {key: text for key in form if (text := text_of(form, key)) is not None}
        yield BundleUpload(files, said.pop("name", None), said.pop("robot", None), said)


async def device_body(request: Request) -> AsyncIterator[BundleUpload]:
    """The files of a device, and the robot whose links they name."""
    async for upload in bundle_body(request):
        if upload.robot is None:
            raise refused(("body", "robot"), "missing", "name the robot that wears the device, by its id")
        yield upload


async def study_body(request: Request) -> AsyncIterator[BundleUpload | StudyFromParts]:
    """A study as files, or as JSON that names a robot and logs uploaded before."""
    if JSON.fullmatch(media_type(request)):
        yield parts(await json_of(request))
    else:
        async for upload in bundle_body(request):
            yield upload


async def json_of(request: Request) -> Any:
    try:
        return await request.json()
    except JSONDecodeError as error:
        fault = {"type": NOT_JSON, "loc": ("body", error.pos), "msg": error.msg, "ctx": {"error": error.msg}}
        raise RequestValidationError([fault], body=error.doc) from error


def parts(content: Any) -> StudyFromParts:
    try:
        return StudyFromParts.model_validate(content)
    except ValidationError as error:
        raise RequestValidationError(
            [{**entry, "loc": ("body", *entry["loc"])} for entry in error.errors(include_url=False)]
        ) from error


def text_of(form: FormData, field: str) -> str | None:
    """A field of the form, None where it is absent or blank."""
    value = form.get(field)
    return value.strip()[:200] or None if isinstance(value, str) else None


def refused(place: tuple[str, ...], kind: str, message: str) -> RequestValidationError:
    return RequestValidationError([{"type": kind, "loc": place, "msg": message}])


def bundle_schema(
    description: str, json_model: type[StudyFromParts] | None = None, needed: Mapping[str, Any] | None = None,
    also: Mapping[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The OpenAPI of such a body. needed: further fields of the form that must be there, name -> schema; also: that
    may be."""
    needed = needed or {}
    form = {
        "type": "object",
        "required": ["files", *needed],
        "properties": {
            "files": {"type": "array", "minItems": 1, "items": {"type": "string", "format": "binary"},
                      "description": description},
            "name": {"type": "string", "maxLength": 200},
            **needed,
            **(also or {}),
        },
    }  # fmt: skip
    content: dict[str, Any] = {FORM: {"schema": form}}
    if json_model is not None:
        content["application/json"] = {"schema": {"$ref": f"#/components/schemas/{json_model.__name__}"}}
    return {"requestBody": {"required": True, "content": content}}
