"""What the service answers when it cannot do what was asked, in words a person can act on."""

from __future__ import annotations

import re
from typing import Any, final

import httpx

from exogauge.client.things import Job
from exogauge.errors import ExogaugeError

BUSY = {429, 502, 503, 504}
QUOTED = 200  # letters of an answer that is none of ours


class ClientProblem(ExogaugeError):
    """An RFC 9457 answer. `status`, `title`, `detail`, and `errors` with file, row, column, value where known."""

    def __init__(self, status: int, title: str, detail: str = "", errors: list[dict[str, Any]] | None = None) -> None:
        self.status, self.title, self.detail, self.errors = status, title, detail, errors or []
        lines = [f"{title} ({status})" if status else title]
        if detail and detail != title:
            lines[0] += f": {detail}"
        told = [readable(error) for error in self.errors]
        super().__init__("\n".join(lines + [f"  - {text}" for text in told if text != detail]))

    @property
    def later(self) -> bool:
        """Whether the same may do, asked again later."""
        return self.status in BUSY


@final
class NotNow(ClientProblem):
    """No answer, or none in the time given."""

    @property
    def later(self) -> bool:
        return True


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
    """The problem in a 4xx or 5xx answer; an answer that is no problem document is told as one of somebody else."""
    try:
        body = response.json()
    except ValueError:
        body = None
    if not isinstance(body, dict):
        return foreign(response)
    return ClientProblem(
        response.status_code,
        str(body.get("title", response.reason_phrase)),
        str(body.get("detail") or ""),
        [error for error in body.get("errors") or [] if isinstance(error, dict)],
    )


def foreign(response: httpx.Response) -> ClientProblem:
    """An answer that exogauge does not give: of a proxy before it, or of whatever else is at the address."""
    status, kind = response.status_code, response.headers.get("content-type", "").partition(";")[0]
    if response.is_redirect:
        there = plain(response.headers.get("location", ""))
        advice = "Give the address that it leads to; where that asks to sign in, a proxy does not let programs pass"
        return ClientProblem(status, f"{response.url.host} leads elsewhere", f"to {there}. {advice}")
    said = plain(response.text)
    told = f"{kind or 'nothing'}{f', {said!r}' if said else ''}"
    if response.is_success:
        advice = "Is it the address of the service, and does a proxy before it ask to sign in?"
        return ClientProblem(status, f"{response.url.host} does not answer as exogauge does", f"{told}. {advice}")
    return ClientProblem(status, response.reason_phrase or "error", f"not by exogauge: {told}")


def plain(text: str) -> str:
    """The first words of a page, without what a terminal would act on."""
    words = re.sub(r"(?is)<(script|style)\b.*?</\1>|<[^>]*>|\x1b\[[0-9;]*[a-z]", " ", text[: 50 * QUOTED]).split()
    return "".join(each for each in " ".join(words) if each.isprintable())[:QUOTED]
