"""What the service answers when it cannot do what was asked, in words a person can act on."""

from __future__ import annotations

from typing import Any

import httpx

from exogauge.client.things import Job
from exogauge.errors import ExogaugeError


class ClientProblem(ExogaugeError):
    """An RFC 9457 answer. `status`, `title`, `detail`, and `errors` with file, row, column, value where known."""

    def __init__(self, status: int, title: str, detail: str = "", errors: list[dict[str, Any]] | None = None) -> None:
        self.status, self.title, self.detail, self.errors = status, title, detail, errors or []
        lines = [f"{title} ({status})" if status else title]
        if detail and detail != title:
            lines[0] += f": {detail}"
        told = [readable(error) for error in self.errors]
        super().__init__("\n".join(lines + [f"  - {text}" for text in told if text != detail]))


def problem_of_job(job: Job) -> ClientProblem:
    """Why a job that has ended did not succeed."""
    told = job.problem or {}
    detail = str(told.get("detail") or job.reason or "")
    return ClientProblem(0, f"the job {job.state}", detail, list(told.get("errors") or []))


def readable(error: dict[str, Any]) -> str:
    """One entry of `errors` as a sentence: where, what, with which value, what to do."""
    place = [str(error["file"])] if error.get("file") else []
    if error.get("row") is not None:
        place.append(f"row {error['row']}")
    if error.get("column"):
        place.append(f"column {error['column']!r}")
    if not place and error.get("pointer"):
        place.append(str(error["pointer"]))
    text = ": ".join([", ".join(place), str(error.get("detail", ""))] if place else [str(error.get("detail", ""))])
    if error.get("value") is not None:
        text += f" (value: {error['value']})"
    return f"{text}. {error['advice']}" if error.get("advice") else text


def problem_of(response: httpx.Response) -> ClientProblem:
    """The problem in a 4xx or 5xx answer; an answer that is no problem document is quoted."""
    try:
        body = response.json()
    except ValueError:
        body = None
    if not isinstance(body, dict):
        return ClientProblem(response.status_code, response.reason_phrase or "error", response.text[:500])
    return ClientProblem(
        response.status_code,
        str(body.get("title", response.reason_phrase)),
        str(body.get("detail") or ""),
        [error for error in body.get("errors") or [] if isinstance(error, dict)],
    )
