"""Errors as RFC 9457 problem documents, for every 4xx and 5xx. The domain knows no HTTP; its statuses are here."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any, final

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from sqlalchemy.exc import DataError, IntegrityError, InterfaceError, OperationalError
from starlette.exceptions import HTTPException

from exogauge.api.routing import PREFIX, meant, methods_at
from exogauge.errors import (
    BadInput,
    BadLog,
    BadRobot,
    BadStudy,
    Cancelled,
    Conflict,
    DiskFull,
    ExogaugeError,
    Fault,
    Gone,
    NotFound,
    NotIdentifiable,
    PhysicallyImpossible,
    QuotaFull,
    TooLarge,
    TooMany,
    Unavailable,
    no_room,
)
from exogauge.storage.database import away, refers_to_nothing

log = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
MOST_ERRORS = 100
NOT_JSON = "json_invalid"
WAIT_S = 2.0  # after which what cannot be served now is worth another try
STATUS: dict[type[ExogaugeError], tuple[int, str, str]] = {  # the first class that fits counts
    QuotaFull: (507, "quota-full", "The lab has no room left"),
    DiskFull: (507, "disk-full", "The disk is full"),
    TooLarge: (413, "too-large", "Too large"),
    BadLog: (422, "bad-log", "The log breaks a rule"),
    BadRobot: (422, "bad-robot", "The robot's description breaks a rule"),
    BadStudy: (422, "bad-study", "What was handed in breaks a rule"),
    BadInput: (422, "bad-input", "The input breaks a rule"),
    NotIdentifiable: (422, "not-identifiable", "The data hold no answer"),
    PhysicallyImpossible: (422, "physically-impossible", "Not a possible body"),
    NotFound: (404, "not-found", "Not found"),
    Gone: (410, "gone", "Gone"),
    Conflict: (409, "conflict", "Conflict"),
    TooMany: (429, "too-many", "Too many"),
    Cancelled: (409, "cancelled", "Cancelled"),
    Unavailable: (503, "unavailable", "Cannot serve now"),
}


@final
class ProblemError(BaseModel):
    """One broken rule at one place. row counts data rows from 1, or lines of a text file; pointer: into the request."""

    detail: str
    code: str
    pointer: str | None = None
    file: str | None = None
    row: int | None = None
    column: str | None = None
    value: str | None = None
    advice: str | None = None


@final
class Problem(BaseModel):
    """RFC 9457."""

    type: str
    title: str
    status: int
    detail: str
    instance: str | None = None
    errors: list[ProblemError] = []


def problem_response(
    status: int,
    slug: str,
    title: str,
    detail: str,
    *,
    instance: str | None = None,
    errors: Sequence[ProblemError] = (),
    headers: dict[str, str] | None = None,
) -> JSONResponse:
    document = new_problem(status, slug, title, detail, instance, errors)
    return JSONResponse(document.model_dump(mode="json"), status, headers, MEDIA_TYPE)


def new_problem(
    status: int, slug: str, title: str, detail: str, instance: str | None, errors: Sequence[ProblemError]
) -> Problem:
    return Problem(
        type=f"urn:exogauge:problem:{slug}",
        title=title,
        status=status,
        detail=clean(detail),
        instance=instance,
        errors=list(errors[:MOST_ERRORS]),
    )


def of_error(error: ExogaugeError, instance: str | None = None) -> JSONResponse:
    """The problem of anything exogauge raises on purpose."""
    headers = None
    if isinstance(error, Unavailable | TooMany):
        wait_s = error.retry_after_s if isinstance(error, TooMany) else WAIT_S
        headers = {"Retry-After": str(max(1, math.ceil(wait_s)))}
    document = problem_of(error, instance)
    return JSONResponse(document.model_dump(mode="json"), document.status, headers, MEDIA_TYPE)


def problem_of(error: ExogaugeError, instance: str | None = None) -> Problem:
    found = (entry for kind, entry in STATUS.items() if isinstance(error, kind))
    status, slug, title = next(found, (500, "internal", "Internal error"))
    errors = [of_fault(fault) for fault in error.faults] if isinstance(error, BadInput) else []
    detail = str(error)
    if len(errors) > 1:
        detail = f"{len(errors)} rules are broken; the first: {error.faults[0]}" if isinstance(error, BadInput) else ""
    return new_problem(status, slug, title, detail, instance, errors)


def of_failure(failure: Mapping[str, Any] | None, reason: str | None) -> Problem | None:
    """The problem that ended a job: what an upload with the same fault would be answered. None where there was none.

    failure: {class, faults, defect} as the job's row keeps it.
    """
    kind = next((kind for kind in STATUS if failure is not None and kind.__name__ == failure["class"]), None)
    if failure is None or kind is None or failure.get("defect"):
        return None
    faults = [Fault(**fault) for fault in failure["faults"]]
    return problem_of(kind(faults) if issubclass(kind, BadInput) else kind(reason or ""))


def of_fault(fault: Fault) -> ProblemError:
    return ProblemError(
        detail=clean(fault.detail),
        code=fault.rule,
        file=cleaned(fault.file),
        row=fault.row,
        column=cleaned(fault.column),
        value=cleaned(fault.value),
        advice=cleaned(fault.advice or None),
    )


def of_validation(error: RequestValidationError, instance: str | None = None) -> JSONResponse:
    """What pydantic refuses in path, query, header or body."""
    errors = [
        ProblemError(detail=clean(said(entry, error)), code=entry["type"], pointer=pointer(place))
        for entry in error.errors()
        for place in [("body",) if entry["type"] == NOT_JSON else entry["loc"]]
    ]
    detail = "; ".join(f"{entry.pointer}: {entry.detail}" for entry in errors[:3])
    return problem_response(
        422, "bad-request-content", "The request breaks a rule", detail, instance=instance, errors=errors
    )


def said(entry: Mapping[str, Any], error: RequestValidationError) -> str:
    if entry["type"] != NOT_JSON:
        return str(entry["msg"]).removeprefix("Value error, ")
    why, text, place = entry["ctx"]["error"], error.body, entry["loc"][-1]
    if not text:
        return f"this is no JSON: {why}"
    before = text[:place]
    return f"this is no JSON: {why} in line {before.count(chr(10)) + 1}, column {place - before.rfind(chr(10))}"


def pointer(place: Sequence[str | int]) -> str:
    """A JSON pointer into the body (`#/logs/0/role`), or the kind and name of a parameter (`query/limit`)."""
    if not place or place[0] != "body":
        return clean("/".join(str(part) for part in place))
    escaped = (str(part).replace("~", "~0").replace("/", "~1") for part in place[1:])
    return clean("#" + "".join(f"/{part}" for part in escaped))


def of_http(error: HTTPException, instance: str | None = None) -> JSONResponse:
    """What the framework itself refuses: unknown paths and methods, bodies it cannot read."""
    title = HTTPStatus(error.status_code).phrase
    slug = title.lower().replace(" ", "-")
    headers = dict(error.headers) if error.headers else None
    return problem_response(error.status_code, slug, title, str(error.detail), instance=instance, headers=headers)


def clean(text: str) -> str:
    """Text that JSON can carry: no lone surrogates, no endless values."""
    return text[:4000].encode("utf-8", "backslashreplace").decode()


def cleaned(text: str | None) -> str | None:
    return None if text is None else clean(text)[:500]


def install(app: FastAPI) -> None:
    """Answer every error of the app with a problem document."""

    @app.exception_handler(ExogaugeError)
    def _ours(request: Request, error: ExogaugeError) -> JSONResponse:
        if isinstance(error, Unavailable):
            log.warning("%s %s: %s", request.method, request.url.path, error)
        return of_error(error, request.url.path)

    @app.exception_handler(RequestValidationError)
    def _invalid(request: Request, error: RequestValidationError) -> JSONResponse:
        return of_validation(error, request.url.path)

    @app.exception_handler(HTTPException)
    def _framework(request: Request, error: HTTPException) -> JSONResponse:
        routes = request.app.router.routes
        if error.status_code == 405:
            allowed = ", ".join(methods_at(routes, request.scope))
            error = HTTPException(405, f"this takes {allowed}", {"Allow": allowed})
        elif error.status_code == 404 and error.detail == HTTPStatus.NOT_FOUND.phrase:
            other = meant(routes, request.scope)
            advice = f"did you mean {other}?" if other else f"{PREFIX}/openapi.json names what there is"
            error = HTTPException(404, f"there is nothing at this path; {advice}")
        return of_http(error, request.url.path)

    @app.exception_handler(OperationalError)
    @app.exception_handler(InterfaceError)
    def _database(request: Request, error: Any) -> JSONResponse:
        return of_error(away(error), request.url.path)

    @app.exception_handler(IntegrityError)
    def _gone(request: Request, error: IntegrityError) -> JSONResponse:
        if not refers_to_nothing(error):
            return _defect(request, error)
        detail = "what this refers to was deleted at this moment; read it again"
        return of_error(Conflict(detail), request.url.path)

    @app.exception_handler(DataError)
    def _unstorable(request: Request, error: DataError) -> JSONResponse:
        detail = "a value cannot be stored: a control character, or a number out of range"
        return problem_response(422, "unstorable", "The request breaks a rule", detail, instance=request.url.path)

    @app.exception_handler(OSError)
    @app.exception_handler(Exception)
    def _defect(request: Request, error: Exception) -> JSONResponse:
        if no_room(error):
            return of_error(
                DiskFull("the disk is full; the same request works as soon as there is room"), request.url.path
            )
        log.error("%s %s failed", request.method, request.url.path, exc_info=error)
        detail = "This is a defect of the service, not of your input. Its log names the cause."
        return problem_response(500, "internal", "Internal error", detail, instance=request.url.path)
